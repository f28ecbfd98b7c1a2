// SPDX-License-Identifier: Apache-2.0
#include "bake/field/scene_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "bake/field/floor_div.h"
#include "bake/optics/snell.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr double kMaxVoxels = 274877906944.0;  // 2^38: 4.4 TB of light if every voxel held some
constexpr double kMaxIndex = 1 << 28;          // indices stay far from the ends of 32 bits, leaf arithmetic included
constexpr double kTolerance = 1e-6;            // [voxels] bounds this close to a voxel's side lie on it

// The mean normal of a surface, upwards where it has no mesh; none of a closed mesh, whose normals cancel.
std::optional<glm::dvec3> meanNormal(const Surface& surface) {
    if (!surface.mesh) return glm::dvec3(0, 0, 1);
    constexpr double kClosed = 1e-6;  // of all areas: what is left of their sum is rounding
    glm::dvec3 sum(0);
    double areas = 0;
    const auto& p = surface.mesh->positions;
    for (const auto& t : surface.mesh->triangles) {
        const glm::dvec3 area = glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
        sum += area, areas += glm::length(area);
    }
    if (!(glm::length(sum) > kClosed * areas)) return std::nullopt;
    return glm::normalize(sum);
}

// The mean direction in which a flat surface sends the strongest light, as dx/dz and dy/dz; its own beside a closed
// body, which sends it every way.
glm::dvec2 shearAlongLight(const Scene& scene) {
    if (scene.lights.empty())
        throw Error(ErrorCode::Input, "shear = \"light\" needs a light; add a [[light]] or use shear = \"none\"",
                    scene.file);
    const auto strength = [](const Light& l) { return l.irradiance.x + l.irradiance.y + l.irradiance.z; };
    const Light& light = *std::max_element(scene.lights.begin(), scene.lights.end(),
                                           [&](const Light& a, const Light& b) { return strength(a) < strength(b); });
    glm::dvec3 direction = glm::normalize(light.direction);
    const std::optional<glm::dvec3> mean = scene.surfaces.empty() ? std::nullopt : meanNormal(scene.surfaces.front());
    if (mean) {
        const Surface& surface = scene.surfaces.front();
        const glm::dvec3 normal = *mean;
        const bool from_front = glm::dot(direction, normal) < 0;
        const Interface crossing =
            interfaceAt(direction, from_front ? normal : -normal, from_front ? surface.ior_above : surface.ior_below,
                        from_front ? surface.ior_below : surface.ior_above);
        const bool refracts = surface.event != SurfaceEvent::Reflect && glm::length(crossing.refracted) > 0;
        direction = refracts ? crossing.refracted : crossing.reflected;
    }
    if (std::fabs(direction.z) < 0.1)
        throw Error(
            ErrorCode::Input,
            fmt::format(
                "shear = \"light\" would lean the grid along ({:.3g}, {:.3g}, {:.3g}), less than 6 degrees from the "
                "horizon; use shear = \"none\"",
                direction.x, direction.y, direction.z),
            scene.file);
    return glm::dvec2(direction) / direction.z;
}

// How far to move the indices along an axis, 0..7, so that the bands around receivers that lie across it fill the
// fewest leaves: a thin band that straddles two rows of leaves costs twice the memory and nearly twice the time.
int leafOffset(const Scene& scene, const GridFrame& frame, int axis) {
    int best = 0, fewest = 0;
    for (int offset = 0; offset < 8; ++offset) {
        int leaves = 0;
        for (const Object& object : scene.objects) {
            const Plane* plane = std::get_if<Plane>(&object.shape);
            if (!plane || !object.receives()) continue;
            const glm::dvec3 m = frame.indexNormal(plane->normal);
            if (std::fabs(m[axis]) < (1 - kTolerance) * glm::length(m)) continue;
            const double middle = glm::dot(plane->normal, plane->point - frame.origin_world) / m[axis],
                         band = scene.bake.band;
            const int low = std::max(static_cast<int>(std::ceil(middle - band - kTolerance)), frame.min[axis]);
            const int high = std::min(static_cast<int>(std::floor(middle + band + kTolerance)), frame.max[axis]);
            if (low <= high) leaves += floorDiv(high + offset, 8) - floorDiv(low + offset, 8) + 1;
        }
        if (offset == 0 || leaves < fewest) best = offset, fewest = leaves;
    }
    return best;
}

// A voxel size with two significant digits, rounded up.
double roundedUp(double size) {
    const double unit = std::pow(10.0, std::floor(std::log10(size)) - 1);
    return std::ceil(size / unit) * unit;
}

