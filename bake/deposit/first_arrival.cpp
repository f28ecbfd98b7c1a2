// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/first_arrival.h"

#include <algorithm>
#include <cmath>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr float kNever = 3e38f;

/// Optical path at a corner of a tube, and its slopes.
struct CornerTime {
    double time, u, v;  // [m], [m/voxel]
};

/// Keeps the least time of a voxel that is needed.
void note(LightField& field, const glm::ivec3& voxel, double time) {
    const NeededVoxels& needed = field.needed();
    const int slot = needed.slotOf(voxel), offset = NeededVoxels::offsetInLeaf(voxel);
    if (slot < 0 || !NeededVoxels::maskBit(needed.mask(slot), offset)) return;
    float* values = field.dense(slot);
    if (field.state(slot) != LeafState::Dense) {
        bool was_empty = false;
        values = field.makeDenseUninitialised(slot, was_empty);
        std::fill_n(values, LightField::kLeafVoxels, kNever);
    }
    values[offset] = std::min(values[offset], static_cast<float>(time));
}

}  // namespace

FirstArrival::FirstArrival(std::shared_ptr<const NeededVoxels> needed)
    : across_(needed, {1, false}), beside_(needed, {1, false}) {}

void FirstArrival::layLane(const BentTubes& tubes, const Slab& slab, int lane, double origin) {
    const TubeSet& set = tubes.set;
    const BentRows& bent = tubes.bent;
    const GridFrame& frame = across_.frame();
    const auto axes = axesFor(set.axis);
    const auto voxelAt = [&](int u, int v) {
        glm::ivec3 voxel;
        voxel[axes[0]] = u + bent.first_column[0], voxel[axes[1]] = v + bent.first_column[1],
        voxel[axes[2]] = slab.first + lane;
        return voxel;
    };
    const int low_u = frame.min[axes[0]] - bent.first_column[0], high_u = frame.max[axes[0]] - bent.first_column[0],
              low_v = frame.min[axes[1]] - bent.first_column[1], high_v = frame.max[axes[1]] - bent.first_column[1];
    forEachTube(set, [&](const BentTube& tube) {
        TubeOnLayer at;
        if (!crossLayer(tubes, tube, slab.first, lane, {0.5, 1}, {1, false}, at) || at.lit < 0.5) return;
        CornerTime corners[3];
        for (int i = 0; i < 3; ++i) {
            const float* rows = bent.of(tube.corner[i]) + lane;
            const auto row = [&](int which) { return static_cast<double>(rows[which * BentRows::kLanes]); };
            const double du = double(bent.voxel[0]) * row(BentRows::kSlopeU),
                         dv = double(bent.voxel[1]) * row(BentRows::kSlopeV), dw = double(bent.voxel[2]);
            const double per_length = set.sense * row(BentRows::kMomentum) / std::sqrt(du * du + dv * dv + dw * dw);
            corners[i] = {origin + row(bent.timeRow()), per_length * du * double(bent.voxel[0]),
                          per_length * dv * double(bent.voxel[1])};
            // Places on a layer in which the tube begins or ends are not those of the rows.
            at.u[i] = row(BentRows::kU), at.v[i] = row(BentRows::kV);
        }
        const double area2 = (at.u[1] - at.u[0]) * (at.v[2] - at.v[0]) - (at.u[2] - at.u[0]) * (at.v[1] - at.v[0]);
        const auto timeAt = [&](int i, double u, double v, double share) {
            return corners[i].time + share * (corners[i].u * (u - at.u[i]) + corners[i].v * (v - at.v[i]));
        };
        // What passes a centre by: the voxel that holds the tube's middle.
        const double mean_u = (at.u[0] + at.u[1] + at.u[2]) / 3, mean_v = (at.v[0] + at.v[1] + at.v[2]) / 3;
        const int near_u = static_cast<int>(std::lround(mean_u)), near_v = static_cast<int>(std::lround(mean_v));
        if (near_u >= low_u && near_u <= high_u && near_v >= low_v && near_v <= high_v) {
            double time = 0;
            for (int i = 0; i < 3; ++i) time += timeAt(i, near_u, near_v, 1) / 3;
            note(beside_, voxelAt(near_u, near_v), time);
        }
        constexpr double kLeastArea = 1e-9, kTouches = 1e-9;
        if (!(std::fabs(area2) > kLeastArea)) return;
        const auto [least_u, most_u] = std::minmax({at.u[0], at.u[1], at.u[2]});
        const auto [least_v, most_v] = std::minmax({at.v[0], at.v[1], at.v[2]});
        if (!(most_u >= low_u && least_u <= high_u && most_v >= low_v && least_v <= high_v)) return;
        const int from_u = std::max(low_u, static_cast<int>(std::ceil(least_u))),
                  to_u = std::min(high_u, static_cast<int>(std::floor(most_u))),
                  from_v = std::max(low_v, static_cast<int>(std::ceil(least_v))),
                  to_v = std::min(high_v, static_cast<int>(std::floor(most_v)));
        for (int v = from_v; v <= to_v; ++v)
            for (int u = from_u; u <= to_u; ++u) {
                double b[3];
                b[1] = ((u - at.u[0]) * (at.v[2] - at.v[0]) - (at.u[2] - at.u[0]) * (v - at.v[0])) / area2;
                b[2] = ((at.u[1] - at.u[0]) * (v - at.v[0]) - (u - at.u[0]) * (at.v[1] - at.v[0])) / area2;
                b[0] = 1 - b[1] - b[2];
                if (b[0] < -kTouches || b[1] < -kTouches || b[2] < -kTouches) continue;
                double time = 0;
                for (int i = 0; i < 3; ++i) time += b[i] * timeAt(i, u, v, 0.5);
                note(across_, voxelAt(u, v), time);
            }
    });
}

void FirstArrival::lay(std::span<const BentTubes> tubes, const Slab& slab, double origin) {
    const auto groups = lanesByLeaf(slab);
    parallelFor(static_cast<std::int64_t>(groups.size()), [&](std::int64_t g) {
        const auto& [from, to] = groups[static_cast<std::size_t>(g)];
        for (int lane = from; lane < to; ++lane)
            for (const BentTubes& of : tubes) layLane(of, slab, lane, origin);
    });
}

LightField FirstArrival::take() {
    parallelFor(across_.leafCount(), [&](std::int64_t i) {
        const int slot = static_cast<int>(i);
        const float* beside = beside_.state(slot) == LeafState::Dense ? beside_.dense(slot) : nullptr;
        if (across_.state(slot) == LeafState::Empty && !beside) return;
        if (across_.state(slot) == LeafState::Empty) {
            bool was_empty = false;
            std::fill_n(across_.makeDenseUninitialised(slot, was_empty), LightField::kLeafVoxels, kNever);
        }
        float* values = across_.dense(slot);
        for (int v = 0; v < LightField::kLeafVoxels; ++v) {
            if (values[v] == kNever && beside) values[v] = beside[v];
            if (values[v] == kNever) values[v] = 0;
        }
    });
    return std::move(across_);
}

}  // namespace photic
