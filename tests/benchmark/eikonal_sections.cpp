// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <optional>
#include <span>

#include "bake/numerics/block_marching.h"
#include "bake/numerics/foot_point.h"
#include "bake/numerics/wavefront_curvature.h"
#include "bake/threads/parallel_for.h"
#include "tests/benchmark/eikonal_peers.h"
#include "tests/benchmark/sections.h"

namespace photic::benchmark {

namespace {

constexpr double kAmplitude = 0.02, kRadius = 0.15, kLevel = 0.9;
double bump(double x, double y) {
    return kLevel + kAmplitude * std::exp(-((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)) / (2 * kRadius * kRadius));
}
const char* const kBumpInPython = "0.9 + 0.02 * np.exp(-((x - 0.5)**2 + (y - 0.5)**2) / (2 * 0.15**2))";

double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

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
        return std::fabs(x - 0.5) < 0.38 && std::fabs(y - 0.5) < 0.38 && z < kLevel - 6.0 / 64 && z > 3.0 / 64;
    }

    int n;
    double h;
    BlockGrid grid;
    CellMask fixed;
    std::optional<HeightTable> table;
    std::vector<double> truth, curvature;
    double foot_seconds = 0;
};

struct Errors {
    double arrival = 0, curvature = 0;
};
Errors errorsOf(const BumpFront& f, std::span<const double> arrival) {
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

/// From rows x fastest to the grid's blocks.
std::vector<double> inBlocks(const BumpFront& f, const std::vector<double>& rows) {
    std::vector<double> out(f.grid.cellCount(), kUnreached);
    std::size_t at = 0;
    for (int z = 0; z < f.n; ++z)
        for (int y = 0; y < f.n; ++y)
            for (int x = 0; x < f.n; ++x) out[std::size_t(f.grid.cellIndex({x, y, z}))] = rows[at++];
    return out;
}

}  // namespace

void eikonal(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    Table table{"Fronts below a Gaussian bump, one core",
                "A front leaves z = 0.9 + 0.02 exp(-r^2 / 0.045) along its normals through n^3 cells of the unit cube. "
                "Seconds of "
                "processor time of the solver alone; errors against the foot points in closed form, where all have "
                "their inflow; mean |T| in "
                "cells, relative L1 of the curvature by the same differences.",
                {"solver", "n", "[s]", "million cells/s", "T [h]", "curvature", "bytes a cell"},
                {}};
    const auto row = [&](const std::string& name, int n, double seconds, double cells, const Errors& e,
                         const std::string& bytes) {
        table.add({name, std::to_string(n), fmt::format("{:.3f}", seconds),
                   fmt::format("{:.2f}", cells / seconds * 1e-6), fmt::format("{:.1e}", e.arrival),
                   fmt::format("{:.1e}", e.curvature), bytes});
    };
    const std::vector<int> sizes = effort.quick ? std::vector<int>{32} : std::vector<int>{64, 128, 256};
    for (const int n : sizes) {
        const BumpFront front(n);
        const double all = double(n) * n * n;
        row("foot points", n, front.foot_seconds, all, errorsOf(front, front.truth),
            fmt::format("{:.1f}", 24.0 * 8 / n));
        for (const auto& [name, order] : {std::pair{"block marching, order 2", MarchingOrder::Second},
                                          {"block marching, order 1", MarchingOrder::First}}) {
            std::vector<double> t(front.truth);
            EikonalProblem problem;
            problem.grid = &front.grid, problem.spacing = front.h, problem.fixed = &front.fixed, problem.order = order;
            const double start = processorSeconds();
            const BlockMarchingReport report = marchBlocks(problem, {}, t);
            const double seconds = processorSeconds() - start;
            double marched = 0;
            for (std::int64_t c = 0; c < std::int64_t(t.size()); ++c) marched += !front.fixed.get(c);
            row(fmt::format("{}, {:.1f} updates a row", name, double(report.row_updates) / (all / 8)), n, seconds,
                marched, errorsOf(front, t), fmt::format("{:.1f}", 8 + 1.0 / 8 + 4.0 / 8 + 40.0 / 512));
        }
        for (const int order : {1, 2})
            if (const auto peer = scikitFmm(n, order, kBumpInPython))
                row(fmt::format("scikit-fmm, order {}", order), n, peer->seconds, all,
                    errorsOf(front, inBlocks(front, peer->arrival)), "");
        std::vector<double> level;
        for (int z = 0; z < n; ++z)
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    level.push_back((z + 0.5) * front.h - bump((x + 0.5) * front.h, (y + 0.5) * front.h));
        const PeerRun swept = openvdbSweeping(n, level);
        row("OpenVDB fast sweeping, float", n, swept.seconds, all, errorsOf(front, inBlocks(front, swept.arrival)), "");
    }
    findings.tables.push_back(table);
    setThreadCount(0);
}

}  // namespace photic::benchmark