void checkDomain(const Scene& scene, double layer) {
    const Domain& domain = scene.domain;
    const double h = domain.voxel_size;
    if (!(h > 0) || !std::isfinite(h) || !(layer > 0) || !std::isfinite(layer))
        throw Error(ErrorCode::Input,
                    fmt::format("voxel_size is {} m and layer_height {} m; both must be positive", h, layer),
                    scene.file);
    for (int a = 0; a < 3; ++a)
        if (!(domain.max[a] > domain.min[a]) || !std::isfinite(domain.max[a] - domain.min[a]))
            throw Error(ErrorCode::Input,
                        fmt::format("the domain is empty along {}: min {} m, max {} m; max must exceed min", "xyz"[a],
                                    domain.min[a], domain.max[a]),
                        scene.file);
}

/// Metres along x and y for each metre up.
glm::dvec2 shearOf(const Scene& scene) {
    glm::dvec2 shear(0);
    if (scene.domain.shear_mode == ShearMode::Explicit) shear = scene.domain.shear;
    if (scene.domain.shear_mode == ShearMode::Light) shear = shearAlongLight(scene);
    if (!(std::fabs(shear.x) <= 10) || !(std::fabs(shear.y) <= 10))
        throw Error(ErrorCode::Input,
                    fmt::format("shear [{}, {}] exceeds 10 (6 degrees from the horizon); use less, or \"none\"",
                                shear.x, shear.y),
                    scene.file);
    return shear;
}

/// First and last voxel of a grid, as floating-point numbers, which hold any.
struct VoxelRange {
    glm::dvec3 first, last;
};

/// The domain's box in cell coordinates, in which voxel i covers [i, i + 1].
VoxelRange voxelsOf(const Domain& domain, const glm::dvec2& shear, double layer) {
    const double h = domain.voxel_size;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? domain.max.x : domain.min.x, corner & 2 ? domain.max.y : domain.min.y,
                           corner & 4 ? domain.max.z : domain.min.z);
        const glm::dvec3 cell((p.x - shear.x * p.z) / h, (p.y - shear.y * p.z) / h, p.z / layer);
        low = glm::min(low, cell), high = glm::max(high, cell);
    }
    const glm::dvec3 first = glm::floor(low + kTolerance);
    return {first, glm::max(glm::ceil(high - kTolerance) - 1.0, first)};
}

/// Neither more voxels than a grid can have, nor further from the origin than an index reaches.
void checkVoxels(const Scene& scene, const VoxelRange& range) {
    const double h = scene.domain.voxel_size;
    const glm::dvec3 size = range.last - range.first + 1.0;
    const double voxels = size.x * size.y * size.z;
    if (!(voxels <= kMaxVoxels)) {
        const double fits = roundedUp(1.001 * h * std::cbrt(voxels / kMaxVoxels));
        throw Error(ErrorCode::Input,
                    fmt::format("voxel_size {} m makes {:.6g} x {:.6g} x {:.6g} = {:.3g} voxels, more than {:.3g}; use "
                                "voxel_size = {:.3g}{} or "
                                "a smaller domain",
                                h, size.x, size.y, size.z, voxels, kMaxVoxels, fits,
                                scene.domain.layer_height > 0 ? " with layer_height in proportion" : ""),
                    scene.file);
    }
    for (int a = 0; a < 3; ++a) {
        const double furthest = std::max(std::fabs(range.first[a]), std::fabs(range.last[a]));
        if (furthest > kMaxIndex)
            throw Error(ErrorCode::Input,
                        fmt::format("the domain's {} side lies {:.3g} voxels from the origin, more than {:.3g}; move "
                                    "the scene closer to it",
                                    "xyz"[a], furthest, kMaxIndex),
                        scene.file);
    }
}

}  // namespace

GridFrame sceneFrame(const Scene& scene) {
    const double h = scene.domain.voxel_size, layer = scene.domain.layer_height > 0 ? scene.domain.layer_height : h;
    checkDomain(scene, layer);
    const glm::dvec2 shear = shearOf(scene);
    GridFrame frame;
    frame.setWorldFromIndex({glm::dvec3(h, 0, 0), glm::dvec3(0, h, 0), glm::dvec3(shear * layer, layer)});
    frame.origin_world = frame.worldFromIndex() * glm::dvec3(0.5);
    const VoxelRange range = voxelsOf(scene.domain, shear, layer);
    checkVoxels(scene, range);
    frame.min = glm::ivec3(range.first), frame.max = glm::ivec3(range.last);
    if (scene.bake.where == Where::Receivers) {
        glm::ivec3 offset;
        for (int a = 0; a < 3; ++a) offset[a] = leafOffset(scene, frame, a);
        frame.min += offset, frame.max += offset;
        frame.origin_world -= frame.worldFromIndex() * glm::dvec3(offset);
    }
    return frame;
}

}  // namespace photic
