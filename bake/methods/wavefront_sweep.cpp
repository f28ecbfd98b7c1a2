// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "bake/methods/graded_space.h"
#include "bake/methods/wavefront_state.h"
#include "bake/report/stopwatch.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kLanes = BentRows::kLanes;

/// Surfaces make many small fronts: those that go the same way in the same media are one.
std::vector<Front> joined(std::vector<Front> fronts) {
    std::map<FrontWay, Front> by_way;
    for (Front& front : fronts) {
        const auto [at, fresh] = by_way.try_emplace(wayOf(front.axis, front.sense, front.inside));
        if (fresh)
            at->second = std::move(front);
        else
            at->second.append(front);
    }
    std::vector<Front> out;
    for (auto& [way, front] : by_way) out.push_back(std::move(front));
    return out;
}

}  // namespace

void Front::append(const Front& other) {
    const auto first = static_cast<std::uint32_t>(rays.size());
    rays.insert(rays.end(), other.rays.begin(), other.rays.end());
    for (Tube tube : other.tubes) {
        for (std::uint32_t& ray : tube.ray) ray += first;
        tubes.push_back(tube);
    }
}

std::vector<FrontSweep::Chunk> FrontSweep::chunksOf(const Front& front, const std::vector<SlabGroup>& groups) const {
    std::vector<Chunk> chunks;
    int next = space_->low[front.axis];
    const auto skipTo = [&](int layer) {
        for (; next < layer; next += std::min(kLanes, layer - next))
            chunks.push_back({next, std::min(kLanes, layer - next), nullptr, 0});
    };
    for (const SlabGroup& group : groups)
        for (std::size_t s = 0; s < group.slabs.size(); ++s) {
            skipTo(group.slabs[s].first);
            chunks.push_back({group.slabs[s].first, group.slabs[s].active, &group, s});
            next = group.slabs[s].first + group.slabs[s].active;
        }
    skipTo(space_->high[front.axis] + 1);
    if (front.sense < 0) std::reverse(chunks.begin(), chunks.end());
    return chunks;
}

/// Where the index changes much within a step, a ray may gain or lose more than it should, and light that is to be
/// reflected totally leaks out of its glass: there steps are shorter.
int FrontSweep::stepsIn(const Front& front, const Chunk& chunk) const {
    if (!space_->index) return 1;
    constexpr double kGentle = 0.05;  // of n^2 / 2
    constexpr int kMost = 8;
    const int first = chunk.first - space_->first_node[front.axis];
    const double steep = space_->index->steepest(front.axis, first - 2, first + chunk.layers + 1);
    return std::max(space_->steps, std::min(kMost, static_cast<int>(std::ceil(steep / kGentle))));
}

void FrontSweep::march(const Front& front, const Chunk& chunk, State& state) {
    const Stopwatch watch;
    const glm::ivec3 node = space_->first_node - origin();
    const int first_w = chunk.first - origin()[front.axis];
    const bool one_by_one = space_->index && space_->integrator != FrontIntegrator::Planes;
    if (one_by_one)
        state.slices.steps = stepsIn(front, chunk);
    else if (space_->index)
        collapseIndex(*space_->index, {front.axis, node}, first_w, chunk.layers, front.sense, stepsIn(front, chunk),
                      state.slices);
    else
        state.slices.columns = state.slices.rows = state.slices.steps = 1;
    if (SweepWork* work = totals_.work) {
        const double steps = double(chunk.layers) * state.slices.steps;
        work->ray_steps += steps * static_cast<double>(front.rays.size());
        if (space_->index && !one_by_one) work->nodes += steps * static_cast<double>(state.slices.plane());
    }
    FrontMedia media = space_->table;
    const auto axes = axesFor(front.axis);
    // What is the same everywhere has one node.
    const glm::ivec3 count = space_->index ? space_->index->nodes().count : glm::ivec3(0);
    const std::size_t strides[3] = {space_->index ? std::size_t{1} : 0, static_cast<std::size_t>(count.x),
                                    static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y)};
    media.of_node = state.attenuates ? space_->media.data() : nullptr;
    media.stride_u = strides[axes[0]], media.stride_v = strides[axes[1]], media.stride_w = strides[axes[2]];

    FrontMarch march;
    march.slices = &state.slices, march.media = &media;
    std::copy_n(state.packed.bent.voxel, 3, march.voxel);
    march.first_w = first_w, march.layers = chunk.layers, march.sense = front.sense;
    march.node_w = node[front.axis];
    if (!space_->index) march.even = static_cast<float>(space_->even);
    march.least_lit = space_->least_lit, march.channels = state.channels, march.least_cosine = state.least_cosine;
    BentRows& bent = state.packed.bent;
    bent.values.resize(front.rays.size() * bent.rayStride());
    state.before = state.rays;
    const FrontPlaces places{space_->index, {axes[0], axes[1], axes[2]}, node, state.slices.steps};
    constexpr std::size_t kBatch = 1024;
    const FrontKernel kernel = frontKernel();
    parallelFor(static_cast<std::int64_t>((front.rays.size() + kBatch - 1) / kBatch), [&](std::int64_t i) {
        const std::size_t from = static_cast<std::size_t>(i) * kBatch,
                          many = std::min(kBatch, state.rays.u.size() - from);
        if (one_by_one)
            marchFrontBy(space_->integrator, places, march, state.rays, from, many, bent.values.data(),
                         bent.rayStride());
        else
            kernel(march, state.rays, from, many, bent.values.data(), bent.rayStride());
    });
    totals_.trace_seconds += watch.seconds();
}

