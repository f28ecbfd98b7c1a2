// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/tube_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace photic {
namespace {

constexpr std::size_t kBlockTubes = 128, kBlockCorners = 120;

// Three legs that end on different things stop with the first of them; otherwise each has its own end.
bool sameEnd(const Path& a, const Path& b, const Path& c) { return a.end == b.end && b.end == c.end; }

// Mean over a triangle of the root of what is linear there and a^2, b^2, c^2 at its corners: twice the second divided
// difference of (4/15) q^(5/2) (Hermite and Genocchi), with the roots' differences cancelled out.
double meanOfRoot(double a, double b, double c) {
    const double sums = (a + b) * (b + c) * (c + a);
    // Two of them are 0, or all.
    if (!(sums > 0)) return 8.0 / 15 * (a + b + c);
    const double e1 = a + b + c, e2 = a * b + b * c + c * a, e3 = a * b * c;  // elementary symmetric functions
    return 8.0 / 15 * (e1 * e1 * e2 - e2 * e2 - e1 * e3) / sums;
}

// What each corner of a lit tube stands for. A body's reflectance, and all that light goes through inside of it, is
// smooth in the cosine at which light meets it; and that is no linear function of the place but, near to where the body
// turns away from the light, the root of one. So a mean over the tube is that of its corners with shares by which the
// cosine's own mean comes out right: of a ball, on which the square is linear, the rim reflects as it should.
std::array<double, 3> sharesByFacing(double a, double b, double c) {
    const double middle = (a + b + c) / 3;
    const double spread = (a - middle) * (a - middle) + (b - middle) * (b - middle) + (c - middle) * (c - middle);
    if (!(spread > 1e-12)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    const double tilt = (meanOfRoot(a, b, c) - middle) / spread;
    return {1.0 / 3 + tilt * (a - middle), 1.0 / 3 + tilt * (b - middle), 1.0 / 3 + tilt * (c - middle)};
}

}  // namespace

TubeBuilder::TubeBuilder(const OpticalScene& optics, const Emission& emission, const TubeLaunch& launch)
    : optics_(&optics), emission_(&emission), launch_(launch) {
    for (std::size_t i = 0; i < sets_.size(); ++i) {
        TubeSet& set = sets_[i];
        set.axis = static_cast<int>(i % kSetsALobe / 2);
        set.sense = i % 2 ? 1 : -1;
        set.channels = launch.channels;
    }
}

int TubeBuilder::chooseAxis(const Path& a, const Path& b, const Path& c, double max_slope) const {
    const glm::dvec3 d[3] = {frame().indexDirection(a.direction), frame().indexDirection(b.direction),
                             frame().indexDirection(c.direction)};
    int best = -1;
    double best_slope = max_slope;
    for (const int axis : {2, 0, 1}) {
        if (d[0][axis] == 0 || d[0][axis] * d[1][axis] <= 0 || d[0][axis] * d[2][axis] <= 0) continue;
        double slope = 0;
        for (const auto& v : d)
            for (int other = 0; other < 3; ++other)
                if (other != axis) slope = std::max(slope, std::fabs(v[other] / v[axis]));
        if (axis == 2 && slope <= kSteepestZ) return 2;
        if (slope < best_slope) best = axis, best_slope = slope;
    }
    return best;
}

bool TubeBuilder::missesBox(const Corners& corners) const {
    // Outside one side of the box from start to end.
    bool below[3] = {true, true, true}, above[3] = {true, true, true};
    for (const Path* path : corners) {
        const glm::dvec3 p = frame().indexFromWorld(path->position), d = frame().indexDirection(path->direction);
        const glm::dvec3 q = p + d * std::min(path->end_distance, std::max(0.0, frame().passDistance(p, d)));
        for (int a = 0; a < 3; ++a) {
            below[a] = below[a] && std::max(p[a], q[a]) < frame().min[a] - 0.5;
            above[a] = above[a] && std::min(p[a], q[a]) > frame().max[a] + 0.5;
        }
    }
    return below[0] || below[1] || below[2] || above[0] || above[1] || above[2];
}

CornerRay TubeBuilder::cornerRay(const Path& path, int axis, double end_distance) const {
    const auto axes = axesFor(axis);
    const glm::dvec3 p = frame().indexFromWorld(path.position), d = frame().indexDirection(path.direction);
    CornerRay ray;
    ray.u = p[axes[0]], ray.v = p[axes[1]], ray.w = p[axes[2]];
    ray.du_dw = d[axes[0]] / d[axes[2]], ray.dv_dw = d[axes[1]] / d[axes[2]];
    ray.w_end = std::clamp(ray.w + d[axes[2]] * end_distance, -1e30, 1e30);
    return ray;
}

// Where a corner's leg leaves the box, in index space; 0 where it stands beside it. The corners of the outermost tubes
// lie on the box's sides: which of the sides' own they are must not fall to a hair, or a third of all those tubes would
// leave the box where they begin.
double TubeBuilder::exitDistance(const glm::dvec3& position, const glm::dvec3& direction) const {
    constexpr double kHair = 0.01;  // voxels
    const int along = mainAxis(direction);
    double exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) continue;
        const double beside = 0.5 + (a == along ? 0 : kHair),
                     side = direction[a] > 0 ? frame().max[a] + beside : frame().min[a] - beside;
        exit = std::min(exit, (side - position[a]) / direction[a]);
    }
    return std::max(exit, 0.0);
}

