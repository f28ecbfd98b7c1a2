// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace photic {
namespace {

// Of the unfocused light on a voxel's face: tubes that carry less are not divided. What they misplace cannot be seen,
// and behind many events, or at a grazing entry, there would be no end of them.
constexpr double kLeastPower = 1.0 / 256, kLeastAfterMany = 1.0 / 128;

// Of an edge along a body's rim, whose ends face across the light: what its chord cuts off does face the light.
constexpr double kLeastFacing = 1.0 / 8;

// Share of full light below which tubes become no coarser.
constexpr double kFaintest = 1.0 / 256;

// Tubes that stay outside of the grid are divided down to this [voxels]; those that have met a body there, more finely:
// between two that leave it beside the grid there may be light that comes into it.
constexpr double kWideOutside = 1, kOutsideBodies = 0.25;

// Where light is launched across its rays, empty space is searched for the surface as finely as this [voxels].
constexpr double kWideEmpty = 1;

// Paths that part by more than this [voxels] before they land may be bent, however near to each other they start.
constexpr double kFan = 1;

// Tubes whose light goes on through different surfaces are divided down to this [voxels] before it does, and as finely
// as anything else after it.
constexpr double kWideSeam = 0.5;

// Without an area there is nothing to divide, and no end to it.
bool isSliver(const EmissionParam& a, const EmissionParam& b, const EmissionParam& c) {
    const glm::dvec3 p = b.position - a.position, q = c.position - a.position;
    return !(glm::length(glm::cross(p, q)) > 1e-9 * std::max(glm::dot(p, p), glm::dot(q, q)));
}

bool isLost(const Path& path) { return path.outcome == PathOutcome::Dark || path.outcome == PathOutcome::Missed; }

double largest(const glm::dvec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

}  // namespace

bool PathComparison::canShareTube(const Path& a, const Path& b) const {
    if (a.outcome != b.outcome) return false;
    if (a.outcome != PathOutcome::Lit) return true;
    return a.medium == b.medium && (!ends_matter_ || a.end == b.end) && sameWay(a, b);
}

bool PathComparison::sameWay(const Path& a, const Path& b) const {
    const glm::dvec3 da = frame_.indexDirection(a.direction), db = frame_.indexDirection(b.direction);
    const int axis = mainAxis(da + db);
    // Directions more than some 100 degrees apart have no plane that both cross.
    return da[axis] * db[axis] > 0 && std::fabs(da[axis]) > 0.2 * largest(da) &&
           std::fabs(db[axis]) > 0.2 * largest(db);
}

bool PathComparison::differByTheNextSurface(const Path& a, const Path& b, const Path& m) const {
    for (const Path* path : {&a, &b, &m})
        if (path->outcome != PathOutcome::Lit || path->end.kind != Target::Kind::Surface || path->medium != a.medium)
            return false;
    return sameWay(a, b) && sameWay(a, m);
}

double PathComparison::width(const Path& a, const Path& b) const {
    // A path that is lost on its way stands anywhere.
    return isLost(a) || isLost(b) ? entryWidth(a, b) : largest(frame_.indexDirection(a.position - b.position));
}

bool PathComparison::missesGrid(const Path& a, const Path& b) const {
    if (isLost(a) && isLost(b)) return false;
    const double margin = 1 + width(a, b);
    bool below[3] = {true, true, true}, above[3] = {true, true, true};
    for (const Path* path : {&a, &b}) {
        if (isLost(*path)) continue;  // lays nothing
        const glm::dvec3 p = frame_.indexFromWorld(path->position), d = frame_.indexDirection(path->direction);
        const double length = std::min(path->hit_distance, std::max(0.0, frame_.exitDistance(p, d)));
        const glm::dvec3 q = p + d * length;
        for (int k = 0; k < 3; ++k) {
            below[k] = below[k] && std::max(p[k], q[k]) < frame_.min[k] - 0.5 - margin;
            above[k] = above[k] && std::min(p[k], q[k]) > frame_.max[k] + 0.5 + margin;
        }
    }
    return below[0] || below[1] || below[2] || above[0] || above[1] || above[2];
}

double PathComparison::share(const Path& a, const Path& b) const {
    // Before its first surface, light has lost nothing yet.
    if (a.outcome != PathOutcome::Lit && b.outcome != PathOutcome::Lit) return 1;
    return std::max(channelMean(a.arriving * a.fraction), channelMean(b.arriving * b.fraction));
}

double PathComparison::carries(const Path& a, const Path& b) const {
    const double width = entryWidth(a, b);
    const double across = emission_.plane() ? 1 : std::max({std::fabs(a.facing), std::fabs(b.facing), kLeastFacing});
    return width * launchWidth(a, b) * across * share(a, b);
}

// Where a height field steps, as where waves end and flat water begins, what an edge spans in height stays while it is
// halved: without this its tubes would never carry little.
double PathComparison::launchWidth(const Path& a, const Path& b) const {
    if (emission_.surface().height_field == nullptr) return entryWidth(a, b);
    return largest(frame_.indexDirection(a.param.position - b.param.position));
}

double PathComparison::entryWidth(const Path& a, const Path& b) const {
    if (emission_.plane())
        return largest(frame_.indexDirection(emission_.planePoint(a.param) - emission_.planePoint(b.param)));
    return largest(frame_.indexDirection(a.entry - b.entry));
}

// Where a path's deposit ends in the grid's box, in index space.
glm::dvec3 PathComparison::landing(const Path& path) const {
    const glm::dvec3 p = frame_.indexFromWorld(path.position), d = frame_.indexDirection(path.direction);
    return p + d * std::min(path.end_distance, std::max(frame_.exitDistance(p, d), 0.0));
}

bool PathComparison::fansOut(const Path& a, const Path& b) const {
    return a.outcome == PathOutcome::Lit && canShareTube(a, b) && !missesGrid(a, b) &&
           largest(landing(a) - landing(b)) > kFan;
}

bool PathComparison::cutsOffRim(const Path& a, const Path& b) const {
    constexpr double kAcross = 1e-6;
    return emission_.surface().sphere && !emission_.plane() && a.outcome == PathOutcome::Lit &&
           b.outcome == PathOutcome::Lit && std::fabs(a.facing) < kAcross && std::fabs(b.facing) < kAcross;
}

bool PathComparison::endsApart(const Path& a, const Path& b) const {
    if (!std::isfinite(a.end_distance) && !std::isfinite(b.end_distance)) return false;
    const int axis = mainAxis(frame_.indexDirection(a.direction + b.direction));
    return std::fabs((landing(a) - landing(b))[axis]) > 1;
}

bool PathComparison::startsApart(const Path& a, const Path& b) const {
    const glm::dvec3 way = frame_.indexDirection(a.direction + b.direction);
    const bool upright = std::max(std::fabs(way.x), std::fabs(way.y)) <= kSteepestZ * std::fabs(way.z);
    const int axis = upright ? 2 : mainAxis(way);
    const double sense = way[axis] > 0 ? 1 : -1;
    const double p = sense * frame_.indexFromWorld(a.position)[axis],
                 q = sense * frame_.indexFromWorld(b.position)[axis];
    // What starts before the grid or behind it is no concern of it.
    const double low = frame_.min[axis] - 0.5, high = frame_.max[axis] + 0.5;
    return std::fabs(p - q) > 1 && std::max(p, q) > std::min(sense * low, sense * high) &&
           std::min(p, q) < std::max(sense * low, sense * high);
}

double PathComparison::fadesApart(const Path& a, const Path& b) const {
    if (a.outcome != PathOutcome::Lit || b.outcome != PathOutcome::Lit) return 0;
    const glm::dvec3 extinction = optics_.medium(a.medium).extinction();
    const double most = largest(extinction);
    if (!(most > 0)) return 0;
    const glm::dvec3 p = frame_.indexFromWorld(a.position), d = frame_.indexDirection(a.direction);
    const glm::dvec3 q = frame_.indexFromWorld(b.position), e = frame_.indexDirection(b.direction);
    const int axis = mainAxis(d + e);
    if (!(d[axis] * e[axis] > 0)) return 0;
    const double way = std::min({1 / most, a.end_distance, std::max(frame_.exitDistance(p, d), 0.0)});
    return most * std::fabs(way - (p[axis] + way * d[axis] - q[axis]) / e[axis]);
}

double PathComparison::arrivesUnevenly(const Path& a, const Path& m, const Path& b) const {
    const double extinction = largest(optics_.medium(m.medium).extinction());
    if (!(extinction > 0)) return 0;
    const Path* const paths[] = {&a, &m, &b};
    double left[3];
    for (int i = 0; i < 3; ++i) {
        const Path& path = *paths[i];
        if (path.outcome != PathOutcome::Lit || path.end.kind != Target::Kind::Surface) return 0;
        left[i] = std::exp(-extinction * path.hit_distance);
    }
    return std::fabs(left[1] - 0.5 * (left[0] + left[2]));
}

double PathComparison::goesOnUnevenly(const Path& a, const Path& m, const Path& b) const {
    const Path* const paths[] = {&a, &m, &b};
    double goes_on[3];
    for (int i = 0; i < 3; ++i) {
        if (paths[i]->outcome != PathOutcome::Lit) return 0;
        goes_on[i] = channelMean(paths[i]->arriving * paths[i]->fraction);
    }
    return std::fabs(goes_on[1] - 0.5 * (goes_on[0] + goes_on[2]));
}

bool PathComparison::stepsInDepth(const Path& a, const Path& m, const Path& b, double fineness) const {
    if (!ends_matter_ || a.end.kind == Target::Kind::Nothing) return false;
    const double voxels = largest(frame_.indexDirection(m.direction));
    const double step = std::fabs(m.hit_distance - 0.5 * (a.hit_distance + b.hit_distance)) * voxels;
    return step > fineness * (1 + 0.25 * std::fabs(a.hit_distance - b.hit_distance) * voxels);
}

double PathComparison::bend(const Path& a, const Path& m, const Path& b) const {
    const glm::dvec3 pm = frame_.indexFromWorld(m.position), dm = frame_.indexDirection(m.direction);
    if (frame_.exitDistance(pm, dm) <= 0 && !std::isfinite(m.end_distance)) return 0;
    const int axis = mainAxis(dm);
    const glm::dvec3 at = landing(m);
    const auto onPlane = [&](const Path& path) {
        const glm::dvec3 p = frame_.indexFromWorld(path.position), d = frame_.indexDirection(path.direction);
        return p + d * ((at[axis] - p[axis]) / d[axis]);
    };
    return largest(onPlane(a) - 2.0 * at + onPlane(b));
}

double bodyFineness(const OpticalScene& optics, const History& history) {
    constexpr double kVoxelsOfABody = 8, kPartsOfALength = 512, kFinest = 1.0 / 8;
    double least = 1;
    for (const PathEvent& event : history) {
        const glm::dvec3& box = optics.boxOf(event.surface);
        if (box == glm::dvec3(0)) continue;
        std::array<double, 3> side{};
        for (int a = 0; a < 3; ++a) {
            glm::dvec3 edge(0);
            edge[a] = box[a];
            side[static_cast<std::size_t>(a)] = largest(optics.frame().indexDirection(edge));
        }
        std::sort(side.begin(), side.end());
        least = std::min(least, std::max({side[1] / kVoxelsOfABody, side[2] / kPartsOfALength, kFinest}));
    }
    return least;
}

double Refiner::leastPower() const {
    return (tracer_.history().size() <= 2 ? kLeastPower : kLeastAfterMany) * options_.full_share * options_.faint *
           options_.fineness * options_.fineness;
}

// Whether an edge stays whole whatever lies between its ends.
bool Refiner::isFineEnough(const Path& a, const Path& b, double width) const {
    if (options_.max_edge > 0 && width > options_.max_edge) return false;
    if (tracer_.emission().between(a.entry, b.entry) == Emission::Between::Narrow) return false;
    // At a ball's rim no light is refracted, and all that the chord cuts off is.
    if (compare_.cutsOffRim(a, b)) return width <= silhouette();
    if (compare_.carries(a, b) < leastPower()) return true;
    // At a body's rim light fans out from within a hair: outlines need no finer tubes there, what they lay does.
    return width <= silhouette() && !(options_.tolerance > 0 && compare_.fansOut(a, b));
}

bool Refiner::mustSplit(const Path& a, const Path& b, const Path& m, double width) const {
    if (options_.max_edge > 0 && width > options_.max_edge) return true;
    const Emission::Between lamp = tracer_.emission().between(a.entry, b.entry);
    if (lamp == Emission::Between::Narrow) return true;
    if (width <= silhouette())
        return compare_.canShareTube(a, m) && (bendsTooMuch(a, b, m) || goesOnTooUnevenly(a, b, m));
    if (lamp == Emission::Between::Dark) return false;
    if (lamp == Emission::Between::Uneven || compare_.cutsOffRim(a, b)) return true;
    // Where nothing is laid, light is followed only as well as it must be to come back.
    const bool met_body = tracer_.history().size() > 1 || a.end.kind == Target::Kind::Surface;
    if (width <= (met_body ? kOutsideBodies * options_.fineness : kWideOutside) && compare_.missesGrid(a, b))
        return false;
    if (!compare_.canShareTube(a, b) || !compare_.canShareTube(a, m))
        return width > kWideSeam * options_.fineness || !compare_.differByTheNextSurface(a, b, m);
    if (a.outcome == PathOutcome::Missed) return width > kWideEmpty * options_.fineness;
    if (standsBetween(a, b, width)) return true;
    if (a.outcome != PathOutcome::Lit) return false;
    if (compare_.stepsInDepth(a, m, b, options_.fineness) || (width > 1 && compare_.standApart(a, b))) return true;
    return fadesTooMuch(a, b, width) || arrivesTooUnevenly(a, b, m) || goesOnTooUnevenly(a, b, m) ||
           bendsTooMuch(a, b, m);
}

// Beside a sharp edge light leaves a body again at once, and next to that only after all its depth: what goes on is
// lost to all that follows, however narrow the tube.
bool Refiner::arrivesTooUnevenly(const Path& a, const Path& b, const Path& m) const {
    return options_.tolerance > 0 && compare_.arrivesUnevenly(a, m, b) * compare_.share(a, b) >
                                         kFading * options_.tolerance * options_.full_share;
}

// Just before total reflection, what goes on is as a root of the way to where it sets in; inside of a tube it is the
// mean of what goes on at its corners. After many events light is too faint for it.
bool Refiner::goesOnTooUnevenly(const Path& a, const Path& b, const Path& m) const {
    constexpr std::size_t kMostEvents = 2;
    return options_.tolerance > 0 && tracer_.history().size() <= kMostEvents &&
           compare_.goesOnUnevenly(a, m, b) > kFading * options_.tolerance * options_.full_share;
}

bool Refiner::bendsTooMuch(const Path& a, const Path& b, const Path& m) const {
    if (!(options_.tolerance > 0) || compare_.missesGrid(a, b)) return false;
    // What is misplaced counts by its power, and tubes go with one over the tolerance: the sum of errors is least for a
    // given number of tubes when each history's tolerance goes with one over the root of its power.
    const double coarser = std::sqrt(std::clamp(compare_.share(a, b) / options_.full_share, kFaintest, 1.0));
    // Paths half an edge apart: a quarter of the second difference over the edge.
    return 4 * compare_.bend(a, m, b) * coarser > options_.tolerance;
}

// Within a voxel nobody sees it.
bool Refiner::fadesTooMuch(const Path& a, const Path& b, double width) const {
    return options_.tolerance > 0 && width > 1 && compare_.fadesApart(a, b) > kFading * options_.tolerance &&
           !compare_.missesGrid(a, b);
}

bool Refiner::standsBetween(const Path& a, const Path& b, double width) const {
    if (obstacles_.none()) return false;
    std::int64_t searches = 0;
    const bool stands = obstacles_.between(a, b, width, searches);
    builder_.countSearches(searches);
    return stands;
}

void Refiner::knowBend(const Path& a, const Path& b, const glm::dvec3& face, double bend) {
    const double width = compare_.width(a, b);
    const EmissionParam param = middle(a.param, b.param);
    bool fresh = false;
    Edge& edge = edges_->at(param, fresh);
    const Emission::Between lamp = tracer_.emission().between(a.entry, b.entry);
    edge.split = bend > options_.tolerance || lamp == Emission::Between::Uneven || lamp == Emission::Between::Narrow ||
                 (width > silhouette() && (standsBetween(a, b, width) || (width > 1 && compare_.standApart(a, b)))) ||
                 fadesTooMuch(a, b, width);
    if (edge.split) traceMiddle(edge, param, face);
}

void Refiner::traceMiddle(Edge& edge, const EmissionParam& param, const glm::dvec3& face) {
    // One triangle of a rough mesh may be divided for minutes.
    constexpr std::int64_t kRaysBetweenLooks = 64;
    if (options_.monitor && traced_ % kRaysBetweenLooks == 0) options_.monitor->checkCancelled();
    edge.middle = &edges_->keep(tracer_.trace(param, face));
    ++traced_;
}

const Refiner::Edge& Refiner::edgeBetween(const Path& a, const Path& b, const glm::dvec3& face) {
    const EmissionParam param = middle(a.param, b.param);
    bool fresh = false;
    Edge& edge = edges_->at(param, fresh);
    const double width = fresh ? compare_.width(a, b) : 0;
    if (fresh && !isFineEnough(a, b, width)) {
        traceMiddle(edge, param, face);
        edge.split = mustSplit(a, b, *edge.middle, width);
    }
    return edge;
}

int Refiner::add(const Path& a, const Path& b, const Path& c, const glm::dvec3& face, int depth) {
    if (depth >= options_.max_depth || isSliver(a.param, b.param, c.param)) return builder_.add(a, b, c, face);
    const Edge &ab = edgeBetween(a, b, face), &bc = edgeBetween(b, c, face), &ca = edgeBetween(c, a, face);
    const Path* corners[3] = {&a, &b, &c};
    const Edge* edges[3] = {&ab, &bc, &ca};
    if (ab.split || bc.split || ca.split) return divide(corners, edges, face, depth + 1);
    // What no edge shows: three legs that pairwise share an axis and all together do not.
    const bool lit = a.outcome == PathOutcome::Lit && b.outcome == PathOutcome::Lit && c.outcome == PathOutcome::Lit;
    const double widest = std::max({compare_.width(a, b), compare_.width(b, c), compare_.width(c, a)});
    const double carries = std::max({compare_.carries(a, b), compare_.carries(b, c), compare_.carries(c, a)});
    if (!lit || widest <= silhouette() || carries < leastPower() || builder_.axisServes(a, b, c))
        return builder_.add(a, b, c, face);
    Edge all[3];
    const Edge* halved[3];
    for (int i = 0; i < 3; ++i) {
        all[i] = *edges[i];
        if (!all[i].middle) traceMiddle(all[i], middle(corners[i]->param, corners[(i + 1) % 3]->param), face);
        all[i].split = true, halved[i] = &all[i];
    }
    return divide(corners, halved, face, depth + 1);
}

int Refiner::divide(const Path* const* corners, const Edge* const* edges, const glm::dvec3& face, int depth) {
    const std::size_t first = builder_.seeds().size();
    const int met = divided(corners, edges, face, depth);
    if (joinable(corners, first, met)) builder_.joinSeeds(first, *corners[0], *corners[1], *corners[2]);
    return met;
}

// Longer histories need not be divided where this one had to be. Where all parts of a triangle meet one surface, they
// are one again; and where its light is too faint to be divided, if they meet one surface and a corner does.
bool Refiner::joinable(const Path* const* corners, std::size_t first, int met) const {
    const std::vector<TubeSeed>& seeds = builder_.seeds();
    if (seeds.size() < first + 2) return false;
    if (met >= 0) return true;
    double carries = 0;
    bool corner_meets = false;
    const int surface = seeds[first].surface;
    for (int i = 0; i < 3; ++i) {
        const Path& a = *corners[i];
        carries = std::max(carries, compare_.carries(a, *corners[(i + 1) % 3]));
        corner_meets = corner_meets ||
                       (a.outcome == PathOutcome::Lit && a.end.kind == Target::Kind::Surface && a.end.index == surface);
    }
    if (!corner_meets || carries >= leastPower()) return false;
    return std::all_of(seeds.begin() + static_cast<std::ptrdiff_t>(first), seeds.end(),
                       [surface](const TubeSeed& seed) { return seed.surface == surface; });
}

// Edge i runs from corner i to the next.
int Refiner::divided(const Path* const* corners, const Edge* const* edges, const glm::dvec3& face, int depth) {
    constexpr int kNone = -2;  // no part yet
    int met = kNone;
    const auto part = [&](const Path& a, const Path& b, const Path& c) {
        const int of_part = add(a, b, c, face, depth);
        met = met == kNone || met == of_part ? of_part : -1;
    };
    const int splits = edges[0]->split + edges[1]->split + edges[2]->split;
    if (splits == 3) {
        for (int i = 0; i < 3; ++i) part(*corners[i], *edges[i]->middle, *edges[(i + 2) % 3]->middle);
        part(*edges[0]->middle, *edges[1]->middle, *edges[2]->middle);
        return met;
    }
    // Turned so that the one edge that differs from the others comes first.
    int first = 0;
    while (edges[first]->split != (splits == 1)) ++first;
    const Path &a = *corners[first], &b = *corners[(first + 1) % 3], &c = *corners[(first + 2) % 3];
    if (splits == 1) {
        const Path& m = *edges[first]->middle;
        part(a, m, c), part(m, b, c);
        return met;
    }
    // Two edges: cut off the corner between them, which is c, and halve the rest.
    const Path &bc = *edges[(first + 1) % 3]->middle, &ca = *edges[(first + 2) % 3]->middle;
    part(c, ca, bc), part(ca, a, b), part(ca, b, bc);
    return met;
}

}  // namespace photic