void FrontSweep::countLoss(const glm::dvec3& power, const glm::dvec3& left) {
    const glm::dvec3 lost = power * (1.0 - left);
    totals_.power.absorbed_medium += channelMean(lost * space_->absorbed_share);
    totals_.power.scattered += channelMean(lost * (1.0 - space_->absorbed_share));
}

void FrontSweep::finish(const Front& front, const State& state) {
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t]) continue;
        if (!state.ends.empty() && state.ends[t].ends) {
            countEnd(front, t, state.ends[t]);
            continue;
        }
        glm::dvec3 left(0);
        double lit = 0;  // a tube at the rim of a medium counts by its corners
        for (const std::uint32_t ray : front.tubes[t].ray) {
            lit += double(state.rays.lit[ray]) / 3;
            for (int k = 0; k < 3; ++k)
                left[k] += (state.attenuates ? std::exp(-double(state.rays.depth[std::min(k, state.channels - 1)][ray]))
                                             : 1.0) /
                           3;
        }
        countLoss(front.tubes[t].power, left);
        const double power = channelMean(front.tubes[t].power * left);
        totals_.power.escaped += power * lit, totals_.power.culled += power * (1 - lit);
    }
}

std::vector<std::uint32_t> FrontSweep::findLost(Front front, FrontBends* bends) {
    // What surfaces send on that is fainter than that need not be followed well.
    constexpr double kFaint = 0.02;
    for (std::uint32_t t = 0; t < front.tubes.size(); ++t)
        front.tubes[t].source = t,
        front.tubes[t].least = std::max(front.tubes[t].least, kFaint * channelMean(front.tubes[t].power));
    for (std::uint32_t r = 0; bends && r < front.rays.size(); ++r) front.rays[r].source = r;
    std::vector<std::uint32_t> lost;
    lost_ = &lost, bends_ = bends;
    for (const Front::Tube& tube : front.tubes) {
        const int shadowed = std::accumulate(tube.ray, tube.ray + 3, 0, [&](int sum, std::uint32_t ray) {
            return sum + (front.rays[ray].shadowed ? 1 : 0);
        });
        if (shadowed == 1 || shadowed == 2) lost.push_back(tube.source);
    }
    std::vector<Front> fronts;
    fronts.push_back(std::move(front));
    runAll(std::move(fronts), [](double, double) {});
    lost_ = nullptr, bends_ = nullptr;
    std::sort(lost.begin(), lost.end());
    lost.erase(std::unique(lost.begin(), lost.end()), lost.end());
    return lost;
}

void FrontSweep::runAll(std::vector<Front> fronts, const std::function<void(double, double)>& progress) {
    double from = 0, share = 0.7;  // the fronts that go on are fewer and fewer
    while (!fronts.empty()) {
        std::vector<Front> next;
        const double each = share / static_cast<double>(fronts.size());
        for (std::size_t i = 0; i < fronts.size(); ++i) {
            progress(from + each * static_cast<double>(i), each);
            for (Front& on : run(fronts[i])) next.push_back(std::move(on));
        }
        fronts = space_->beyond && !sinks_.strongest ? joined(std::move(next)) : std::move(next);
        from += share, share = 0.5 * (1 - from);
    }
}