// What a lamp's own medium takes before its first surface.
void TubeBuilder::countFirstLeg(const Path& path, const glm::dvec3& emitted) {
    PowerLedger handed_on;
    countLeg(optics_->medium(path.first_medium), emitted, glm::length(path.entry - *emission_->sample().source),
             &PowerLedger::received, handed_on);
    power_.absorbed_medium += handed_on.absorbed_medium, power_.scattered += handed_on.scattered;
}

// Counts one corner's share of a tube. `unlaid` is the term that light belongs to that is not laid; null: it is laid.
// Returns what arrives at a surface that hands it on.
double TubeBuilder::countCorner(const Path& path, const glm::dvec3& emitted, double PowerLedger::*unlaid) {
    if (path.outcome == PathOutcome::Hidden || path.outcome == PathOutcome::Missed) return 0;
    if (launch_.counts_emission) power_.emitted += channelMean(emitted);
    if (path.outcome == PathOutcome::Blocked) {
        if (launch_.counts_emission) power_.absorbed_surface += channelMean(emitted);
        return 0;
    }
    if (launch_.counts_emission && emission_->sample().source) countFirstLeg(path, emitted);
    const glm::dvec3 arriving = emitted * path.arriving;
    arriving_ += channelMean(arriving);
    const double absorbed = channelMean(arriving * path.absorbed);
    kept_ += channelMean(arriving) * path.untraced + absorbed;
    if (launch_.counts_event) {
        power_.reflected += channelMean(arriving) * path.untraced;
        power_.absorbed_surface += absorbed;
    }
    if (launch_.counts_dropped) {
        power_.dropped += channelMean(arriving) * path.dropped;
        given_up_.turned += channelMean(arriving) * path.dropped;
        leaving_ += channelMean(arriving) * path.dropped;
    }
    if (path.outcome != PathOutcome::Lit) return 0;
    const glm::dvec3 power = arriving * path.fraction;
    leaving_ += channelMean(power);
    const bool hands_on = path.end.kind == Target::Kind::Surface && launch_.follows_on;
    // What lies outside the grid may come back into it.
    if (unlaid && !hands_on) {
        power_.*unlaid += channelMean(power);
        if (unlaid == &PowerLedger::dropped) given_up_.outlines += channelMean(power);
        return 0;
    }
    const double exit = exitDistance(frame().indexFromWorld(path.position), frame().indexDirection(path.direction));
    const double length = std::min(path.hit_distance, exit);
    const OpticalMedium& medium = optics_->medium(path.medium);
    if (hands_on) {
        PowerLedger handed_on;
        const glm::dvec3 left = countLeg(medium, power, path.hit_distance, &PowerLedger::received, handed_on);
        power_.absorbed_medium += handed_on.absorbed_medium, power_.scattered += handed_on.scattered;
        return channelMean(left);
    }
    double PowerLedger::*const end = !(path.hit_distance <= exit)             ? &PowerLedger::escaped
                                     : path.end.kind == Target::Kind::Surface ? &PowerLedger::dropped
                                                                              : &PowerLedger::received;
    const double before = power_.dropped;
    countLeg(medium, power, length, end, power_);
    given_up_.events += power_.dropped - before;
    return 0;
}

