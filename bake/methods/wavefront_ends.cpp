// SPDX-License-Identifier: Apache-2.0
// Where objects end a front.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/methods/wavefront_state.h"
#include "bake/threads/parallel_for.h"

namespace photic {

/// Where a ray is on its way, in index space.
struct FrontSweep::WayPoint {
    glm::dvec3 voxel{0}, left{1};  // left: of its power, per channel
    glm::dvec3 way{0};             // of travel, in index space, as long as a layer is high
    double time = 0;               // optical path so far [m]
};

/// Follows a ray's end from one place to the next, along the light.
void FrontSweep::follow(const Front& front, const Front::Ray& ray, const WayPoint& from, const WayPoint& to, double lit,
                        RayEnd& end) const {
    const int w = front.axis;
    if (!end.meets()) {
        const auto hit = space_->obstacles->onWay(from.voxel, to.voxel, {ray.voxel, ray.surface}, front.inside);
        if (!hit) return;
        const glm::dvec3 way = to.voxel - from.voxel;
        end.hit = front.sense * (from.voxel[w] + hit->at * way[w]), end.target = hit->target;
        end.last = from.voxel + hit->deposit * way, end.face = hit->normal;
        end.beside = hit->beside, end.lit = lit, end.left = glm::mix(from.left, to.left, hit->at);
        if (hit->target.kind == Target::Kind::Surface) {
            end.deposit = front.sense * end.hit, end.done = true;
            end.meeting = hit->meeting, end.inside = hit->inside;
            end.direction = glm::normalize(field_.frame().worldFromIndex() *
                                           glm::mix(from.way, to.way, glm::clamp(hit->at, 0.0, 1.0)));
            end.time = glm::mix(from.time, to.time, hit->at);
            return;
        }
    }
    // Behind a receiver light goes on to a plane beside its face, bent as it is, and no further than straight on.
    const double before = glm::dot(from.voxel - end.last, end.face), behind = glm::dot(to.voxel - end.last, end.face);
    const bool crosses = before != behind && (before > 0) != (behind > 0);
    const double crossing = crosses ? glm::mix(from.voxel[w], to.voxel[w], before / (before - behind)) : end.last[w];
    end.deposit = front.sense * std::min(front.sense * crossing, front.sense * end.last[w]);
    end.deposit = front.sense * std::max(front.sense * end.deposit, end.hit);
    end.done = crosses || front.sense * (to.voxel[w] - end.last[w]) >= 0;
}

/// Marches a front ahead, and notes where its rays meet objects and where they turn away.
void FrontSweep::findRayEnds(const Front& front, const std::vector<Chunk>& chunks, State& state,
                             std::vector<RayEnd>& ends, std::vector<char>& parted) {
    const auto axes = axesFor(front.axis);
    const FrontRays start = state.rays;
    const BentRows& bent = state.packed.bent;
    ends.assign(front.rays.size(), {});
    parted.assign(lost_ ? front.tubes.size() : 0, 0);
    const auto voxelAt = [&](double u, double v, double w) {
        glm::dvec3 voxel;
        voxel[axes[0]] = u, voxel[axes[1]] = v, voxel[axes[2]] = w;
        return voxel + glm::dvec3(origin());
    };
    for (const Chunk& chunk : chunks) {
        monitor_.checkCancelled();
        march(front, chunk, state);
        const bool last_chunk = &chunk == &chunks.back();
        const int first_w = chunk.first - origin()[front.axis];
        parallelFor(static_cast<std::int64_t>(front.rays.size()), [&](std::int64_t i) {
            const auto r = static_cast<std::size_t>(i);
            RayEnd& end = ends[r];
            if (end.done || end.turns < kFarLayers) return;
            const FrontRays& before = state.before;
            double last_w = double(before.w[r]);
            WayPoint last{voxelAt(double(before.u[r]), double(before.v[r]), last_w)};
            last.way =
                voxelAt(double(before.pu[r]) / double(bent.voxel[0]), double(before.pv[r]) / double(bent.voxel[1]),
                        front.sense * double(before.pw[r]) / double(bent.voxel[2])) -
                glm::dvec3(origin());
            last.way *= double(bent.voxel[2]) / double(before.pw[r]);
            if (state.timed) last.time = state.time_origin + double(before.time[r]);
            for (int k = 0; k < 3 && state.attenuates; ++k)
                last.left[k] = std::exp(-double(before.depth[std::min(k, state.channels - 1)][r]));
            const float* rows = &bent.values[r * bent.rayStride()];
            for (int layer = 0; layer < chunk.layers && !end.done; ++layer) {
                const int lane = front.sense > 0 ? layer : chunk.layers - 1 - layer;
                const auto row = [&](int which) { return double(rows[which * BentRows::kLanes + lane]); };
                if (state.rays.stopped[r] == lane) {
                    end.turns = front.sense * (chunk.first + lane - 0.5 * front.sense);
                    return;
                }
                const double w = first_w + lane;
                if (front.sense * (w - last_w) <= 0) continue;  // it has not started
                WayPoint at{voxelAt(row(BentRows::kU), row(BentRows::kV), w)};
                at.way =
                    voxelAt(front.sense * row(BentRows::kSlopeU), front.sense * row(BentRows::kSlopeV), front.sense) -
                    glm::dvec3(origin());
                if (state.timed) at.time = state.time_origin + row(bent.timeRow());
                for (int k = 0; k < 3; ++k) at.left[k] = row(BentRows::kLeft + std::min(k, bent.channels - 1));
                follow(front, front.rays[r], last, at, row(BentRows::kLit), end);
                last = at, last_w = w;
                if (!last_chunk || layer + 1 < chunk.layers) continue;
                const double half = 0.5 * front.sense;  // to the far side of the last layer
                at.voxel = voxelAt(row(BentRows::kU) + half * row(BentRows::kSlopeU),
                                   row(BentRows::kV) + half * row(BentRows::kSlopeV), w + half);
                if (!end.done) follow(front, front.rays[r], last, at, row(BentRows::kLit), end);
            }
        });
        parallelFor(static_cast<std::int64_t>(parted.size()), [&](std::int64_t t) {
            const auto tube = static_cast<std::size_t>(t);
            if (!parted[tube]) parted[tube] = standsWithin(front, chunk, state, ends, front.tubes[tube]) ? 1 : 0;
        });
    }
    state.rays = start;
}

/// The same where rays go straight: in one leg each.
void FrontSweep::findStraightEnds(const Front& front, const State& state, std::vector<RayEnd>& ends,
                                  std::vector<char>& parted) const {
    ends.assign(front.rays.size(), {});
    parted.assign(lost_ ? front.tubes.size() : 0, 0);
    const GridFrame& frame = field_.frame();
    const int w = front.axis;
    const double n = std::sqrt(2 * space_->even);
    std::vector<glm::dvec3> last(front.rays.size());
    parallelFor(static_cast<std::int64_t>(front.rays.size()), [&](std::int64_t i) {
        const auto r = static_cast<std::size_t>(i);
        const Front::Ray& ray = front.rays[r];
        RayEnd& end = ends[r];
        end.done = true;
        const glm::dvec3 direction = glm::normalize(ray.momentum), along = frame.indexDirection(direction);
        last[r] = space_->obstacles->exitOf(ray.voxel, along);
        // As the kernel finds it in the first layer: another front takes it up.
        if (front.sense * direction[w] < double(state.least_cosine) && (ray.lit || !goesStraight(state))) {
            end.turns = front.sense * ray.voxel[w];
            return;
        }
        const auto hit = space_->obstacles->straightOn({ray.voxel, ray.surface}, last[r], front.inside);
        if (!hit) return;
        const glm::dvec3 way = last[r] - ray.voxel;
        const double length = glm::length(frame.worldFromIndex(last[r]) - frame.worldFromIndex(ray.voxel)) * hit->at;
        end.hit = front.sense * (ray.voxel[w] + hit->at * way[w]);
        end.deposit = ray.voxel[w] + hit->deposit * way[w];
        end.target = hit->target, end.face = hit->normal, end.last = ray.voxel + hit->deposit * way;
        end.lit = ray.lit ? 1 : 0;
        for (int k = 0; k < 3; ++k) {
            const int channel = std::min(k, state.channels - 1);
            end.left[k] = state.attenuates ? std::exp(-double(space_->table.extinction[1][channel]) * length) : 1.0;
        }
        end.meeting = hit->meeting, end.inside = hit->inside, end.direction = direction;
        end.time = ray.time + n * length;
        last[r] = ray.voxel + hit->at * way;
    });
    parallelFor(static_cast<std::int64_t>(parted.size()), [&](std::int64_t t) {
        const Front::Tube& tube = front.tubes[static_cast<std::size_t>(t)];
        // A voxel before what is met: that is not between them.
        double nearest = std::numeric_limits<double>::infinity();
        for (const std::uint32_t ray : tube.ray)
            nearest = std::min(nearest, glm::distance(last[ray], front.rays[ray].voxel) - 1);
        if (!(nearest > 0)) return;
        std::array<std::array<glm::dvec3, 3>, 3> places;
        for (std::size_t c = 0; c < 3; ++c) {
            const glm::dvec3& from = front.rays[tube.ray[c]].voxel;
            const glm::dvec3 way = last[tube.ray[c]] - from;
            const double share = std::min(1.0, nearest / glm::length(way));
            for (std::size_t p = 0; p < 3; ++p) places[c][p] = from + 0.5 * double(p) * share * way;
        }
        parted[static_cast<std::size_t>(t)] =
            space_->obstacles->standsBetween(places, front.rays[tube.ray[0]].surface, true) ? 1 : 0;
    });
}

/// Whether something stands between the rays of a tube in a chunk, before they meet anything: a post that none of them
/// meets.
bool FrontSweep::standsWithin(const Front& front, const Chunk& chunk, const State& state,
                              const std::vector<RayEnd>& ends, const Front::Tube& tube) const {
    const auto axes = axesFor(front.axis);
    const BentRows& bent = state.packed.bent;
    const int first_w = chunk.first - origin()[front.axis];
    double last = kFarLayers, begin = -kFarLayers;  // layers from the grid's first, times the sense
    for (const std::uint32_t ray : tube.ray) {
        const RayEnd& end = ends[ray];
        // A voxel before what is met: that is not between them.
        last = std::min(last, std::min(end.hit - front.sense * origin()[front.axis] - 1,
                                       end.turns - front.sense * origin()[front.axis] - 1));
        begin = std::max(begin, front.sense * double(state.before.w[ray]));
    }
    int lanes[2] = {-1, -1};  // in the light's order: the middle and the last that all rays pass
    int passed = 0;
    for (int layer = 0; layer < chunk.layers; ++layer) {
        const int lane = front.sense > 0 ? layer : chunk.layers - 1 - layer;
        const double w = front.sense * (first_w + lane);
        if (w <= begin || w > last) continue;
        lanes[1] = lane, ++passed;
        if (passed == 1 || layer <= chunk.layers / 2) lanes[0] = lane;
    }
    if (passed == 0) return false;
    std::array<std::array<glm::dvec3, 3>, 3> places;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t ray = tube.ray[c];
        const auto at = [&](double u, double v, double w) {
            glm::dvec3 voxel;
            voxel[axes[0]] = u, voxel[axes[1]] = v, voxel[axes[2]] = w;
            return voxel + glm::dvec3(origin());
        };
        const FrontRays& before = state.before;
        places[c][0] = at(double(before.u[ray]), double(before.v[ray]), double(before.w[ray]));
        for (std::size_t i = 0; i < 2; ++i) {
            const float* rows = &bent.values[ray * bent.rayStride()] + lanes[i];
            places[c][i + 1] = at(double(rows[BentRows::kU * BentRows::kLanes]),
                                  double(rows[BentRows::kV * BentRows::kLanes]), first_w + lanes[i]);
        }
    }
    return space_->obstacles->standsBetween(places, front.rays[tube.ray[0]].surface, false);
}

