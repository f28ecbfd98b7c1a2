// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/block_marching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>

#include "bake/threads/parallel_for.h"
#include "tests/numerics/fronts.h"

namespace photic {
namespace {

using test::arrivalError;
using test::curvatureError;
using test::march;
using test::Marched;
using test::nearSides;

const glm::dvec3 kCentre(0.5);
double toCentre(const glm::dvec3& p) { return 1 - glm::length(p - kCentre); }

/// A sphere that converges on a point three quarters of a side below the cube, seeds on all sides but the lowest. The
/// error grows as (h / distance to the focus)^2, so the figures belong to this setting.
TEST(BlockMarching, ConvergingSphereHasSecondOrderCurvature) {
    const glm::dvec3 focus(0.5, 0.5, -0.75);
    const auto arrival = [&](const glm::dvec3& p) { return 3 - glm::length(p - focus); };
    const auto curvature = [&](const glm::dvec3& p) { return -2 / glm::length(p - focus); };
    const double limit[] = {4.3e-4, 1.1e-4};  // 256: the benchmark
    double last = 0;
    for (int i = 0; i < 2; ++i) {
        const int n = 64 << i;
        const auto seed = [&](const glm::dvec3& p) { return nearSides(n, 2)(p) && p.z > 2.0 / n; };
        const Marched m = march(n, arrival, seed);
        const double error = curvatureError(m, curvature, [&](const glm::dvec3& p) { return !nearSides(n, 3)(p); });
        EXPECT_LT(error, limit[i]) << n;
        if (i > 0) {
            EXPECT_GT(std::log2(last / error), 1.8);
        }
        last = error;
        EXPECT_TRUE(m.report.converged);
    }
}

/// A sphere that spreads from a point above the cube: beside the planes through it the front turns over along an axis.
/// In the cells there a difference must not fall back to first order, or a cross of wrong curvature is left behind
/// (10 % in the mean, at every resolution).
TEST(BlockMarching, ASphereFromAPointLeavesNoCross) {
    const glm::dvec3 point(0.437, 0.36, 1.5);
    const auto arrival = [&](const glm::dvec3& p) { return glm::length(p - point); };
    const auto curvature = [&](const glm::dvec3& p) { return 2 / glm::length(p - point); };
    double last = 0;
    for (const int n : {32, 64}) {
        const auto seed = [&](const glm::dvec3& p) { return nearSides(n, 2)(p) && p.z > 2.0 / n; };
        const Marched m = march(n, arrival, seed);
        const auto within = [&](const glm::dvec3& p) { return !nearSides(n, 4)(p); };
        const auto cross = [&](const glm::dvec3& p) {
            return within(p) && std::min(std::fabs(p.x - point.x), std::fabs(p.y - point.y)) < 2.0 / n;
        };
        const double error = curvatureError(m, curvature, cross), everywhere = curvatureError(m, curvature, within);
        EXPECT_LT(error, n == 32 ? 3e-3 : 8e-4) << n;
        EXPECT_LT(error, 2 * everywhere);
        if (last > 0) {
            EXPECT_GT(std::log2(last / error), 1.7);
        }
        last = error;
        EXPECT_TRUE(m.report.converged);
    }
}

TEST(BlockMarching, FirstOrderIsFirstOrder) {
    double last = 0;
    for (const int n : {32, 64, 128}) {
        const Marched m = march(n, toCentre, nearSides(n, 2), MarchingOrder::First);
        const double error =
            arrivalError(m, toCentre, [](const glm::dvec3& p) { return glm::length(p - kCentre) > 0.125; }) / n;
        if (last > 0) {
            EXPECT_NEAR(std::log2(last / error), 1.0, 0.25) << n;
        }
        last = error;
    }
}

/// Second differences of a plane's arrivals, sides included: nothing but rounding and the tolerance.
TEST(BlockMarching, PlaneHasNoCurvature) {
    const glm::dvec3 w = glm::normalize(glm::dvec3(0.3, 0.2, -0.933));
    const auto plane = [&](const glm::dvec3& p) { return glm::dot(w, p); };
    const Marched m = march(64, plane, nearSides(64, 2));
    double worst = 0;
    std::vector<double> worsts(std::size_t(m.grid.blockCount()));
    wavefrontCurvature(m.problem, m.arrival, [&](int slot, const FrontBlock& block) {
        for (const double k : block.curvature)
            worsts[std::size_t(slot)] = std::max(worsts[std::size_t(slot)], std::fabs(k));
    });
    for (const double k : worsts) worst = std::max(worst, k);
    EXPECT_LE(worst / 64, 1e-9);
}

/// n^2 = 1 + g z from a plane wave: rays are straight along z, T' = n.
TEST(BlockMarching, SlownessMayVary) {
    const auto slow = [](const glm::dvec3& p) { return std::sqrt(1 + 2 * p.z); };
    const auto arrival = [](const glm::dvec3& p) { return std::pow(1 + 2 * p.z, 1.5) / 3; };
    double last = 0;
    for (const int n : {32, 64, 128}) {
        const Marched m = march(
            n, arrival, [n](const glm::dvec3& p) { return p.z < 2.0 / n; }, MarchingOrder::Second, slow);
        const double error = arrivalError(m, arrival, [](const glm::dvec3&) { return true; }) / n;
        if (last > 0) {
            EXPECT_GT(std::log2(last / error), 1.8) << n;
        }
        last = error;
    }
}

TEST(BlockMarching, ThreadsAndInstructionSetsChangeNothing) {
    const auto seed = [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(0.31, 0.42, 0.13)) < 0.07; };
    const auto truth = [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(0.31, 0.42, 0.13)); };
    setThreadCount(1);
    const Marched one = march(48, truth, seed);
    setThreadCount(3);
    const Marched three = march(48, truth, seed);
    EXPECT_EQ(one.arrival, three.arrival);
    EXPECT_EQ(one.report.row_updates, three.report.row_updates);
    setenv("PHOTIC_INSTRUCTION_SET", "portable", 1);
    const Marched portable = march(48, truth, seed);
    unsetenv("PHOTIC_INSTRUCTION_SET");
    setThreadCount(0);
    for (std::size_t c = 0; c < one.arrival.size(); ++c) ASSERT_NEAR(one.arrival[c], portable.arrival[c], 1e-6 / 48);
}