std::uint8_t TubeBuilder::cornerIndex(int s, const Path& path, double end_distance) {
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    const CornerRay ray = cornerRay(path, set.axis, end_distance);
    for (std::size_t i = open.params.size(); i-- > 0;)
        if (open.params[i] == path.param && open.ends[i] == ray.w_end) return static_cast<std::uint8_t>(i);
    open.params.push_back(path.param);
    open.ends.push_back(ray.w_end);
    set.corners.push_back(ray);
    return static_cast<std::uint8_t>(open.params.size() - 1);
}

void TubeBuilder::openBlock(int s, int medium) {
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    if (open.triangles.size() >= kBlockTubes || open.params.size() + 3 > kBlockCorners ||
        (!open.triangles.empty() && open.medium != medium))
        closeBlock(s);
    if (!open.triangles.empty()) return;
    open.first_corner = static_cast<std::uint32_t>(set.corners.size());
    open.first_tube = static_cast<std::uint32_t>(set.tubes.size());
    open.medium = medium;
}

void TubeBuilder::closeBlock(int s) {
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    if (!open.triangles.empty())
        set.blocks.push_back(
            {BlockTopology::fromTriangles(static_cast<int>(open.params.size()), std::move(open.triangles)),
             open.first_corner, open.first_tube, optics_->medium(open.medium).extinction(), launch_.faceted,
             static_cast<float>(launch_.share)});
    open = OpenBlock{};
}

// Whether a tube's corners are of different fates: by planes, which end each corner's leg where it meets them, none is.
bool TubeBuilder::standsAstride(const Corners& corners) const {
    for (const Path* path : corners)
        if (path->outcome != PathOutcome::Lit) return true;
    return !optics_->caster().planesOnly() && !sameEnd(*corners[0], *corners[1], *corners[2]);
}

// Each corner stands for a third of a tube's power, of rounded bodies for what sharesByFacing says. Where a closed body
// turns away from the light there is no edge of a shadow to look for: a triangle there faces the light or does not, and
// the corners that do stand for all of it.
std::array<double, 3> TubeBuilder::sharesOfCorners(const Corners& corners) const {
    const auto alike = [](double share) { return std::array{share, share, share}; };
    const Surface& surface = emission_->surface();
    const bool all_lit = std::all_of(corners.begin(), corners.end(), [](const Path* path) {
        return path->outcome == PathOutcome::Lit && path->facing >= 0;
    });
    const bool round = surface.sphere || (surface.mesh && surface.smooth);
    const auto lit_shares = [&] {
        return round && all_lit ? sharesByFacing(corners[0]->facing, corners[1]->facing, corners[2]->facing)
                                : alike(1.0 / 3);
    };
    if (emission_->plane() || (!surface.closed && !surface.sphere)) return lit_shares();
    int away = 0, lit = 0, from_inside = 0;
    for (const Path* path : corners) {
        away += path->outcome == PathOutcome::Hidden && path->facing < 0;
        lit += path->outcome == PathOutcome::Lit;
        from_inside += path->outcome == PathOutcome::Lit && path->facing < -1e-9;
    }
    if (away == 3 || from_inside > 0) return alike(1.0 / 3);
    const glm::dvec3& a = corners[0]->entry;
    const glm::dvec3 area = glm::cross(corners[1]->entry - a, corners[2]->entry - a);
    // A triangle that is folded back over its neighbours at the rim covers what they do.
    if (glm::dot(area, emission_->directionAt(a)) >= 0 || (away > 0 && lit == 0)) return alike(0);
    return away > 0 ? alike(1.0 / (3 - away)) : lit_shares();
}

