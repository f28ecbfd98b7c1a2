// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/light_bounds.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"

namespace photic {
namespace {

// Sizes of the mirrors, or of the water over a lamp, that their light is followed over, where receivers go on.
constexpr double kReach = 2;

Bounds3 boundsOf(const TriangleMesh& mesh) {
    Bounds3 box;
    for (const glm::dvec3& p : mesh.positions) box.add(p);
    return box;
}

/// The patch of a height field as far as samples of it reach: bounds of splines may be far beyond them.
Bounds3 sampledBounds(const Surface& surface) {
    constexpr double kMostSamples = 512;  // a side
    const HeightField& field = *surface.height_field;
    const glm::dvec2 low = glm::dvec2(surface.center) - 0.5 * surface.size;
    const glm::ivec2 count(glm::clamp(glm::ceil(surface.size / field.featureSize()), 1.0, kMostSamples));
    Bounds3 box;
    SurfaceRow row;
    for (int j = 0; j <= count.y; ++j) {
        field.row({low.x, low.y + surface.size.y * j / count.y}, surface.size.x / count.x,
                  static_cast<std::size_t>(count.x) + 1, row);
        for (std::size_t i = 0; i < row.pz.size(); ++i) box.add({row.px[i], row.py[i], row.pz[i]});
    }
    return box;
}

/// Everything that bends light.
/// @param sampled  water by its samples, and not by its bounds
Bounds3 bendingBounds(const Scene& scene, bool sampled) {
    Bounds3 box;
    for (const Surface& surface : scene.surfaces) {
        if (surface.mesh) {
            const Bounds3 mesh = boundsOf(*surface.mesh);
            box.add(mesh.min), box.add(mesh.max);
        } else if (sampled) {
            const Bounds3 water = sampledBounds(surface);
            box.add(water.min), box.add(water.max);
        } else {
            const glm::dvec2 half = 0.5 * surface.size + surface.height_field->maxDisplacement();
            box.add({glm::dvec2(surface.center) - half, surface.height_field->minZ()});
            box.add({glm::dvec2(surface.center) + half, surface.height_field->maxZ()});
        }
    }
    if (scene.index)
        for (const GradedObject& object : scene.index->objects())
            for (const auto& index : object.index)
                if (const auto bounds = index->bounds()) box.add(bounds->min), box.add(bounds->max);
    return box;
}

/// Where a plane meets the sides of a box, along the axis nearest to its normal.
Bounds3 boundsOf(const Plane& plane, const Bounds3& box) {
    const glm::dvec3 n = glm::abs(plane.normal);
    const int axis = n.z >= n.x && n.z >= n.y ? 2 : n.y >= n.x ? 1 : 0;
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    Bounds3 out;
    for (int corner = 0; corner < 4; ++corner) {
        glm::dvec3 p;
        p[a] = corner & 1 ? box.max[a] : box.min[a], p[b] = corner & 2 ? box.max[b] : box.min[b];
        p[axis] = plane.point[axis] -
                  (plane.normal[a] * (p[a] - plane.point[a]) + plane.normal[b] * (p[b] - plane.point[b])) /
                      plane.normal[axis];
        out.add(p);
    }
    return out;
}

/// Bounds of each thing that receives light, of planes those within `box`.
std::vector<Bounds3> receiverBounds(const Scene& scene, const Bounds3& box) {
    std::vector<Bounds3> out;
    for (const Object& object : scene.objects) {
        if (!object.receives()) continue;
        const Plane* plane = std::get_if<Plane>(&object.shape);
        out.push_back(plane ? boundsOf(*plane, box)
                            : boundsOf(*std::get<std::shared_ptr<const TriangleMesh>>(object.shape)));
    }
    return out;
}

bool mirrors(const Surface& surface) {
    return surface.event == SurfaceEvent::Mirror || surface.event == SurfaceEvent::Reflect;
}

/// Whether a lamp stands in the water, whose light comes out of it.
bool shinesUp(const Scene& scene) {
    return std::any_of(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
        return light.position && std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [&](const Surface& surface) {
                   return surface.height_field && light.position->z < surface.height_field->maxZ();
               });
    });
}

