// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/light_end.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <variant>

namespace photic {

double LightEnd::distance(const glm::dvec3& origin, const glm::dvec3& direction, const RayHit& hit) const {
    if (!hit) return std::numeric_limits<double>::infinity();
    if (hit.target.kind == Target::Kind::Surface) return hit.distance;
    const Object& object = scene_.objects[static_cast<std::size_t>(hit.target.index)];
    if (!object.receives()) return hit.distance;
    const glm::dvec3 normal = frame_.indexNormal(hit.normal);
    const glm::dvec3 along = frame_.indexDirection(direction);
    const int axis = mainAxis(normal);
    const double metres_per_voxel = 1 / std::fabs(along[mainAxis(along)]);
    const bool plane = std::holds_alternative<Plane>(object.shape);
    const double behind = plane ? behindPlane(axis) : kOvershootVoxels,
                 longest = plane ? longestBehindPlane(axis) : kMaxOvershootVoxels;
    const glm::dvec3 point = origin + hit.distance * direction;
    double end = hit.distance + longest * metres_per_voxel;
    if (along[axis] != 0) {
        // The hit voxel is the one that the leg comes from: a face on a voxel border must not fall to rounding.
        constexpr double kBorder = 1e-3;
        const double at = frame_.indexFromWorld(point)[axis] + 0.5;
        // A hair short of the last layer's far side, which rounding must not push into the next.
        constexpr double kShort = 1e-9;
        const double side = along[axis] > 0 ? std::floor(at - kBorder) + 1 + behind - kShort
                                            : std::floor(at + kBorder) - behind + kShort;
        end = std::min(end, hit.distance + (side - at) / along[axis]);
    }
    if (plane) {
        // In a corner of planes that are both looked up, light goes on behind both, whatever else stands in the scene.
        for (const Object& other : scene_.objects)
            if (const auto* stop = std::get_if<Plane>(&other.shape); stop && !other.receives()) {
                const double t = glm::dot(stop->point - point, stop->normal) / glm::dot(direction, stop->normal);
                if (t > 0) end = std::min(end, hit.distance + t);
            }
        if (caster_.planesOnly()) return end;
    }
    return hit.distance + throughSolids(point, direction, hit.target, end - hit.distance);
}

double LightEnd::throughSolids(const glm::dvec3& point, const glm::dvec3& direction, const Target& first,
                               double end) const {
    const bool plane = std::holds_alternative<Plane>(scene_.objects[static_cast<std::size_t>(first.index)].shape);
    const EndlessPlanes planes = plane ? EndlessPlanes::LeftOut : EndlessPlanes::Met;
    RayHit next = caster_.firstHit(point, direction, end, planes);
    if (!next) return end;
    const glm::dvec3 along = frame_.indexDirection(direction);
    const double voxel = 1 / std::fabs(along[mainAxis(along)]);  // [m] along the leg
    // Past a face, and past others that lie in it.
    const double hair = 1e-3 * voxel;
    const glm::dvec3 before = point - hair * direction;
    const auto blocks = [&](const Target& target) {
        return target.kind == Target::Kind::Object &&
               !scene_.objects[static_cast<std::size_t>(target.index)].receives();
    };
    double met = next.distance;
    if (next.target == first || insideSolid(point + hair * direction, direction, before)) {
        // Few faces lie within some voxels of a corner; where more do, light ends early.
        constexpr int kMostFaces = 8;
        for (int faces = 0; faces < kMostFaces; ++faces) {
            const glm::dvec3 past = point + (met + hair) * direction;
            if ((plane && blocks(next.target)) || !insideSolid(past, direction, before)) break;
            next = caster_.firstHit(past, direction, end - (met + hair), planes);
            if (!next) return end;
            met += hair + next.distance;
        }
    }
    if (next.target != first) return met;
    const double thin = std::min(end, kThinVoxels * voxel);
    if (met >= thin) return met;
    const RayHit beyond = caster_.firstHit(point + met * direction, direction, thin - met, planes);
    return beyond && beyond.target != first ? met + beyond.distance : thin;
}

bool LightEnd::insideSolid(const glm::dvec3& point, const glm::dvec3& direction, const glm::dvec3& outside) const {
    for (const Object& object : scene_.objects)
        if (const auto* plane = std::get_if<Plane>(&object.shape); plane && object.blocks()) {
            const double here = glm::dot(plane->normal, point - plane->point),
                         there = glm::dot(plane->normal, outside - plane->point);
            if (here * there < 0) return true;
        }
    return caster_.insideBody(point, direction);
}

}  // namespace photic