int TubeBuilder::add(const Path& a, const Path& b, const Path& c, const glm::dvec3& face) {
    ++added_;
    const Corners corners = {&a, &b, &c};
    // At an outline, or where a history begins and ends, what is lit of a tube is laid where its lit corners are.
    Corners laid = corners;
    for (const Path*& path : laid)
        if (path->direction == glm::dvec3(0))
            for (const Path* other : corners)
                if (other->outcome == PathOutcome::Lit) path = other;
    const glm::dvec3 whole_power = emission_->power(a.entry, b.entry, c.entry) * short_of_;
    const std::array<double, 3> shares = sharesOfCorners(corners);
    std::array<glm::dvec3, 3> power{};  // of each corner's share
    bool lit = false, directed = true;
    for (const Path* path : laid) directed = directed && path->direction != glm::dvec3(0);
    for (std::size_t i = 0; i < 3; ++i) {
        if (corners[i]->outcome != PathOutcome::Lit) continue;
        power[i] = whole_power * shares[i] * corners[i]->arriving * corners[i]->fraction, lit = true;
    }
    const int axis = lit && directed ? chooseAxis(*laid[0], *laid[1], *laid[2], kLastSlope) : -1;
    // At the floor of refinement, and still no tube: a corner without a ray, or rays that part by 90 degrees.
    const bool no_tube = lit && axis < 0, culled = axis >= 0 && missesBox(laid);
    double PowerLedger::*const unlaid = no_tube ? &PowerLedger::dropped : culled ? &PowerLedger::culled : nullptr;
    const std::size_t first_seed = seeds_.size();
    bool whole = true;
    for (std::size_t i = 0; i < 3; ++i) {
        const Path& path = *corners[i];
        const double handed_on = countCorner(path, whole_power * shares[i], unlaid);
        whole = whole && handed_on > 0;
        if (handed_on <= 0) continue;
        std::size_t s = first_seed;
        while (s < seeds_.size() && seeds_[s].surface != path.end.index) ++s;
        if (s == seeds_.size()) seeds_.push_back({{a.param, b.param, c.param}, face, path.end.index, 0, root_});
        seeds_[s].power += handed_on;
    }
    whole = whole && seeds_.size() == first_seed + 1;
    if (axis >= 0 && !culled) {
        layTube(laid, axis, power);
        if (standsAstride(corners)) astride_ += channelMean(power[0] + power[1] + power[2]);
    }
    return whole ? seeds_[first_seed].surface : -1;
}

void TubeBuilder::joinSeeds(std::size_t first, const Path& a, const Path& b, const Path& c) {
    TubeSeed joined = seeds_[first];
    joined.corner[0] = a.param, joined.corner[1] = b.param, joined.corner[2] = c.param;
    for (std::size_t i = first + 1; i < seeds_.size(); ++i) joined.power += seeds_[i].power;
    seeds_.resize(first);
    seeds_.push_back(joined);
}

// Where legs end on different things the tube is laid once for each of them, with the power of the corners that end
// there: so the outline of a shadow lies neither inside of what casts it nor outside, on the whole.
void TubeBuilder::layTube(const Corners& corners, int axis, const std::array<glm::dvec3, 3>& powers) {
    std::array<double, 3> ends{corners[0]->end_distance, corners[1]->end_distance, corners[2]->end_distance};
    if (optics_->caster().planesOnly() || sameEnd(*corners[0], *corners[1], *corners[2]))
        return layPart(corners, axis, powers[0] + powers[1] + powers[2], ends);
    bool laid[3] = {false, false, false};
    for (std::size_t i = 0; i < 3; ++i) {
        if (laid[i] || corners[i]->outcome != PathOutcome::Lit) continue;
        glm::dvec3 power(0);
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t k = i; k < 3; ++k) {
            if (corners[k]->outcome != PathOutcome::Lit || corners[k]->end != corners[i]->end) continue;
            power += powers[k], laid[k] = true;
            nearest = std::min(nearest, corners[k]->end_distance);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const bool belongs = corners[k]->outcome == PathOutcome::Lit && corners[k]->end == corners[i]->end;
            ends[k] = belongs ? corners[k]->end_distance : nearest;
        }
        if (power != glm::dvec3(0)) layPart(corners, axis, power, ends);
    }
}