/// Whether a surface lies across the way down, as open water does.
bool liesFlat(const Surface& surface) {
    if (surface.height_field) return true;
    glm::dvec3 sum(0);
    double area = 0;
    for (const auto& t : surface.mesh->triangles) {
        const glm::dvec3& a = surface.mesh->positions[t[0]];
        const glm::dvec3 cross = glm::cross(surface.mesh->positions[t[1]] - a, surface.mesh->positions[t[2]] - a);
        sum += cross, area += glm::length(cross);
    }
    return std::fabs(sum.z) > 0.5 * area;
}

/// Widens a box by where the lights throw the shadow of its top to its bottom.
void addShadow(const Scene& scene, Bounds3& box) {
    const Bounds3 body = box;
    const double depth = body.max.z - body.min.z;
    for (const Light& light : scene.lights)
        for (const glm::dvec3& corner : {body.min, body.max}) {
            glm::dvec3 travel = light.direction;
            if (light.position) travel = glm::dvec3(corner.x, corner.y, body.max.z) - *light.position;
            if (!(travel.z < 0)) continue;
            const glm::dvec2 shift = glm::dvec2(travel) / -travel.z * depth;
            box.add({glm::dvec2(corner) + shift, body.min.z});
        }
}

/// Narrows a box to the footprint of the fixed meshes that receive light: wide water over a small pool is no reason for
/// voxels.
void cropToReceivers(const Scene& scene, Bounds3& box) {
    Bounds3 fixed;
    for (const Object& object : scene.objects) {
        const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape);
        if (object.role != Role::Receiver) continue;
        if (!mesh) return;  // a plane goes on as far as the water does
        const Bounds3 bounds = boundsOf(**mesh);
        fixed.add(bounds.min), fixed.add(bounds.max);
    }
    if (fixed.empty()) return;
    const glm::dvec2 low = glm::max(glm::dvec2(box.min), glm::dvec2(fixed.min)),
                     high = glm::min(glm::dvec2(box.max), glm::dvec2(fixed.max));
    if (!(high.x > low.x && high.y > low.y)) return;
    box.min = {low, box.min.z}, box.max = {high, box.max.z};
}

}  // namespace

void Bounds3::add(const glm::dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }

Bounds3 sceneBounds(const Scene& scene) {
    Bounds3 box = bendingBounds(scene, false);
    for (const Object& object : scene.objects)
        if (const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape);
            mesh && object.receives())
            for (const glm::dvec3& p : (*mesh)->positions) box.add(p);
    if (box.empty()) return box;
    Bounds3 extended = box;
    for (const Object& object : scene.objects)
        if (const auto* plane = std::get_if<Plane>(&object.shape); plane && object.receives()) {
            const Bounds3 bounds = boundsOf(*plane, box);
            extended.add(bounds.min), extended.add(bounds.max);
        }
    return extended;
}

Bounds3 lightBounds(const Scene& scene) {
    const Bounds3 bending = bendingBounds(scene, true);
    if (bending.empty()) return bending;
    const bool goes_up = std::any_of(scene.surfaces.begin(), scene.surfaces.end(), mirrors) || shinesUp(scene);
    const bool open_water =
        !scene.surfaces.empty() && std::all_of(scene.surfaces.begin(), scene.surfaces.end(), liesFlat);
    const std::vector<Bounds3> receivers = receiverBounds(scene, bending);
    Bounds3 box = bending;
    for (const Bounds3& receiver : receivers) box.min.z = std::min(box.min.z, receiver.min.z);
    if (!open_water) addShadow(scene, box);
    if (goes_up) {
        const glm::dvec3 size = bending.max - bending.min;
        const double reach = kReach * std::max({size.x, size.y, size.z});
        for (const Bounds3& receiver : receivers) {
            box.min = glm::min(box.min, glm::max(receiver.min, bending.min - reach));
            box.max = glm::max(box.max, glm::min(receiver.max, bending.max + reach));
        }
    } else if (open_water && !scene.medium.present()) {
        cropToReceivers(scene, box);
    }
    return box;
}

}  // namespace photic
