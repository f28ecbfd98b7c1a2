// SPDX-License-Identifier: Apache-2.0
// A front's tubes as the deposit takes them.
#include <algorithm>
#include <cmath>

#include "bake/methods/wavefront_state.h"

namespace photic {
namespace {

constexpr std::size_t kTubesOfBlock = 128;

}  // namespace

void FrontSweep::pack(const Front& front, const std::vector<TubeEnd>& ends, Packed& packed) const {
    packed.set = {}, packed.cells.clear(), packed.bent.rays.clear();
    TubeSet& set = packed.set;
    const int channels = field_.channels().irradiance;
    set.axis = front.axis, set.sense = front.sense, set.channels = channels;
    const auto axes = axesFor(front.axis);
    for (std::size_t a = 0; a < 3; ++a)
        packed.bent.voxel[a] = static_cast<float>(field_.frame().worldFromIndex()[axes[a]][axes[a]]);
    for (std::size_t a = 0; a < 2; ++a) packed.bent.first_column[a] = origin()[axes[a]];
    packed.bent.channels = channels;
    std::vector<std::uint32_t> local(front.rays.size(), 0), stamp(front.rays.size(), 0);
    std::uint32_t block_number = 0;
    for (std::size_t from = 0; from < front.tubes.size(); from += kTubesOfBlock) {
        const std::size_t to = std::min(from + kTubesOfBlock, front.tubes.size());
        // At most 255 corners a block: tubes that hang together have far fewer, loose ones three each.
        std::size_t t = from;
        while (t < to) {
            ++block_number;
            TubeBlock block{nullptr, static_cast<std::uint32_t>(set.corners.size()),
                            static_cast<std::uint32_t>(set.tubes.size())};
            std::vector<BlockTopology::Triangle> triangles;
            std::uint32_t corners = 0;
            for (; t < to && corners + 3 < BlockTopology::kNone; ++t) {
                BlockTopology::Triangle triangle{};
                for (int c = 0; c < 3; ++c) {
                    const std::uint32_t ray = front.tubes[t].ray[c];
                    CornerRay corner;
                    corner.w = front.rays[ray].voxel[front.axis];
                    corner.w_end = !ends.empty() && ends[t].ends ? ends[t].deposit[static_cast<std::size_t>(c)]
                                                                 : front.sense * kFarLayers;
                    // Tubes share a corner where their light ends alike.
                    const bool known = stamp[ray] == block_number &&
                                       set.corners[block.first_corner + local[ray]].w_end == corner.w_end;
                    if (!known) {
                        stamp[ray] = block_number, local[ray] = corners++;
                        set.corners.push_back(corner), packed.bent.rays.push_back(ray);
                    }
                    triangle.corner[c] = static_cast<std::uint8_t>(local[ray]);
                }
                triangles.push_back(triangle);
                TubeConstants tube{};
                const glm::dvec3& power = front.tubes[t].power;
                for (int k = 0; k < 3; ++k) tube.power[k] = static_cast<float>(channels == 3 ? power[k] : power[0]);
                set.tubes.push_back(tube);
                packed.cells.push_back(front.tubes[t].cell);
            }
            const auto same = [&](const BlockTopology& other) {
                return other.vertex_count == static_cast<int>(corners) && other.triangles.size() == triangles.size() &&
                       std::equal(
                           triangles.begin(), triangles.end(), other.triangles.begin(),
                           [](const auto& a, const auto& b) { return std::equal(a.corner, a.corner + 3, b.corner); });
            };
            block.topology = !set.blocks.empty() && same(*set.blocks.back().topology)
                                 ? set.blocks.back().topology
                                 : BlockTopology::fromTriangles(static_cast<int>(corners), std::move(triangles));
            set.blocks.push_back(std::move(block));
        }
    }
}

void FrontSweep::lay(const Front& front, const Chunk& chunk, State& state) {
    TubeSet& set = state.packed.set;
    const BentRows& bent = state.packed.bent;
    for (const Turned& t : state.turned)
        for (float& power : set.tubes[t.tube].power) power = 0;
    // The buffer follows the mean slope of the light; how often a layer is evaluated follows all slopes, which are of
    // both signs where light comes together.
    set.slope_u_power = set.slope_v_power = set.slope_power = 0;
    const std::size_t step = std::max<std::size_t>(1, front.tubes.size() / 4096);
    // Looked at in the middle of every eight layers: how many a chunk has depends on the processor.
    constexpr int kLookEvery = 8;
    int points = 1;
    for (int look = 0; look < chunk.layers; look += kLookEvery) {
        const int lane = std::min(look + kLookEvery / 2, chunk.layers - 1);
        double squares = 0, looked_at = 0;
        for (std::size_t t = 0; t < front.tubes.size(); t += step) {
            if (!state.alive[t]) continue;
            const float* rows = &bent.values[front.tubes[t].ray[0] * bent.rayStride()];
            const auto row = [&](int which) { return static_cast<double>(rows[which * BentRows::kLanes + lane]); };
            const double power = channelMean(front.tubes[t].power) * row(BentRows::kLit), u = row(BentRows::kSlopeU),
                         v = row(BentRows::kSlopeV);
            looked_at += power, set.slope_u_power += power * u, set.slope_v_power += power * v;
            squares += power * (u * u + v * v);
        }
        set.slope_power += looked_at;
        if (looked_at > 0) points = std::max(points, pointsAcrossLayer(std::sqrt(squares / looked_at)));
    }
    state.options = options_;
    if (options_.quadrature == 0) state.options.quadrature = points;
    if (totals_.work)
        totals_.work->deposit +=
            depositWork(set, bent, field_.frame(), chunk.layers) * std::max(1, state.options.quadrature);
    Packed turned;
    if (!state.turned.empty()) packTurned(front, chunk, state, turned);
    const Slab& slab = chunk.group->slabs[chunk.slab];
    std::vector<BentTubes> tubes{{set, bent, state.packed.cells}};
    if (!state.turned.empty()) tubes.push_back({turned.set, turned.bent, turned.cells});
    if (sinks_.strongest)
        sinks_.strongest->lay(tubes, slab, state.options.quadrature, totals_.deposit);
    else
        for (const BentTubes& of : tubes)
            voxeliseSlab(of.set, of.bent, *chunk.group, chunk.slab, field_, state.options, totals_.deposit, monitor_);
    if (sinks_.first) sinks_.first->lay(tubes, slab, state.time_origin);
}

/// The last layers of tubes that turned away in this chunk: each by itself, up to its cross-section.
void FrontSweep::packTurned(const Front& front, const Chunk& chunk, const State& state, Packed& packed) const {
    Front loose;
    loose.axis = front.axis, loose.sense = front.sense;
    std::vector<std::uint32_t> ray_of;
    std::vector<double> ends;
    for (const Turned& t : state.turned) {
        Front::Tube tube;
        tube.power = front.tubes[t.tube].power, tube.cell = front.tubes[t.tube].cell;
        for (int c = 0; c < 3; ++c) {
            tube.ray[c] = static_cast<std::uint32_t>(loose.rays.size());
            loose.rays.push_back(front.rays[front.tubes[t.tube].ray[c]]);
            ray_of.push_back(front.tubes[t.tube].ray[c]);
            ends.push_back(chunk.first + t.lane - 0.5 * front.sense);
        }
        loose.tubes.push_back(tube);
    }
    pack(loose, {}, packed);
    packed.bent.timed = state.packed.bent.timed;
    packed.set.slope_power = state.packed.set.slope_power, packed.set.slope_u_power = state.packed.set.slope_u_power,
    packed.set.slope_v_power = state.packed.set.slope_v_power;
    for (std::size_t c = 0; c < packed.set.corners.size(); ++c) packed.set.corners[c].w_end = ends[packed.bent.rays[c]];
    const std::size_t stride = packed.bent.rayStride();
    packed.bent.values.resize(ray_of.size() * stride);
    for (std::size_t r = 0; r < ray_of.size(); ++r)
        std::copy_n(&state.packed.bent.values[ray_of[r] * stride], stride, &packed.bent.values[r * stride]);
}

}  // namespace photic
