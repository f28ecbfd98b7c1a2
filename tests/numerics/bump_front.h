// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <optional>
#include <span>
#include <vector>

#include "bake/numerics/block_marching.h"
#include "bake/numerics/foot_point.h"
#include "bake/numerics/wavefront_curvature.h"

namespace photic::test {

inline constexpr double kBumpAmplitude = 0.02, kBumpRadius = 0.15, kBumpLevel = 0.9;
inline double bump(double x, double y) {
    return kBumpLevel + kBumpAmplitude * std::exp(-((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)) /
                                                  (2 * kBumpRadius * kBumpRadius));
}

inline double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// A front that leaves a Gaussian bump along its normals, on n^3 cells of the unit cube, and the truth of it.
struct BumpFront {
    explicit BumpFront(int cells)
        : n(cells), h(1.0 / cells), grid(BlockGrid::blocksFor(glm::ivec3(cells))), fixed(grid) {
        constexpr int samples = 400;
        const double spacing = 2.0 / samples;
        std::vector<double> heights;
        for (int j = 0; j <= samples; ++j)
            for (int i = 0; i <= samples; ++i) heights.push_back(bump(-0.5 + i * spacing, -0.5 + j * spacing));
        table.emplace(glm::dvec2(-0.5), spacing, samples + 1, samples + 1, heights);
        truth.assign(grid.cellCount(), kUnreached);
        curvature.assign(grid.cellCount(), 0);
        PointLayers points;
        points.origin = {h / 2, h / 2, 1 - h / 2}, points.step_x = points.step_y = h, points.step_z = {0, 0, -h};
        points.count_x = points.count_y = points.count_z = n;
        const double start = processorSeconds();
        double copying = 0;
        sweepFootPoints({&*table, glm::dvec3(0), 1}, points, [&](int k, const FootPointLayer& layer) {
            const double from = processorSeconds();
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    const std::size_t at = layer.at(std::size_t(i), std::size_t(j));
                    const auto cell = grid.cellIndex({i, j, n - 1 - k});
                    truth[std::size_t(cell)] = layer.arrival[at] < 1e59 ? layer.arrival[at] : kUnreached;
                    curvature[std::size_t(cell)] = layer.curvature[at];
                    // Seeds: three cells deep below the surface, and ghosts two deep at the sides.
                    const bool side = std::min(i, j) < 2 || std::max(i, j) >= n - 2;
                    if (layer.arrival[at] > 1e59 || layer.distance[at] <= 3 * h || side) fixed.set(cell);
                }
            copying += processorSeconds() - from;
            return true;
        });
        foot_seconds = processorSeconds() - start - copying;
    }

    /// Cells that no peer lacks the inflow of, below the seeds.
    bool counts(const glm::ivec3& c) const {
        const double x = (c.x + 0.5) * h, y = (c.y + 0.5) * h, z = (c.z + 0.5) * h;
        return std::fabs(x - 0.5) < 0.38 && std::fabs(y - 0.5) < 0.38 && z < kBumpLevel - 6.0 / 64 && z > 3.0 / 64;
    }

    int n;
    double h;
    BlockGrid grid;
    CellMask fixed;
    std::optional<HeightTable> table;
    std::vector<double> truth, curvature;
    double foot_seconds = 0;
};

struct BumpErrors {
    double arrival = 0, curvature = 0;
};
inline BumpErrors errorsOf(const BumpFront& f, std::span<const double> arrival) {
    EikonalProblem problem;
    problem.grid = &f.grid, problem.spacing = f.h, problem.fixed = &f.fixed;
    std::vector<std::array<double, 4>> sums(std::size_t(f.grid.blockCount()));
    wavefrontCurvature(problem, arrival, [&](int slot, const FrontBlock& block) {
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const std::size_t at = std::size_t(slot) * BlockGrid::kCells + std::size_t(c);
            if (!f.counts(f.grid.cellAt(std::int64_t(at)))) continue;
            auto& s = sums[std::size_t(slot)];
            s[0] += std::fabs(arrival[at] - f.truth[at]) / f.h, s[1] += 1;
            s[2] += std::fabs(block.curvature[c] - f.curvature[at]), s[3] += std::fabs(f.curvature[at]);
        }
    });
    std::array<double, 4> all{};
    for (const auto& s : sums)
        for (std::size_t i = 0; i < 4; ++i) all[i] += s[i];
    return {all[0] / all[1], all[2] / all[3]};
}

}  // namespace photic::test
