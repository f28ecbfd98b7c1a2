// SPDX-License-Identifier: Apache-2.0
// Where the rays of a front go apart so unevenly that tubes with straight edges are wrong.
#include "bake/methods/wavefront_bends.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/methods/wavefront_state.h"
#include "bake/threads/parallel_for.h"

namespace photic {

FrontBends FrontBends::ofTwiceTheRays() const {
    FrontBends out(2 * cells);
    // An odd row lies between two of the known ones.
    const auto nearest = [](int i, int along, int last, int which) {
        return std::min(along || i % 2 == 0 || which == 0 ? i / 2 : i / 2 + 1, last);
    };
    for (int j = 0; j <= out.cells.y; ++j)
        for (int i = 0; i <= out.cells.x; ++i)
            for (int way = 0; way < kWays; ++way) {
                Edge& edge = out.edges[out.at(i, j, way)];
                for (int k = 0; k < 2; ++k) {
                    const Edge& coarse =
                        edges[at(nearest(i, kWay[way][0], cells.x, k), nearest(j, kWay[way][1], cells.y, k), way)];
                    edge.bend = std::max(edge.bend, 0.25f * coarse.bend),
                    edge.length = std::max(edge.length, 0.5f * coarse.length);
                }
            }
    return out;
}

/// Finds the rays of a front that continue those of the launched lattice.
void FrontSweep::findLattice(const Front& front, State& state) const {
    const auto& cells = bends_->cells;
    state.of_lattice.assign(static_cast<std::size_t>(cells.x + 1) * static_cast<std::size_t>(cells.y + 1), -1);
    for (std::size_t r = 0; r < front.rays.size(); ++r) {
        const std::uint32_t source = front.rays[r].source;
        if (source == Front::kNoSource) continue;
        // A ray that was handed on in several layers goes the same way in all of them.
        std::int32_t& local = state.of_lattice[source];
        const auto w = [&](std::size_t ray) { return front.sense * front.rays[ray].voxel[front.axis]; };
        if (local < 0 || w(r) < w(static_cast<std::size_t>(local))) local = static_cast<std::int32_t>(r);
    }
}

void FrontSweep::measureBends(const Front& front, const Chunk& chunk, State& state) {
    const BentRows& bent = state.packed.bent;
    const auto axes = axesFor(front.axis);
    const int first_w = chunk.first - origin()[front.axis];
    // Up to which layer some tube needs a ray, times the sense, counted from the grid's first.
    std::vector<float> last(front.rays.size(),
                            front.tubes.empty() ? static_cast<float>(kFarLayers) : static_cast<float>(-kFarLayers));
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t]) continue;
        const bool ends = !state.ends.empty() && state.ends[t].ends;
        const auto until =
            static_cast<float>(ends ? state.ends[t].last - front.sense * origin()[front.axis] : kFarLayers);
        for (const std::uint32_t ray : front.tubes[t].ray) last[ray] = std::max(last[ray], until);
    }
    const glm::ivec3 size = field_.frame().max - field_.frame().min + 1;
    const float high[2] = {static_cast<float>(size[axes[0]]) - 0.5f, static_cast<float>(size[axes[1]]) - 0.5f};
    const glm::ivec2 cells = bends_->cells;
    const int half = chunk.layers / 2;
    const int lanes[2] = {half, front.sense > 0 ? chunk.layers - 1 : 0};
    parallelFor(cells.y + 1, [&](std::int64_t row) {
        const int j = static_cast<int>(row);
        for (const int lane : lanes) {
            struct Place {
                float u, v;
                bool known, lit;
            };
            const auto placeOf = [&](int x, int y) {
                Place place{0, 0, false, false};
                if (x < 0 || y < 0 || x > cells.x || y > cells.y) return place;
                const std::int32_t local = state.of_lattice[static_cast<std::size_t>(y * (cells.x + 1) + x)];
                if (local < 0) return place;
                const auto r = static_cast<std::size_t>(local);
                const auto w = static_cast<float>(front.sense * (first_w + lane));
                const int stopped = state.rays.stopped[r];
                if (w > last[r] || w <= static_cast<float>(front.sense) * state.before.w[r] ||
                    (stopped >= 0 && front.sense * (lane - stopped) >= 0))
                    return place;
                const float* rows = &bent.values[r * bent.rayStride()] + lane;
                place.u = rows[BentRows::kU * BentRows::kLanes], place.v = rows[BentRows::kV * BentRows::kLanes];
                place.lit = rows[BentRows::kLit * BentRows::kLanes] > 0, place.known = true;
                return place;
            };
            for (int i = 0; i <= cells.x; ++i) {
                const Place a = placeOf(i, j);
                if (!a.known) continue;
                for (int way = 0; way < FrontBends::kWays; ++way) {
                    const int di = FrontBends::kWay[way][0], dj = FrontBends::kWay[way][1];
                    const Place b = placeOf(i + di, j + dj);
                    // Light that does not count, or lies beside the grid, may be wrong.
                    if (!b.known || !(a.lit || b.lit) || std::max(a.u, b.u) < -0.5f || std::min(a.u, b.u) > high[0] ||
                        std::max(a.v, b.v) < -0.5f || std::min(a.v, b.v) > high[1])
                        continue;
                    const Place before = placeOf(i - di, j - dj), after = placeOf(i + 2 * di, j + 2 * dj);
                    float u = 0, v = 0;
                    if (before.known) u += before.u - 2 * a.u + b.u, v += before.v - 2 * a.v + b.v;
                    if (after.known) u += a.u - 2 * b.u + after.u, v += a.v - 2 * b.v + after.v;
                    // A cubic through four rays in a row leaves the middle edge by the mean of both differences.
                    const float share = before.known && after.known ? 0.5f : 1.0f;
                    FrontBends::Edge& edge = bends_->edges[bends_->at(i, j, way)];
                    edge.bend = std::max(edge.bend, share * std::hypot(u, v)),
                    edge.length = std::max(edge.length, std::hypot(b.u - a.u, b.v - a.v));
                }
            }
        }
    });
}

bool FrontSweep::scout(const Front& front, bool to_the_end, FrontBends& bends) {
    Front some;
    some.axis = front.axis, some.sense = front.sense, some.cells = front.cells / 2;
    for (int j = 0; j <= some.cells.y; ++j)
        for (int i = 0; i <= some.cells.x; ++i) {
            some.rays.push_back(front.rays[static_cast<std::size_t>(2 * j * (front.cells.x + 1) + 2 * i)]);
            some.rays.back().source = static_cast<std::uint32_t>(some.rays.size() - 1);
        }
    FrontBends coarse(some.cells);
    bends_ = &coarse;
    State state;
    if (!to_the_end) state.least_cosine = 0.7071f;
    setOut(some, state);
    pack(some, {}, state.packed);
    findLattice(some, state);
    const auto groups = groupsAlong(front.axis);
    bool turns = false;
    for (const Chunk& chunk : chunksOf(some, groups)) {
        monitor_.checkCancelled();
        march(some, chunk, state);
        turns = std::any_of(state.rays.stopped.begin(), state.rays.stopped.end(), [](int lane) { return lane >= 0; });
        if (turns && !to_the_end) break;
        if (chunk.group) measureBends(some, chunk, state);
    }
    bends_ = nullptr;
    bends = coarse.ofTwiceTheRays();
    return turns;
}

}  // namespace photic
