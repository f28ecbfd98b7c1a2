// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/plausibility.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/scene/index_volume.h"
#include "bake/scene/plausible_shapes.h"
#include "bake/scene/surface_samples.h"

namespace photic {
namespace {

using Warnings = std::vector<std::string>;

bool refracts(const Surface& surface) {
    return surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
}

/// The sum of a mesh's area vectors, and of their lengths.
struct Facing {
    glm::dvec3 sum{0};
    double area = 0;
};
Facing facingOf(const TriangleMesh& mesh) {
    Facing facing;
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 a =
            0.5 * glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
        facing.sum += a, facing.area += glm::length(a);
    }
    return facing;
}

/// An open mesh that a sun lights from behind though it shines down: its faces are wound downwards.
void upsideDown(const Scene& scene, const Surface& surface, Warnings& out) {
    if (!surface.mesh || surface.closed || surface.thin || !refracts(surface)) return;
    if (facingOf(*surface.mesh).sum.z >= 0) return;
    for (const Light& light : scene.lights) {
        if (light.position || light.direction.z >= 0) continue;
        double above = 0, below = 0;
        for (const auto& t : surface.mesh->triangles) {
            const auto& p = surface.mesh->positions;
            const double across = -0.5 * glm::dot(light.direction, glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
            (across > 0 ? above : below) += std::fabs(across);
        }
        const double share = below / (above + below);
        if (share > 0.5)
            out.push_back(fmt::format(
                "{:.3g} % of the light of '{}' that falls on '{}' ({:.4g} W) arrives on the side of ior_below ({}), "
                "and is "
                "bent as out of it: the mesh lies upside down; turn its faces over (normals up) before export",
                100 * share, light.name, surface.name, meanIrradiance(light) * below, surface.ior_below));
    }
}

/// The only water of a scene, standing upright as a Y-up file does that is read as Z up.
void standsUpright(const Scene& scene, Warnings& out) {
    const Surface* water = nullptr;
    for (const Surface& surface : scene.surfaces) {
        if (!refracts(surface)) continue;
        if (water || surface.height_field) return;
        water = &surface;
    }
    if (!water || water->closed || water->thin) return;
    const Facing facing = facingOf(*water->mesh);
    const double share = facing.area > 0 ? std::fabs(facing.sum.y) / facing.area : 0;
    if (share > 0.8)
        out.push_back(
            fmt::format("'{}' stands upright: {:.3g} % of its area faces along y, as water does in files that are "
                        "Y up; if it is to lie level, give up = \"y\"",
                        water->name, 100 * share));
}

void indexBesideTheWater(const Scene& scene, Warnings& out) {
    if (!scene.index || !scene.index->objects().empty()) return;
    if (scene.surfaces.empty() || !scene.surfaces.front().height_field) return;
    const IndexVolume& index = *scene.index;
    const Surface& water = scene.surfaces.front();
    const glm::ivec3 size = index.size();
    constexpr int kMost = 32;  // samples along each axis
    std::size_t inside = 0, all = 0;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    const auto steps = [&](int axis) { return std::min(size[axis], kMost); };
    const auto at = [&](int axis, int i) {
        return steps(axis) > 1 ? i * double(size[axis] - 1) / (steps(axis) - 1) : 0.0;
    };
    for (int k = 0; k < steps(2); ++k)
        for (int j = 0; j < steps(1); ++j)
            for (int i = 0; i < steps(0); ++i) {
                glm::dvec3 p = index.place({at(0, i), at(1, j), at(2, k)});
                // Along an axis with one sample it is the same everywhere.
                for (int axis = 0; axis < 2; ++axis)
                    if (size[axis] == 1) p[axis] = water.center[axis];
                low = glm::min(low, p), high = glm::max(high, p), ++all;
                const bool in_box = glm::all(glm::greaterThanEqual(p, scene.domain.min)) &&
                                    glm::all(glm::lessThanEqual(p, scene.domain.max));
                inside += in_box && p.z <= water.height_field->at(glm::dvec2(p)).position.z;
            }
    const double share = double(inside) / double(all);
    if (share < 0.1)
        out.push_back(
            fmt::format("{} of the [[index]] lies in the water within the domain: the volume reaches from ({:.4g}, "
                        "{:.4g}, {:.4g}) to "
                        "({:.4g}, {:.4g}, {:.4g}) m, Z up; move it, or the domain",
                        inside == 0 ? "nothing" : fmt::format("only {:.2g} %", 100 * share), low.x, low.y, low.z,
                        high.x, high.y, high.z));
}

/// The box lies on one side of a surface or a receiver, or beside it.
void emptyDomain(const Scene& scene, Warnings& out) {
    const Domain& box = scene.domain;
    for (const Surface& surface : scene.surfaces) {
        if (!surface.height_field) continue;
        const bool down = surface.event == SurfaceEvent::Refract, up = surface.event == SurfaceEvent::Reflect;
        const double top = surface.height_field->maxZ(), bottom = surface.height_field->minZ();
        if (down && box.min.z >= top)
            out.push_back(
                fmt::format("0 % of the domain lies below '{}', where its light goes: the domain begins at z = "
                            "{:.4g} m, and the surface reaches up to {:.4g} m; lower min.z",
                            surface.name, box.min.z, top));
        if (up && box.max.z <= bottom)
            out.push_back(
                fmt::format("0 % of the domain lies above '{}', where its light goes: the domain ends at z = "
                            "{:.4g} m, and the surface reaches down to {:.4g} m; raise max.z",
                            surface.name, box.max.z, bottom));
    }
    for (const Object& object : scene.objects) {
        if (!object.receives()) continue;
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        bool meets = true;
        if (const auto* plane = std::get_if<Plane>(&object.shape)) {
            double least = std::numeric_limits<double>::infinity(), most = -least;
            for (int c = 0; c < 8; ++c) {
                const glm::dvec3 corner(c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y,
                                        c & 4 ? box.max.z : box.min.z);
                const double d = glm::dot(plane->normal, corner - plane->point);
                least = std::min(least, d), most = std::max(most, d);
            }
            meets = least <= 0 && most >= 0;
        } else {
            for (const glm::dvec3& p : std::get<std::shared_ptr<const TriangleMesh>>(object.shape)->positions)
                low = glm::min(low, p), high = glm::max(high, p);
            meets = glm::all(glm::lessThanEqual(low, box.max)) && glm::all(glm::greaterThanEqual(high, box.min));
        }
        if (!meets)
            out.push_back(
                fmt::format("0 % of the receiver '{}' lies in the domain, ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, "
                            "{:.4g}, {:.4g}) m: nothing is baked for it; enlarge the domain or move it",
                            object.name, box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z));
    }
}

/// Mean square change of a height field's slopes over a distance, over twice their variance: 0 where they are the same
/// there, 1 where they have nothing to do with one another.
double slopeChange(const Surface& surface, const std::vector<glm::dvec2>& places, double distance) {
    const auto slope = [&](glm::dvec2 uv) {
        const glm::dvec3 n = surface.height_field->at(uv).normal;
        return n.z > 0 ? glm::dvec2(-n.x / n.z, -n.y / n.z) : glm::dvec2(0);
    };
    glm::dvec2 sum(0);
    double squares = 0, change = 0;
    for (const glm::dvec2& uv : places) {
        const glm::dvec2 here = slope(uv);
        sum += here, squares += glm::dot(here, here);
        for (const glm::dvec2 step : {glm::dvec2(distance, 0), glm::dvec2(0, distance)}) {
            const glm::dvec2 d = slope(uv + step) - here;
            change += 0.5 * glm::dot(d, d);
        }
    }
    const double count = static_cast<double>(places.size());
    const double variance = squares / count - glm::dot(sum, sum) / (count * count);
    return variance > 1e-12 ? change / count / (2 * variance) : 0;
}

void finerThanVoxels(const Scene& scene, Warnings& out) {
    // A sine of six voxels has 0.25.
    constexpr double kTooMuch = 0.25, kGood = 0.08;
    const double voxel = scene.domain.voxel_size;
    for (const Surface& surface : scene.surfaces) {
        if (!surface.height_field || !std::isfinite(surface.height_field->featureSize())) continue;
        const std::vector<glm::dvec2> places = placesOn(surface, scene.domain, 1024);
        if (places.empty()) continue;
        const double change = slopeChange(surface, places, voxel);
        if (!(change > kTooMuch)) continue;
        double good = voxel;
        for (int halvings = 0; halvings < 12 && slopeChange(surface, places, good) > kGood; ++halvings) good /= 2;
        out.push_back(
            fmt::format("the slopes of '{}' change by {:.0f} % of their size from one voxel to the next: its "
                        "caustics are finer than voxels of {:.3g} m and are averaged away; use voxel_size = "
                        "{:.2g}, or a smoother surface",
                        surface.name, 100 * std::sqrt(2 * std::min(change, 1.0)), voxel, good));
    }
}

/// Light that comes from the denser side too slantingly to get out.
void totallyReflected(const Scene& scene, Warnings& out) {
    for (const Surface& surface : scene.surfaces) {
        if (surface.event != SurfaceEvent::Refract || surface.ior_above <= surface.ior_below || surface.closed)
            continue;
        const std::vector<SurfaceSample> samples = samplesOf(surface, scene.domain, 1024);
        for (const Light& light : scene.lights) {
            if (light.position) continue;
            double kept = 0, all = 0;
            for (const SurfaceSample& sample : samples) {
                const double cosine = -glm::dot(light.direction, sample.normal);
                if (cosine <= 0) continue;
                const double ratio = surface.ior_above / surface.ior_below;
                all += cosine * sample.area;
                kept += ratio * ratio * (1 - cosine * cosine) > 1 ? cosine * sample.area : 0;
            }
            if (all > 0 && kept > 0.99 * all)
                out.push_back(
                    fmt::format("{:.3g} % of the light of '{}' ({:.4g} W) is reflected totally at '{}', whose index "
                                "falls from {} to {}: next to nothing is left to bake; use event = \"reflect\", or a "
                                "steeper light",
                                100 * kept / all, light.name, meanIrradiance(light) * kept, surface.name,
                                surface.ior_above, surface.ior_below));
        }
    }
}

/// Planes without an end that stand between the sun and the water, as walls of a pool do that were meant to end above.
void endlessWalls(const Scene& scene, const Surface& surface, const Light& light, Warnings& out) {
    std::vector<const Object*> walls;
    for (const Object& object : scene.objects)
        if (std::holds_alternative<Plane>(object.shape) && object.role != Role::Movable) walls.push_back(&object);
    if (walls.empty()) return;
    const std::vector<SurfaceSample> samples = samplesOf(surface, scene.domain, 1024);
    std::vector<double> left;  // the light of each sample that no wall has been found to block
    double all = 0;
    for (const SurfaceSample& sample : samples) {
        left.push_back(std::max(0.0, -glm::dot(light.direction, sample.normal)) * sample.area);
        all += left.back();
    }
    // The wall that takes most of what is left first, so that a wall in another's shadow is not named.
    std::vector<std::string> names;
    double blocked = 0;
    const auto hides = [&](const Object& object, std::size_t i) {
        const Plane& plane = std::get<Plane>(object.shape);
        // Light that came from behind, in front of the wall; what lies behind it nobody looks at.
        return glm::dot(plane.normal, samples[i].position - plane.point) > 0 &&
               glm::dot(plane.normal, light.direction) > 0;
    };
    while (true) {
        const Object* worst = nullptr;
        double most = 0.01 * all;
        for (const Object* object : walls) {
            double taken = 0;
            for (std::size_t i = 0; i < samples.size(); ++i) taken += hides(*object, i) ? left[i] : 0;
            if (taken > most) most = taken, worst = object;
        }
        if (!worst) break;
        names.push_back(fmt::format("'{}'", worst->name)), blocked += most;
        for (std::size_t i = 0; i < samples.size(); ++i)
            if (hides(*worst, i)) left[i] = 0;
    }
    if (blocked > 0.05 * all)
        out.push_back(fmt::format(
            "{:.3g} % of the light of '{}' on '{}' ({:.4g} W in the domain) is blocked on its way by {}: planes have "
            "no end and reach above the water; use walls that end ('box', or a mesh), or role = \"movable\"",
            100 * blocked / all, light.name, surface.name, meanIrradiance(light) * blocked, fmt::join(names, ", ")));
}

}  // namespace

std::vector<std::string> sceneWarnings(const Scene& scene) {
    Warnings out;
    for (const Surface& surface : scene.surfaces) upsideDown(scene, surface, out);
    standsUpright(scene, out);
    indexBesideTheWater(scene, out);
    emptyDomain(scene, out);
    finerThanVoxels(scene, out);
    totallyReflected(scene, out);
    for (const Surface& surface : scene.surfaces)
        for (const Light& light : scene.lights)
            if (!surface.closed && !light.position) endlessWalls(scene, surface, light, out);
    const Warnings shapes = shapeWarnings(scene);
    out.insert(out.end(), shapes.begin(), shapes.end());
    return out;
}

}  // namespace photic