/// Puts a front's rays at their start.
void FrontSweep::setOut(const Front& front, State& state) const {
    state.attenuates = !space_->media.empty(), state.channels = field_.channels().irradiance;
    const auto axes = axesFor(front.axis);
    state.timed = sinks_.first != nullptr && !lost_;
    if (state.timed) state.time_origin = front.rays.front().time;
    state.rays.resize(front.rays.size(), state.attenuates, state.timed);
    for (std::size_t r = 0; r < front.rays.size(); ++r) {
        const Front::Ray& ray = front.rays[r];
        const glm::dvec3 voxel = ray.voxel - glm::dvec3(origin());
        state.rays.u[r] = static_cast<float>(voxel[axes[0]]), state.rays.v[r] = static_cast<float>(voxel[axes[1]]),
        state.rays.w[r] = static_cast<float>(voxel[axes[2]]);
        state.rays.pu[r] = static_cast<float>(ray.momentum[axes[0]]),
        state.rays.pv[r] = static_cast<float>(ray.momentum[axes[1]]),
        state.rays.pw[r] = static_cast<float>(front.sense * ray.momentum[axes[2]]);
        state.rays.lit[r] = ray.lit ? 1.0f : 0.0f;
        if (state.timed) state.rays.time[r] = static_cast<float>(ray.time - state.time_origin);
    }
}

std::vector<SlabGroup> FrontSweep::groupsAlong(int axis) const {
    return planSlabs(field_.needed(), axis, TileSums::kColumns, widestLanes(options_.instruction_set));
}

std::vector<Front> FrontSweep::run(const Front& front) {
    if (front.tubes.empty()) return {};
    space_ = start_.beyond ? &start_.beyond->spaceOf(front.inside) : &start_;
    State state;
    setOut(front, state);
    const auto groups = groupsAlong(front.axis);
    const std::vector<Chunk> chunks = chunksOf(front, groups);
    pack(front, {}, state.packed);
    state.packed.bent.timed = state.timed;
    if (space_->obstacles) {
        findEnds(front, chunks, state);
        pack(front, state.ends, state.packed);
    }
    if (sinks_.strongest && !lost_) sinks_.strongest->beginFront();
    state.alive.assign(front.tubes.size(), 1);
    totals_.tubes += static_cast<std::int64_t>(front.tubes.size());
    totals_.rays += static_cast<std::int64_t>(front.rays.size());

    if (bends_ && space_->index) findLattice(front, state);
    const auto rest = [&] {
        finish(front, state);
        std::vector<Front> out;
        for (auto& [way, next] : state.next) out.push_back(std::move(next));
        return out;
    };
    // Light that does not count yet goes straight to where it ends.
    const bool counts =
        std::any_of(front.rays.begin(), front.rays.end(), [](const Front::Ray& ray) { return ray.lit; });
    if (!counts && goesStraight(state)) return rest();
    double earliest = kFarLayers;
    for (const Front::Ray& ray : front.rays) earliest = std::min(earliest, front.sense * ray.voxel[front.axis]);
    std::size_t done = 0;
    for (const Chunk& chunk : chunks) {
        monitor_.checkCancelled();
        monitor_.progress("deposit", static_cast<double>(done++) / static_cast<double>(chunks.size()));
        const double exit = front.sense > 0 ? chunk.first + chunk.layers : -(chunk.first - 1.0);
        if (exit < earliest) continue;  // all rays start beyond it
        if (space_->beyond && std::find(state.alive.begin(), state.alive.end(), 1) == state.alive.end()) break;
        march(front, chunk, state);
        if (bends_ && chunk.group && space_->index) measureBends(front, chunk, state);
        turnAway(front, chunk, state);
        const Stopwatch watch;
        if (chunk.group && !lost_)
            lay(front, chunk, state);
        else
            for (const Turned& t : state.turned)
                for (float& power : state.packed.set.tubes[t.tube].power) power = 0;
        retire(front, chunk, state);
        totals_.deposit_seconds += watch.seconds();
    }
    return rest();
}

bool FrontSweep::goesStraight(const State& state) const {
    return !space_->index && !state.attenuates && space_->least_lit > 0 && space_->obstacles;
}

}  // namespace photic