/// Where the tubes of a front end on objects. A tube of which one ray meets something else, or much later, ends where
/// the middle one of its rays does; it is as narrow as it can be.
void FrontSweep::findEnds(const Front& front, const std::vector<Chunk>& chunks, State& state) {
    std::vector<RayEnd> rays;
    std::vector<char> parted;
    if (space_->index)
        findRayEnds(front, chunks, state, rays, parted);
    else
        findStraightEnds(front, state, rays, parted);
    state.ends.assign(front.tubes.size(), {});
    // Layers: what is steeper is not one face that the tube meets, unless it is flat.
    constexpr double kSteep = 4, kLedge = 1;
    constexpr double kFlat = 1e-6;  // of normals
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        const Front::Tube& tube = front.tubes[t];
        if (lost_ && parted[t]) lost_->push_back(tube.source);
        double turns = kFarLayers;
        for (const std::uint32_t ray : tube.ray) turns = std::min(turns, rays[ray].turns);
        std::array<const RayEnd*, 3> met{};
        int count = 0;
        for (const std::uint32_t ray : tube.ray)
            if (rays[ray].hit < turns) met[static_cast<std::size_t>(count++)] = &rays[ray];
        if (count == 0) continue;
        const auto later = [](const RayEnd* a, const RayEnd* b) { return a->hit < b->hit; };
        const auto [first, last] = std::minmax_element(met.begin(), met.begin() + count, later);
        const double spread = (*last)->hit - (*first)->hit;
        const auto middleOf = [&](const std::array<const RayEnd*, 3>& of, int many) {
            // Of two, a third goes on for ever.
            const RayEnd* middle = *last;
            for (int i = 0; i < many && many == 3; ++i)
                if (of.begin() + i != first && of.begin() + i != last) middle = of[static_cast<std::size_t>(i)];
            // Beside surfaces two that meet one thing decide.
            for (int i = 0; i < many && space_->beyond; ++i)
                for (int j = 0; j < i; ++j) {
                    const RayEnd *a = of[static_cast<std::size_t>(i)], *b = of[static_cast<std::size_t>(j)];
                    if (a->target == b->target && middle->target != a->target) return a;
                }
            return middle;
        };
        const auto all = [&](const auto& alike) { return std::all_of(met.begin(), met.begin() + count, alike); };
        const bool same = all([&](const RayEnd*end) { return end->target == met[0]->target; }),
                   flat = same && all([&](const RayEnd*end) { return glm::distance(end->face, met[0]->face) < kFlat; });
        TubeEnd& end = state.ends[t];
        const bool agree = count == 3 && (flat || spread <= (same ? kSteep : kLedge));
        if (!agree && lost_) lost_->push_back(tube.source);
        const RayEnd* const middle = count == 1 ? nullptr : middleOf(met, count);
        if (count > 1 && middle->target.kind == Target::Kind::Surface) {
            end = handedOn(front, tube, rays, *middle, state);
            continue;
        }
        if (count == 1) continue;
        if (!agree) {
            met = {middle, middle, middle};
        }
        end.ends = true;
        for (std::size_t c = 0; c < 3; ++c) {
            end.deposit[c] = met[c]->deposit;
            end.last = std::max(end.last, front.sense * met[c]->deposit);
            end.lit += met[c]->lit / 3, end.left += met[c]->left / 3.0, end.beside += met[c]->beside ? 1 / 3.0 : 0;
        }
    }
}

void FrontSweep::countEnd(const Front& front, std::size_t tube, const TubeEnd& end) {
    if (end.handed_on) return;
    const glm::dvec3& power = front.tubes[tube].power;
    countLoss(power, end.left);
    const double passes = channelMean(power * end.left), arrives = passes * (1 - end.beside);
    totals_.power.received += arrives * end.lit, totals_.power.absorbed_surface += arrives * (1 - end.lit);
    totals_.power.escaped += passes * end.beside * end.lit, totals_.power.culled += passes * end.beside * (1 - end.lit);
}

/// Takes tubes that a chunk has laid to their ends.
void FrontSweep::retire(const Front& front, const Chunk& chunk, State& state) {
    if (state.ends.empty()) return;
    const double exit = front.sense * (front.sense > 0 ? chunk.first + chunk.layers - 0.5 : chunk.first - 0.5);
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t] || !state.ends[t].ends || state.ends[t].last > exit) continue;
        state.alive[t] = 0;
        for (float& power : state.packed.set.tubes[t].power) power = 0;
        countEnd(front, t, state.ends[t]);
    }
}

}  // namespace photic
