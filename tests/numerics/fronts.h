// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "bake/numerics/block_marching.h"
#include "bake/numerics/wavefront_curvature.h"

namespace photic::test {

using Field = std::function<double(const glm::dvec3&)>;
using Predicate = std::function<bool(const glm::dvec3&)>;

/// A cube of n^3 cells [0, 1]^3 with seeds taken from a closed form.
struct Marched {
    int n;
    BlockGrid grid;
    CellMask fixed;
    std::vector<double> arrival;
    std::vector<float> slowness;
    EikonalProblem problem;
    BlockMarchingReport report;

    glm::dvec3 place(std::int64_t cell) const { return (glm::dvec3(grid.cellAt(cell)) + 0.5) / double(n); }
    bool isSeed(std::int64_t cell) const { return fixed.get(cell); }
};

/// Marches from the cells where `seed` says so. @param slow  n(x); empty: 1
inline Marched march(int n, const Field& truth, const Predicate& seed, MarchingOrder order = MarchingOrder::Second,
                     const Field& slow = {}, const BlockMarchingOptions& options = {}) {
    BlockGrid grid(glm::ivec3(n / BlockGrid::kSide));
    Marched m{n, grid, CellMask(grid), std::vector<double>(grid.cellCount(), kUnreached), {}, {}, {}};
    for (std::int64_t c = 0; c < std::int64_t(m.arrival.size()); ++c) {
        const glm::dvec3 p = m.place(c);
        if (slow) m.slowness.push_back(static_cast<float>(slow(p)));
        if (!seed(p)) continue;
        m.fixed.set(c);
        m.arrival[std::size_t(c)] = truth(p);
    }
    m.problem.grid = &m.grid, m.problem.spacing = 1.0 / n, m.problem.fixed = &m.fixed;
    m.problem.order = order, m.problem.slownesses = m.slowness;
    m.report = marchBlocks(m.problem, options, m.arrival);
    return m;
}

/// Within `cells` of a side of the cube.
inline Predicate nearSides(int n, int cells) {
    return [n, cells](const glm::dvec3& p) {
        const double edge = double(cells) / n;
        for (int a = 0; a < 3; ++a)
            if (p[a] < edge || p[a] > 1 - edge) return true;
        return false;
    };
}

/// Relative L1 error of the curvature over the cells where `counts` says so.
inline double curvatureError(const Marched& m, const Field& truth, const Predicate& counts) {
    std::vector<double> errors(std::size_t(m.grid.blockCount())), sums(errors.size());
    wavefrontCurvature(m.problem, m.arrival, [&](int slot, const FrontBlock& block) {
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const glm::dvec3 p = m.place(std::int64_t(slot) * BlockGrid::kCells + c);
            if (!counts(p)) continue;
            errors[std::size_t(slot)] += std::fabs(block.curvature[c] - truth(p));
            sums[std::size_t(slot)] += std::fabs(truth(p));
        }
    });
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) error += errors[i], sum += sums[i];
    return error / sum;
}

/// Mean |T - truth| over the cells that were marched, in cells.
inline double arrivalError(const Marched& m, const Field& truth, const Predicate& counts) {
    double error = 0;
    std::int64_t cells = 0;
    for (std::int64_t c = 0; c < std::int64_t(m.arrival.size()); ++c) {
        if (m.isSeed(c) || !counts(m.place(c))) continue;
        error += std::fabs(m.arrival[std::size_t(c)] - truth(m.place(c)));
        ++cells;
    }
    return error / double(cells) * m.n;
}

}  // namespace photic::test
