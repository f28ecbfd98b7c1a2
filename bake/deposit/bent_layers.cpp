// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/bent_layers.h"

#include <algorithm>
#include <cmath>

#include "bake/deposit/edge_kernel.h"

namespace photic {

bool crossLayer(const BentTubes& tubes, const BentTube& tube, int first_w, int lane, const LayerPoint& point,
                FieldChannels channels, TubeOnLayer& out) {
    const TubeSet& set = tubes.set;
    const BentRows& bent = tubes.bent;
    double opened[3], closed[3];
    for (int i = 0; i < 3; ++i) {
        const CornerRay& c = set.corners[tube.corner[i]];
        opened[i] = set.sense * (first_w + lane - c.w) + 0.5;
        closed[i] = set.sense * (first_w + lane - c.w_end) + 0.5;
    }
    out.open = meanClamped(opened[0], opened[1], opened[2]) - meanClamped(closed[0], closed[1], closed[2]);
    if (!(out.open > 0)) return false;
    double slope_u = 0, slope_v = 0, path = 0, left[3] = {0, 0, 0};
    out.lit = 0;
    for (int i = 0; i < 3; ++i) {
        const float* rows = bent.of(tube.corner[i]) + lane;
        const auto row = [&](int which) { return static_cast<double>(rows[which * BentRows::kLanes]); };
        const double from = 1 - std::clamp(opened[i], 0.0, 1.0), to = 1 - std::clamp(closed[i], 0.0, 1.0);
        const double beyond = set.sense * (from + point.offset * (to - from) - 0.5);
        out.u[i] = row(BentRows::kU) + row(BentRows::kSlopeU) * beyond;
        out.v[i] = row(BentRows::kV) + row(BentRows::kSlopeV) * beyond;
        const double du = double(bent.voxel[0]) * row(BentRows::kSlopeU),
                     dv = double(bent.voxel[1]) * row(BentRows::kSlopeV);
        slope_u += du / 3, slope_v += dv / 3,
            path += std::sqrt(du * du + dv * dv + double(bent.voxel[2]) * double(bent.voxel[2])) / 3;
        out.lit += row(BentRows::kLit) / 3;
        for (int k = 0; k < channels.irradiance; ++k) left[k] += row(BentRows::kLeft + k) / 3;
    }
    const TubeConstants& constants = set.tubes[tube.number];
    const double share = out.lit * out.open * point.weight;
    double power = 0;
    for (int k = 0; k < channels.irradiance; ++k) {
        const double of_channel = double(constants.power[k]) * left[k] * share;
        power += of_channel / channels.irradiance;
        out.amounts[k] = static_cast<float>(of_channel * path);
    }
    out.mean = power * path;
    if (channels.flux) {
        const auto axes = axesFor(set.axis);
        const double along[3] = {slope_u, slope_v, double(bent.voxel[2])};
        for (std::size_t a = 0; a < 3; ++a)
            out.amounts[channels.irradiance + axes[a]] = static_cast<float>(set.sense * power * along[a]);
    }
    out.area2 = (out.u[1] - out.u[0]) * (out.v[2] - out.v[0]) - (out.u[2] - out.u[0]) * (out.v[1] - out.v[0]);
    return true;
}

std::vector<std::pair<int, int>> lanesByLeaf(const Slab& slab) {
    std::vector<std::pair<int, int>> groups;
    for (int lane = 0; lane < slab.active; ++lane) {
        if (lane == 0 || (slab.first + lane) >> 3 != (slab.first + lane - 1) >> 3) groups.emplace_back(lane, lane);
        groups.back().second = lane + 1;
    }
    return groups;
}

}  // namespace photic