void TubeBuilder::layPart(const Corners& corners, int axis, const glm::dvec3& power,
                          const std::array<double, 3>& ends) {
    const Path& a = *corners[0];
    const glm::dvec3 way = a.direction + corners[1]->direction + corners[2]->direction;
    const int s = setFor(axis, frame().indexDirection(a.direction)[axis] > 0, way);
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    openBlock(s, a.medium);
    BlockTopology::Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) triangle.corner[i] = cornerIndex(s, *corners[i], ends[i]);
    open_[static_cast<std::size_t>(s)].triangles.push_back(triangle);
    set.tubes.push_back(constantsOf(corners, axis, power));
    ++tubes_;

    const auto axes = axesFor(axis);
    const glm::dvec3 d = frame().indexDirection(a.direction);
    set.addSlope(d[axes[0]] / d[axis], d[axes[1]] / d[axis], channelMean(power));
}

TubeConstants TubeBuilder::constantsOf(const Corners& corners, int axis, const glm::dvec3& power) const {
    TubeConstants tube{};
    glm::dvec3 travel(0);
    double length = 0;
    for (const Path* path : corners) {
        const double per_layer = 1 / std::fabs(frame().indexDirection(path->direction)[axis]);
        length += per_layer / 3;
        travel += path->direction * per_layer / 3.0;
    }
    tube.length = static_cast<float>(length);
    for (int k = 0; k < 3; ++k) {
        tube.power[k] = static_cast<float>(power[k]);
        tube.travel[k] = static_cast<float>(travel[k]);
    }
    return tube;
}

void TubeBuilder::beginHold() {
    hold_.power = power_, hold_.given_up = given_up_, hold_.astride = astride_;
    hold_.arriving = arriving_, hold_.leaving = leaving_, hold_.kept = kept_;
    hold_.seeds = seeds_.size();
    for (std::size_t s = 0; s < sets_.size(); ++s) hold_.tubes[s] = sets_[s].tubes.size();
}

void TubeBuilder::endHold(Held what, double power) {
    const double found = what == Held::Arriving ? arriving_ - hold_.arriving : leaving_ - hold_.leaving;
    if (!(found > 0)) {
        power_.dropped += power, given_up_.outlines += power;
        return;
    }
    const double scale = power / found;
    for (double PowerLedger::*const term : PowerLedger::kTerms)
        power_.*term = hold_.power.*term + scale * (power_.*term - hold_.power.*term);
    for (double GivenUpPower::*const term : GivenUpPower::kTerms)
        given_up_.*term = hold_.given_up.*term + scale * (given_up_.*term - hold_.given_up.*term);
    astride_ = hold_.astride + scale * (astride_ - hold_.astride);
    arriving_ = hold_.arriving + scale * (arriving_ - hold_.arriving);
    leaving_ = hold_.leaving + scale * (leaving_ - hold_.leaving), kept_ = hold_.kept + scale * (kept_ - hold_.kept);
    for (std::size_t i = hold_.seeds; i < seeds_.size(); ++i) seeds_[i].power *= scale;
    for (std::size_t s = 0; s < sets_.size(); ++s)
        for (std::size_t t = hold_.tubes[s]; t < sets_[s].tubes.size(); ++t)
            for (float& watts : sets_[s].tubes[t].power) watts *= static_cast<float>(scale);
}

void TubeBuilder::reserve(int sense, std::size_t corners, std::size_t tubes) {
    TubeSet& set = sets_[sense < 0 ? 4 : 5];
    set.corners.reserve(corners), set.tubes.reserve(tubes);
}

void TubeBuilder::finish() {
    for (std::size_t s = 0; s < sets_.size(); ++s) closeBlock(static_cast<int>(s));
}

}  // namespace photic
