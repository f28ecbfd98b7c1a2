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
#include "tests/numerics/bump_front.h"

namespace photic::benchmark {

namespace {

using test::bump;
using test::BumpErrors;
using test::BumpFront;
using test::errorsOf;
using test::processorSeconds;

const char* const kBumpInPython = "0.9 + 0.02 * np.exp(-((x - 0.5)**2 + (y - 0.5)**2) / (2 * 0.15**2))";

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

namespace {

void frontTable(const std::vector<int>& sizes, bool with_peers, Findings& findings) {
    setThreadCount(1);
    Table table{"Fronts below a Gaussian bump, one core",
                "A front leaves z = 0.9 + 0.02 exp(-r^2 / 0.045) along its normals through n^3 cells of the unit cube. "
                "Seconds of "
                "processor time of the solver alone; errors against the foot points in closed form, where all have "
                "their inflow; mean |T| in "
                "cells, relative L1 of the curvature by the same differences.",
                {"solver", "n", "[s]", "million cells/s", "T [h]", "curvature", "bytes a cell"},
                {}};
    const auto row = [&](const std::string& name, int n, double seconds, double cells, const BumpErrors& e,
                         const std::string& bytes) {
        table.add({name, std::to_string(n), fmt::format("{:.3f}", seconds),
                   fmt::format("{:.2f}", cells / seconds * 1e-6), fmt::format("{:.1e}", e.arrival),
                   fmt::format("{:.1e}", e.curvature), bytes});
    };
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
        if (!with_peers) continue;
        for (const int order : {1, 2})
            if (const auto peer = scikitFmm(n, order, kBumpInPython))
                row(fmt::format("scikit-fmm, order {}", order), n, peer->seconds, all,
                    errorsOf(front, inBlocks(front, peer->arrival)), "");
        std::vector<double> known;
        for (int z = 0; z < n; ++z)
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x) {
                    const std::int64_t at = front.grid.cellIndex({x, y, z});
                    const double arrival = front.truth[std::size_t(at)];
                    // Above the surface nothing arrives: far enough for nothing to go on from there.
                    known.push_back(!front.fixed.get(at) ? 1e60 : arrival == kUnreached ? 1e6 : arrival / front.h);
                }
        if (auto peer = itkMarching(n, known)) {
            for (double& arrival : peer->arrival) arrival = arrival > 1e5 ? kUnreached : arrival * front.h;
            row("ITK fast marching, order 1", n, peer->seconds, all, errorsOf(front, inBlocks(front, peer->arrival)),
                "");
        }
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

}  // namespace

void eikonal(const Effort& effort, Findings& findings) {
    frontTable(effort.quick ? std::vector<int>{32} : std::vector<int>{64, 128, 256}, true, findings);
}

void eikonalLarge(const Effort& effort, Findings& findings) { frontTable({effort.quick ? 32 : 512}, false, findings); }

}  // namespace photic::benchmark
