// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/path_tracer.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace photic {
namespace {

// The smooth normal where a ray met a mesh, and the flat one, both on the side of ior_above.
void normalsAt(const TriangleMesh& mesh, const RayHit& hit, glm::dvec3& normal, glm::dvec3& face) {
    const auto& t = mesh.triangles[hit.triangle];
    const glm::dvec3 cross =
        glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    face = glm::length(cross) > 0 ? glm::normalize(cross) : hit.normal;
    const double wb = hit.barycentric.x, wc = hit.barycentric.y;
    normal = (1 - wb - wc) * mesh.normals[t[0]] + wb * mesh.normals[t[1]] + wc * mesh.normals[t[2]];
    const double length = glm::length(normal);
    normal = length > 0 && glm::dot(normal, face) > 0 ? normal / length : face;
}

}  // namespace

// Lets the branch of one event go on from where the path stands.
void PathTracer::takeEvent(const PathEvent& event, const glm::dvec3& direction, const glm::dvec3& normal,
                           const glm::dvec3& face, Path& path) const {
    const Surface& surface = optics_.scene().surfaces[static_cast<std::size_t>(event.surface)];
    const SpecularEvent all = specularEvent(surface, direction, normal, face);
    const bool from_above = glm::dot(direction, face) < 0;
    path.untraced = all.untraced, path.dropped = all.dropped;
    path.fraction = 0, path.direction = glm::dvec3(0);
    const MediumSides& sides = optics_.sides(event.surface);
    for (int b = 0; b < all.count; ++b) {
        const SpecularBranch& way = all.branches[static_cast<std::size_t>(b)];
        const bool refracted = way.below == from_above;
        if (refracted != (event.branch == Branch::Refracted)) continue;
        path.direction = way.direction, path.fraction = way.fraction;
        path.medium = way.below ? sides.inside : sides.outside;
    }
}

// Runs the leg that was the last to the surface of the next event, and takes that; false when it meets something else.
bool PathTracer::goOn(const PathEvent& event, Path& path) const {
    const RayHit hit = optics_.caster().firstHit(path.position, path.direction);
    if (hit.target != Target{Target::Kind::Surface, event.surface}) return false;
    const OpticalMedium& medium = optics_.medium(path.medium);
    for (int c = 0; c < 3; ++c)
        path.arriving[c] *= path.fraction * std::exp(-(medium.absorption[c] + medium.scattering[c]) * hit.distance);
    glm::dvec3 normal, face;
    normalsAt(*optics_.scene().surfaces[static_cast<std::size_t>(event.surface)].mesh, hit, normal, face);
    path.position += hit.distance * path.direction;
    takeEvent(event, path.direction, normal, face, path);
    return true;
}

Path PathTracer::follow(const EmissionParam& param, const EmittedRay& ray) const {
    Path path;
    path.param = param;
    path.entry = path.position = ray.position;
    takeEvent(history_.front(), ray.direction, ray.normal, ray.face, path);
    path.outcome = optics_.arrival(ray.position, ray.direction);
    if (path.outcome != PathOutcome::Lit) return path;
    path.outcome = PathOutcome::Dark;
    for (std::size_t i = 1; i < history_.size(); ++i)
        if (path.fraction <= 0 || !goOn(history_[i], path)) {
            // Not a path of this history: a shorter one has counted what becomes of it.
            path.arriving = glm::dvec3(0), path.fraction = 0, path.direction = glm::dvec3(0);
            return path;
        }
    if (path.fraction <= 0) return path;
    path.outcome = PathOutcome::Lit;
    const OpticalScene::LegEnd end = optics_.legEnd(path.position, path.direction);
    path.end = end.hit.target, path.end_triangle = end.hit.triangle;
    path.hit_distance = end.hit.distance, path.end_distance = end.deposit_end;
    return path;
}

}  // namespace photic
