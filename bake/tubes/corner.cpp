// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/corner.h"

#include <glm/geometric.hpp>
#include <limits>

namespace photic {

CornerTracer::CornerTracer(const Scene& scene, const Surface& surface, const glm::dvec3& light_direction, Branch branch,
                           const GridFrame& frame, const RayCaster& objects, const RayCaster& meshes)
    : surface_(surface),
      light_direction_(light_direction),
      branch_(branch),
      objects_(objects),
      meshes_(meshes),
      track_end_(frame) {
    for (const Object& object : scene.objects)
        if (const Plane* plane = std::get_if<Plane>(&object.shape); plane && object.blocks()) planes_.push_back(*plane);
}

Corner CornerTracer::trace(const SurfaceParam& param, const glm::dvec3& face) const {
    if (!surface_.height_field) {
        const double length = glm::length(param.normal);
        const bool usable = length > 0 && glm::dot(param.normal, face) > 0;
        return traceAt(param, param.position, usable ? param.normal / length : face, face);
    }
    const SurfacePoint point = surface_.height_field->at({param.position.x, param.position.y});
    const glm::dvec3 normal = glm::normalize(point.normal);
    return traceAt(param, point.position, normal, normal);
}

Corner CornerTracer::traceAt(const SurfaceParam& param, const glm::dvec3& position, const glm::dvec3& normal,
                             const glm::dvec3& face) const {
    Corner corner;
    corner.param = param;
    corner.position = position;
    corner.hit_distance = corner.end_distance = std::numeric_limits<double>::infinity();
    const SpecularEvent event = specularEvent(surface_, light_direction_, normal, face);
    corner.untraced = event.untraced;
    corner.dropped = event.dropped;
    const bool from_above = glm::dot(light_direction_, face) < 0;
    for (int b = 0; b < event.count; ++b) {
        const SpecularBranch& way = event.branches[static_cast<std::size_t>(b)];
        const bool refracted = way.below == from_above;
        if (refracted != (branch_ == Branch::Refracted)) continue;
        corner.direction = way.direction;
        corner.fraction = way.fraction;
    }
    if (!meshes_.empty() && meshes_.firstHit(position, -light_direction_)) {
        corner.fate = CornerFate::Hidden;
        return corner;
    }
    if (!objects_.empty() && objects_.firstHit(position, -light_direction_)) {
        corner.fate = CornerFate::Blocked;
        return corner;
    }
    if (corner.fraction <= 0) return corner;
    corner.fate = CornerFate::Lit;
    RayHit hit;
    if (!objects_.empty()) hit = objects_.firstHit(position, corner.direction);
    corner.end_object = hit.object;
    if (!meshes_.empty()) {
        const RayHit second = meshes_.firstHit(position, corner.direction, hit.distance);
        if (second) hit = second, corner.end_object = Corner::kEndsOnSurface;
    }
    corner.hit_distance = hit.distance;
    // Light that meets a second specular surface stops there: nothing receives it, so there is no overshoot.
    corner.end_distance =
        corner.end_object == Corner::kEndsOnSurface ? hit.distance : track_end_(position, corner.direction, hit);
    return corner;
}

}  // namespace photic