/// Slowness over six decades at random: no NaN, everything is reached, and |grad T| = n holds in the discrete sense: no
/// cell can be improved (a negative discriminant falls back on fewer axes).
TEST(BlockMarching, RandomSlownessGivesAFixedPoint) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> power(-3, 3);
    const auto slow = [&](const glm::dvec3&) { return std::pow(10.0, power(random)); };
    for (const MarchingOrder order : {MarchingOrder::First, MarchingOrder::Second}) {
        const Marched m = march(
            32, [](const glm::dvec3&) { return 0.0; }, [](const glm::dvec3& p) { return p.z < 2.0 / 32; }, order, slow);
        EXPECT_TRUE(m.report.converged);
        for (const double t : m.arrival) ASSERT_TRUE(t >= 0 && t < 1e4) << t;
    }
}

/// Scale is nothing: spacing 1e-9 or 1e9.
TEST(BlockMarching, ScaleIsNothing) {
    BlockGrid grid(glm::ivec3(4));
    CellMask fixed(grid);
    std::vector<double> reference;
    for (const double h : {1.0, 1e-9, 1e9}) {
        std::vector<double> t(grid.cellCount(), kUnreached);
        for (std::int64_t c = 0; c < std::int64_t(t.size()); ++c)
            if (grid.cellAt(c).z < 2) fixed.set(c), t[std::size_t(c)] = h * grid.cellAt(c).x * 0.3;
        EikonalProblem problem;
        problem.grid = &grid, problem.spacing = h, problem.fixed = &fixed;
        marchBlocks(problem, {}, t);
        if (reference.empty()) reference = t;
        for (std::size_t c = 0; c < t.size(); ++c) ASSERT_NEAR(t[c] / h, reference[c], 1e-9);
    }
}

TEST(BlockMarching, StopsWhenTheNeededBlocksAreFinal) {
    const auto truth = [](const glm::dvec3& p) { return p.z; };
    const auto seed = [](const glm::dvec3& p) { return p.z < 2.0 / 128; };
    const Marched all = march(128, truth, seed);
    std::vector<std::uint8_t> needed(std::size_t(all.grid.blockCount()));
    for (int s = 0; s < all.grid.blockCount(); ++s) needed[std::size_t(s)] = all.grid.origin(s).z < 24;
    BlockMarchingOptions options;
    options.needed_blocks = needed;
    const Marched some = march(128, truth, seed, MarchingOrder::Second, {}, options);
    EXPECT_TRUE(some.report.stopped_early);
    EXPECT_LT(some.report.row_updates, all.report.row_updates * 2 / 3);
    for (std::int64_t c = 0; c < std::int64_t(all.arrival.size()); ++c)
        if (all.grid.cellAt(c).z < 24) {
            ASSERT_EQ(some.arrival[std::size_t(c)], all.arrival[std::size_t(c)]);
        }
}

/// A wall with a hole: what lies behind is reached around its rim, and blocks that don't exist are not marched through.
TEST(BlockMarching, GoesAroundWhatIsMissing) {
    std::vector<std::uint8_t> exists(4 * 4 * 4, 1);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 3; ++x) exists[std::size_t((1 * 4 + y) * 4 + x)] = 0;  // z blocks 1, but for x block 3
    BlockGrid grid(glm::ivec3(4), exists);
    EXPECT_EQ(grid.cellIndex({0, 0, 9}), -1);
    CellMask fixed(grid);
    std::vector<double> t(grid.cellCount());
    for (int x = 0; x < 32; ++x)
        for (int y = 0; y < 32; ++y) {
            const std::int64_t c = grid.cellIndex({x, y, 0});
            fixed.set(c), t[std::size_t(c)] = 0;
        }
    EikonalProblem problem;
    problem.grid = &grid, problem.fixed = &fixed;
    marchBlocks(problem, {}, t);
    const double behind = t[std::size_t(grid.cellIndex({0, 16, 16}))];
    EXPECT_GT(behind, 15 + std::hypot(24, 1) - 1.5);
    EXPECT_LT(behind, 15 + std::hypot(24, 1) + 1.5);
}

}  // namespace
}  // namespace photic
