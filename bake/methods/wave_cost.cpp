// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_cost.h"

#include <fmt/format.h>

#include <cmath>

namespace photic {

MethodCost waveCost(const CostQuestion& question, const WaveOptions& options) {
    const Scene& scene = question.scene;
    const double runs = static_cast<double>(scene.lights.size()) * (scene.medium.coloured() ? 3 : 1);
    const double cells = question.needed_voxels * std::pow(options.cells, 3);
    // Seconds of one thread of a 2.6 GHz server core. The band is some 20 cells thick, and a step half a cell: each
    // cell is stepped some forty times, whatever the size of the grid.
    constexpr double kSecondsACell = 1.5e-6, kSecondsAReleasedColumn = 1.2e-5, kIndexVaries = 1.8;
    const double columns = double(question.frame.size().x) * question.frame.size().y * options.cells * options.cells;
    MethodCost cost;
    cost.stages = {{"release", runs * columns * kSecondsAReleasedColumn},
                   {"waves", runs * cells * kSecondsACell * (scene.index ? kIndexVaries : 1)}};
    if (options.cells > 1)
        cost.dearest = fmt::format("most of the time goes into {0} cells a voxel's side: half as many take an eighth",
                                   options.cells);
    return cost;
}

}  // namespace photic
