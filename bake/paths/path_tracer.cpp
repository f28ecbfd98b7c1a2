// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/path_tracer.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace photic {

// Lets the branch of one event go on from where the path stands.
void PathTracer::takeEvent(const PathEvent& event, const glm::dvec3& direction, const Meeting& at, Path& path) const {
    const OpticalScene::Event all = optics_.eventAt(event.surface, wavelength_, path.inside, direction, at);
    path.position = at.position;
    path.untraced = all.light.untraced, path.dropped = all.light.dropped, path.absorbed = all.light.absorbed;
    path.fraction = glm::dvec3(0), path.direction = glm::dvec3(0);
    if (all.void_surface) {
        // Of a body that only reflects nobody follows what passes on: where it is folded over itself, at its rim.
        const bool only_reflects =
            optics_.scene().surfaces[static_cast<std::size_t>(event.surface)].event == SurfaceEvent::Reflect;
        if (only_reflects) path.dropped = 1;
        if (only_reflects || event.branch != Branch::Refracted) return;
        path.direction = direction, path.fraction = glm::dvec3(1), path.inside = all.beyond;
        path.medium = optics_.mediumOf(path.inside);
        return;
    }
    for (int b = 0; b < all.light.count; ++b) {
        const SpecularBranch& way = all.light.branches[static_cast<std::size_t>(b)];
        if (way.crosses != (event.branch == Branch::Refracted)) continue;
        path.direction = way.direction, path.fraction = way.fraction;
        if (way.crosses) path.inside = all.beyond;
        path.medium = optics_.mediumOf(path.inside);
        return;
    }
}

// Runs the leg that was the last to the surface of the next event, and takes that; false when it meets something else.
bool PathTracer::goOn(const PathEvent& event, Path& path) const {
    const OpticalScene::LegEnd end = optics_.legEnd(path.position, path.direction, path.inside);
    if (end.hit.target != Target{Target::Kind::Surface, event.surface}) return false;
    const OpticalMedium& medium = optics_.medium(path.medium);
    for (int c = 0; c < 3; ++c)
        path.arriving[c] *=
            path.fraction[c] * std::exp(-(medium.absorption[c] + medium.scattering[c]) * end.hit.distance);
    path.inside = end.inside;
    takeEvent(event, path.direction, end.meeting, path);
    return true;
}

Path PathTracer::follow(const EmissionParam& param, const EmittedRay& ray) const {
    Path path;
    path.param = param;
    path.outcome = optics_.arrivalOn(emission_.surfaceIndex(), ray.position, ray.direction, emission_.sample().source);
    followHistory(ray, path);
    return path;
}

// From the light itself to whatever it meets first.
Path PathTracer::traceAcross(const EmissionParam& param) const {
    const glm::dvec3 point = emission_.planePoint(param), direction = emission_.directionAt(point);
    const auto& source = emission_.sample().source;
    const glm::dvec3 start = source ? *source : point - (optics_.caster().reachFrom(point) + 1) * direction;
    Path path;
    path.param = param, path.entry = point;
    Meeting at;
    constexpr double kEverywhere = std::numeric_limits<double>::infinity();
    const glm::dvec3* sun = source ? nullptr : optics_.partedSun(direction);
    const EndlessPlanes planes = sun ? EndlessPlanes::LeftOut : EndlessPlanes::Met;
    const RayHit hit = optics_.firstHit(start, direction, kEverywhere, at, planes);
    path.outcome = PathOutcome::Missed;
    if (hit.target != Target{Target::Kind::Surface, history_.front().surface}) return path;
    // Planes and water have no end: they may stand farther from here than all bodies do.
    Meeting unused;
    if (!source && optics_.standsEndless() && optics_.firstHit(start, -direction, kEverywhere, unused, planes))
        return path;
    if (sun && optics_.caster().planeStandsBefore(at.position, *sun)) return path;
    path.outcome = PathOutcome::Lit;
    followHistory({at.position, direction, at.normal, at.face}, path);
    return path;
}

// All events of a path whose outcome at the first surface is known.
void PathTracer::followHistory(const EmittedRay& ray, Path& path) const {
    path.entry = ray.position;
    path.facing = -glm::dot(ray.direction, ray.normal);
    const std::optional<glm::dvec3>& source = emission_.sample().source;
    path.inside = optics_.startingInside(history_.front().surface, ray.direction, ray.face, source);
    path.first_medium = optics_.mediumOf(path.inside);
    if (source) path.arriving = optics_.leftOnTheWay(path.inside, glm::length(ray.position - *source));
    takeEvent(history_.front(), ray.direction, {ray.position, ray.normal, ray.face}, path);
    if (path.outcome != PathOutcome::Lit) return;
    path.outcome = PathOutcome::Dark;
    for (std::size_t i = 1; i < history_.size(); ++i)
        if (path.dark() || !goOn(history_[i], path)) {
            // Not a path of this history: a shorter one has counted what becomes of it.
            path.arriving = path.fraction = path.direction = glm::dvec3(0);
            return;
        }
    if (path.dark()) return;
    path.outcome = PathOutcome::Lit;
    const OpticalScene::LegEnd end = optics_.legEnd(path.position, path.direction, path.inside);
    path.end = end.hit.target, path.end_triangle = end.hit.triangle;
    path.hit_distance = end.hit.distance, path.end_distance = end.deposit_end;
}

}  // namespace photic
