// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/obstacles.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>

namespace photic {
namespace {

// Ends this close to their receiver are the receiver [voxels].
constexpr double kNear = 1.0;
// Receivers of many triangles are searched for gaps between paths that are further apart than this [voxels].
constexpr double kWide = 2.0;
// Of the width of a space between paths less than a voxel apart: gaps that reach across their edge are looked for, and
// not where the shadow ends beside it.
constexpr double kSlit = 0.1;
// Of the space's cross-section: what the receiver must show to count as whole.
constexpr double kWhole = 0.98;

double metresPerVoxel(const GridFrame& frame, const glm::dvec3& direction) {
    const glm::dvec3 d = frame.indexDirection(direction);
    return 1 / std::fabs(d[mainAxis(d)]);
}

}  // namespace

Obstacles::Obstacles(const PathTracer& tracer) : optics_(tracer.optics()), tracer_(tracer) {
    const auto isMesh = [&](const PathEvent& event) {
        return optics_.scene().surfaces[static_cast<std::size_t>(event.surface)].mesh != nullptr;
    };
    enters_on_mesh_ = isMesh(tracer.history().front()), leaves_mesh_ = isMesh(tracer.history().back());
    first_is_closed_ = tracer.surface().closed || tracer.surface().sphere.has_value();
    const auto include = [&](const glm::dvec3& low, const glm::dvec3& high) {
        const bool first = bodies_low_.x > bodies_high_.x;
        bodies_low_ = first ? low : glm::min(bodies_low_, low);
        bodies_high_ = first ? high : glm::max(bodies_high_, high);
    };
    for (const Surface& surface : optics_.scene().surfaces) {
        if (surface.sphere)
            include(surface.sphere->center - surface.sphere->radius, surface.sphere->center + surface.sphere->radius);
        else if (surface.mesh)
            for (const glm::dvec3& p : surface.mesh->positions) include(p, p);
    }
}

// A box that leans with the legs.
ConvexRegion Obstacles::spaceAround(const std::vector<Leg>& legs) const {
    ConvexRegion region;
    std::vector<glm::dvec3> starts, ends, points;
    glm::dvec3 along(0);
    for (const Leg& leg : legs) {
        starts.push_back(leg.start), ends.push_back(leg.end), along += leg.end - leg.start;
        region.include(leg.start), region.include(leg.end);
    }
    points = starts;
    points.insert(points.end(), ends.begin(), ends.end());
    region.addSide(-along, starts);
    const int axis = mainAxis(along);
    for (int other = 0; other < 3; ++other) {
        if (other == axis) continue;
        glm::dvec3 e(0);
        e[other] = 1;
        region.addSide(glm::cross(along, e), points), region.addSide(-glm::cross(along, e), points);
    }
    return region;
}

Obstacles::Kites Obstacles::kitesOf(const Leg& a, const Leg& b, double narrowed) const {
    Kites kites;
    const glm::dvec3 along = (a.end - a.start) + (b.end - b.start);
    if (glm::length(along) > 0) kites.along = glm::normalize(along);
    for (int k = 0; k < 2; ++k) {
        const glm::dvec3 p = k ? a.end : a.start, q = k ? b.end : b.start, edge = q - p;
        const glm::dvec3 across = narrowed * glm::cross(kites.along, edge), middle = 0.5 * (p + q);
        glm::dvec3* const kite = kites.points.data() + 4 * k;
        kite[0] = p, kite[1] = middle + across, kite[2] = q, kite[3] = middle - across;
        if (glm::length(across) > glm::length(kites.widest_across)) kites.widest = edge, kites.widest_across = across;
    }
    return kites;
}

// The kites around both ends of an edge, and the sides between them.
ConvexRegion Obstacles::spaceBetween(const Kites& kites) const {
    const auto& [points, d, widest, widest_across] = kites;
    ConvexRegion region;
    for (const glm::dvec3& p : points) region.include(p);
    region.addSide(-d, std::span(points).first(4));
    region.addSide(d, std::span(points).last(4));
    for (const double s : {1.0, -1.0})
        for (const double t : {1.0, -1.0}) region.addSide(s * glm::cross(0.5 * widest + t * widest_across, d), points);
    return region;
}

Obstacles::Leg Obstacles::lastLeg(const Path& path, double shortened_voxels) const {
    const GridFrame& frame = optics_.frame();
    const double exit = frame.passDistance(frame.indexFromWorld(path.position), frame.indexDirection(path.direction));
    const double voxel = metresPerVoxel(frame, path.direction);
    double end = std::min(path.hit_distance, std::max(0.0, exit));
    if (path.end.kind != Target::Kind::Nothing) end = std::max(0.0, end - shortened_voxels * voxel);
    // A mesh that light leaves bends away beside the path.
    const double start = leaves_mesh_ ? std::min(kNear * voxel, end) : 0;
    return {path.position + start * path.direction, path.position + end * path.direction};
}

// From where a leg leaves the grid to where it has passed all that may send its light back; empty where nothing may.
Obstacles::Leg Obstacles::legBeyond(const glm::dvec3& position, const glm::dvec3& direction, double exit,
                                    double hit) const {
    const glm::dvec3 farthest(direction.x > 0 ? bodies_high_.x : bodies_low_.x,
                              direction.y > 0 ? bodies_high_.y : bodies_low_.y,
                              direction.z > 0 ? bodies_high_.z : bodies_low_.z);
    const double end = std::max(exit, std::min(hit, glm::dot(farthest - position, direction)));
    return {position + exit * direction, position + end * direction};
}

bool Obstacles::standsBeyond(const Path& a, const Path& b, double width, std::int64_t& searches) const {
    if (bodies_low_.x > bodies_high_.x) return false;
    const GridFrame& frame = optics_.frame();
    Leg beyond[2];
    for (int k = 0; k < 2; ++k) {
        const Path& path = k ? b : a;
        const double exit =
            frame.passDistance(frame.indexFromWorld(path.position), frame.indexDirection(path.direction));
        // What never comes into the grid is followed by its corners alone.
        if (!(exit > 0 && exit < path.hit_distance)) return false;
        const bool ends = path.end.kind != Target::Kind::Nothing;
        const double near = ends ? kNear * metresPerVoxel(frame, path.direction) : 0;
        beyond[k] = legBeyond(path.position, path.direction, exit, path.hit_distance - near);
    }
    if (beyond[0].start == beyond[0].end && beyond[1].start == beyond[1].end) return false;
    const ConvexRegion space = spaceBetween(beyond[0], beyond[1]);
    for (int axis = 0; axis < 3; ++axis)
        if (space.high[axis] < bodies_low_[axis] || space.low[axis] > bodies_high_[axis]) return false;
    return standsIn(space, tracer_.history().back(), width, searches);
}

// From where all that stands in the scene is passed.
Obstacles::Leg Obstacles::legFromLight(const glm::dvec3& entry) const {
    const glm::dvec3 direction = tracer_.emission().directionAt(entry);
    const TriangleTree& tree = optics_.tree();
    const auto& source = tracer_.emission().sample().source;
    const double reach =
        source ? glm::length(entry - *source)
               : glm::length(entry - 0.5 * (tree.low() + tree.high())) + 0.5 * glm::length(tree.high() - tree.low());
    const double end = enters_on_mesh_ ? kNear * metresPerVoxel(optics_.frame(), direction) : 0;
    return {entry - std::max(reach, end) * direction, entry - end * direction};
}

// Whether what stands between `before` and `behind` [m] of the ends shows no gap.
bool Obstacles::covered(const Leg& a, const Leg& b, double before, double behind) const {
    const glm::dvec3 d = glm::normalize((a.end - a.start) + (b.end - b.start));
    const ConvexRegion region =
        spaceBetween({a.end - before * d, a.end + behind * d}, {b.end - before * d, b.end + behind * d});
    const glm::dvec3 across = glm::cross(d, b.end - a.end);
    return optics_.tree().shownArea(region, d) >= kWhole * glm::dot(across, across);
}

// Whether light falls through gaps of what shades both ends of an edge. Planes and water have no gaps that narrow.
bool Obstacles::isLitBetween(const Leg& to_a, const Leg& to_b, double width) const {
    const Kites kites = kitesOf(to_a, to_b, width > kNear ? 1 : kSlit);
    ShadowedPatch::Corners from, patch;
    std::array<RayHit, 4> first;
    for (std::size_t k = 0; k < 4; ++k) {
        from[k] = kites.points[k], patch[k] = kites.points[k + 4];
        const double length = glm::length(patch[k] - from[k]);
        if (length > 0) first[k] = optics_.caster().firstHit(from[k], (patch[k] - from[k]) / length, length);
    }
    const auto isOneShadow = [&] {
        return std::all_of(first.begin(), first.end(), [&](const RayHit& hit) {
            return hit && hit.target == first[0].target && hit.triangle == first[0].triangle;
        });
    };
    if (isOneShadow()) return false;
    ShadowedPatch shadowed(patch, from, kites.along, tracer_.emission().sample().source);
    optics_.tree().shade(spaceBetween(kites), first, shadowed);
    return !shadowed.dark() && (shadowed.isShaded() || width > kNear);
}

// Whether a space and the box around all bodies meet.
bool Obstacles::isNear(const ConvexRegion& space) const {
    const glm::dvec3 &low = optics_.tree().low(), &high = optics_.tree().high();
    for (int a = 0; a < 3; ++a)
        if (space.high[a] < low[a] || space.low[a] > high[a]) return false;
    return true;
}

// A surface that light leaves or comes to bends into its own way: it is looked for down to a voxel, all else down to
// the smallest tube.
bool Obstacles::standsIn(const ConvexRegion& space, const PathEvent& event, double width,
                         std::int64_t& searches) const {
    if (!isNear(space)) return false;
    ++searches;
    const Target own{Target::Kind::Surface, event.surface};
    if (!optics_.scene().surfaces[static_cast<std::size_t>(event.surface)].mesh) return optics_.tree().reaches(space);
    return optics_.tree().reaches(space, own) || (width > kNear && optics_.tree().reaches(space));
}

// Whether something stands in the layers behind a plane that light goes on to fill: it ends there, which corners alone
// do not tell.
bool Obstacles::standsBehind(const Path& a, const Path& b, std::int64_t& searches) const {
    const auto behind = [&](const Path& path) {
        const GridFrame& frame = optics_.frame();
        const double exit =
            frame.passDistance(frame.indexFromWorld(path.position), frame.indexDirection(path.direction));
        const double end = std::clamp(exit, path.hit_distance, std::max(path.hit_distance, path.end_distance));
        return Leg{path.position + path.hit_distance * path.direction, path.position + end * path.direction};
    };
    const auto endsOnPlane = [&](const Path& path) {
        return path.end.kind == Target::Kind::Object &&
               std::holds_alternative<Plane>(optics_.scene().objects[static_cast<std::size_t>(path.end.index)].shape);
    };
    if (!endsOnPlane(a) || !endsOnPlane(b)) return false;
    const Leg behind_a = behind(a), behind_b = behind(b);
    if (behind_a.start == behind_a.end && behind_b.start == behind_b.end) return false;  // outside of the grid
    const ConvexRegion space = spaceBetween(behind_a, behind_b);
    if (!isNear(space)) return false;
    ++searches;
    return optics_.tree().reaches(space);
}

bool Obstacles::between(const Path& a, const Path& b, double width, std::int64_t& searches) const {
    if (none() || a.outcome == PathOutcome::Missed) return false;
    // Light that comes to its first surface and goes no farther this way is the other branch's, as far as it comes.
    const bool is_dark = a.outcome == PathOutcome::Dark;
    // The legs to the first surface were looked at when shorter histories were laid.
    if (tracer_.history().size() == 1) {
        const Leg to_a = legFromLight(a.entry), to_b = legFromLight(b.entry);
        // What faces away lies in the shadow of its own closed body.
        if (a.outcome == PathOutcome::Hidden && first_is_closed_ && a.facing < 0 && b.facing < 0) return false;
        if (a.outcome != PathOutcome::Lit && !is_dark) return isLitBetween(to_a, to_b, width);
        if (standsIn(spaceBetween(to_a, to_b), tracer_.history().front(), width, searches)) return true;
    }
    if (is_dark) return false;
    const Leg last_a = lastLeg(a, kNear), last_b = lastLeg(b, kNear);
    // Nothing stands in a leg of a voxel, as in the wall of a glass.
    const bool short_legs = last_a.start == last_a.end && last_b.start == last_b.end;
    if (!short_legs && standsIn(spaceBetween(last_a, last_b), tracer_.history().back(), width, searches)) return true;
    if (width > kNear && standsBehind(a, b, searches)) return true;
    if (standsBeyond(a, b, width, searches)) return true;
    if (a.end.kind == Target::Kind::Nothing || a.end_triangle == b.end_triangle || width <= kWide) return false;
    const double near = kNear * metresPerVoxel(optics_.frame(), a.direction);
    return !covered(lastLeg(a, 0), lastLeg(b, 0), near, near);
}

// Whether all legs of a block end on one mesh, which nothing stands out of; sets the ends.
bool Obstacles::endOnOneObject(RayRow* row, int first, int columns, int rows, const std::vector<Leg>& around) const {
    std::vector<OpticalScene::LegEnd> ends;
    std::vector<glm::dvec3> points;
    glm::dvec3 d(0);
    const PathEvent& event = tracer_.history().front();
    MediumStack inside = optics_.startingInside(event.surface, {0, 0, -1}, {0, 0, 1});
    if (event.branch == Branch::Refracted) inside = optics_.across(inside, event.surface, true);
    for (int j = 0; j <= rows; ++j)
        for (int i = first; i <= first + columns; ++i) {
            const RayRow& r = row[j];
            const auto k = static_cast<std::size_t>(i);
            const glm::dvec3 start(r.x[k], r.y[k], r.z[k]), direction(r.dx[k], r.dy[k], r.dz[k]);
            ends.push_back(optics_.legEnd(start, direction, inside));
            const RayHit& hit = ends.back().hit;
            if (hit.target.kind != Target::Kind::Object || hit.target != ends.front().hit.target) return false;
            points.push_back(start + hit.distance * direction), d += direction;
        }
    if (!isFlatAndBare(points, columns, rows, glm::normalize(d), around)) return false;
    std::size_t corner = 0;
    for (int j = 0; j <= rows; ++j)
        for (int i = first; i <= first + columns; ++i, ++corner) {
            RayRow& r = row[j];
            const auto k = static_cast<std::size_t>(i);
            r.hit_distance[k] = ends[corner].hit.distance;
            r.w_end[k] = r.w[k] + (r.dz[k] < 0 ? -1 : 1) * ends[corner].deposit_end / r.per_layer[k];
        }
    return true;
}

// Whether points on a lattice lie in one plane, to half a voxel, and nothing stands before it.
bool Obstacles::isFlatAndBare(const std::vector<glm::dvec3>& points, int columns, int rows, const glm::dvec3& d,
                              const std::vector<Leg>& around) const {
    const auto at = [&](int i, int j) { return points[static_cast<std::size_t>(j * (columns + 1) + i)]; };
    glm::dvec3 normal = glm::cross(at(columns, 0) - at(0, 0), at(0, rows) - at(0, 0));
    if (!(glm::length(normal) > 0)) return false;
    normal = glm::normalize(glm::dot(normal, d) < 0 ? -normal : normal);
    if (glm::dot(normal, d) < 0.2) return false;
    const double voxel = metresPerVoxel(optics_.frame(), d) * glm::dot(normal, d);
    double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
    for (const glm::dvec3& p : points)
        nearest = std::min(nearest, glm::dot(normal, p)), farthest = std::max(farthest, glm::dot(normal, p));
    if (farthest - nearest > 0.5 * kNear * voxel) return false;
    ConvexRegion before = spaceAround(around);
    before.addSide({normal, nearest - kNear * voxel});
    return !optics_.tree().reaches(before);
}

Obstacles::Way Obstacles::ofBlock(RayRow* row, int first, int columns, int rows) const {
    if (none()) return Way::Free;
    const GridFrame& frame = optics_.frame();
    const int lattice_end = static_cast<int>(row[0].u.size()) - 1;
    std::vector<Leg> from_light, last, beyond;
    const bool any_bodies = bodies_low_.x <= bodies_high_.x;
    for (int j = -1; j <= rows + 1; ++j)
        for (int i = std::max(first - 1, 0); i <= std::min(first + columns + 1, lattice_end); ++i) {
            const RayRow& r = row[j];
            const auto k = static_cast<std::size_t>(i);
            if (!(r.per_layer[k] > 0)) return Way::Unclear;
            const glm::dvec3 p(r.x[k], r.y[k], r.z[k]), d(r.dx[k], r.dy[k], r.dz[k]);
            const double exit_w = d.z < 0 ? frame.min.z - 0.5 : frame.max.z + 0.5;
            const double exit = (exit_w - r.w[k]) * r.per_layer[k] * (d.z < 0 ? -1 : 1);
            from_light.push_back(legFromLight(p));
            const double end = std::fabs(r.w_end[k] - r.w[k]) * r.per_layer[k];  // behind a plane, if it is one
            last.push_back({p, p + std::min(end, std::max(0.0, exit)) * d});
            if (any_bodies && exit > 0 && exit < r.hit_distance[k])
                beyond.push_back(legBeyond(p, d, exit, r.hit_distance[k]));
        }
    if (optics_.tree().reaches(spaceAround(from_light))) return Way::Unclear;
    const bool may_come_back =
        std::any_of(beyond.begin(), beyond.end(), [](const Leg& leg) { return leg.start != leg.end; });
    if (may_come_back && optics_.tree().reaches(spaceAround(beyond))) return Way::Unclear;
    if (!optics_.tree().reaches(spaceAround(last))) return Way::Free;
    const RayRow& r = row[0];
    const auto k = static_cast<std::size_t>(first);
    const double cell = std::max(std::fabs(r.u[k + 1] - r.u[k]), std::fabs(row[1].v[k] - r.v[k]));
    return cell <= kWide && endOnOneObject(row, first, columns, rows, last) ? Way::Covered : Way::Unclear;
}

}  // namespace photic
