// SPDX-License-Identifier: Apache-2.0
// What is known to go wrong with marched fronts, each as a test.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/numerics/bump_front.h"
#include "tests/numerics/fronts.h"

namespace photic {
namespace {

/// Seeds that are off by a hundredth of a cell, as vertices splatted into cells are and more, ruin the curvature:
/// errors are divided by h^2.
TEST(FrontHazards, SeedErrorsShowInTheCurvature) {
    const test::BumpFront front(64);
    const auto curvatureWith = [&](double off) {
        std::mt19937 random(3);
        std::normal_distribution<double> noise(0, off * front.h);
        std::vector<double> t(front.truth);
        for (std::size_t c = 0; c < t.size(); ++c)
            if (front.fixed.get(std::int64_t(c)) && t[c] < kUnreached) t[c] += noise(random);
        EikonalProblem problem;
        problem.grid = &front.grid, problem.spacing = front.h, problem.fixed = &front.fixed;
        marchBlocks(problem, {}, t);
        return errorsOf(front, t).curvature;
    };
    const double exact = curvatureWith(0), fine = curvatureWith(1e-5), coarse = curvatureWith(1e-2);
    EXPECT_LT(exact, 9e-3);
    EXPECT_LT(fine, 2 * exact);
    EXPECT_GT(coarse, 20 * exact);
}

/// Without the ghost columns a slanting front lacks what comes in from the side: cells of error, which only they take
/// away.
TEST(FrontHazards, MissingInflowFromTheSidesCostsMoreThanACell) {
    const glm::dvec3 w = glm::normalize(glm::dvec3(0.35, 0.2, -0.915));
    const auto plane = [&](const glm::dvec3& p) { return glm::dot(w, p); };
    const auto worst = [&](const test::Predicate& seed) {
        const test::Marched m = test::march(64, plane, seed);
        double most = 0;
        for (std::int64_t c = 0; c < std::int64_t(m.arrival.size()); ++c)
            most = std::max(most, std::fabs(m.arrival[std::size_t(c)] - plane(m.place(c))) * 64);
        return most;
    };
    const auto top = [](const glm::dvec3& p) { return p.z > 1 - 2.0 / 64; };
    EXPECT_GT(worst(top), 0.5);
    EXPECT_LT(worst([&](const glm::dvec3& p) { return top(p) || test::nearSides(64, 2)(p); }), 1e-6);
}

/// Slabs of 0.3 to 3 cells of glass, their index averaged over cells: the front behind them is late by what Snell's law
/// says, to a part of a cell's own delay.
TEST(FrontHazards, ThinSlabsDelayTheFrontAsSnellsLawSays) {
    constexpr int n = 64;
    constexpr double glass = 1.5, top = 0.61;
    const double across = std::sin(0.4);
    const auto seed = [](const glm::dvec3& p) { return p.z > 1 - 2.0 / n || test::nearSides(n, 2)(p); };
    for (const double cells : {0.3, 1.0, 3.0}) {
        const double low = top - cells / n;
        const auto inside = [&](double from, double to) {
            return std::max(0.0, std::min(to, top) - std::max(from, low));
        };
        const auto slow = [&](const glm::dvec3& p) {
            return 1 + (glass - 1) * n * inside(p.z - 0.5 / n, p.z + 0.5 / n);
        };
        const auto truth = [&](const glm::dvec3& p) {
            const double in_glass = inside(p.z, 2), in_air = 1 - p.z - in_glass;
            return across * p.x + std::sqrt(1 - across * across) * in_air +
                   std::sqrt(glass * glass - across * across) * in_glass;
        };
        const test::Marched m = test::march(n, truth, seed, MarchingOrder::Second, slow);
        const double error = test::arrivalError(m, truth, [&](const glm::dvec3& p) { return p.z < low - 2.0 / n; });
        EXPECT_LT(error, 0.15) << cells;  // cells
        EXPECT_TRUE(m.report.converged);
    }
}

/// Arrivals of 1e7 cells more, as far from the origin: in double the curvature stays; in single it would be noise at
/// 1e5.
TEST(FrontHazards, FarFromTheOriginTheCurvatureStays) {
    constexpr int n = 32;
    const glm::dvec3 focus(0.5, 0.5, -0.75);
    const auto curvature = [&](double offset) {
        const test::Marched m = test::march(
            n, [&](const glm::dvec3& p) { return offset - glm::length(p - focus); },
            [&](const glm::dvec3& p) { return test::nearSides(n, 2)(p) && p.z > 2.0 / n; });
        return test::curvatureError(
            m, [&](const glm::dvec3& p) { return -2 / glm::length(p - focus); },
            [&](const glm::dvec3& p) { return !test::nearSides(n, 3)(p); });
    };
    const double near = curvature(0);
    EXPECT_NEAR(curvature(1e5 / n), near, 1e-5);
    EXPECT_NEAR(curvature(1e7 / n), near, 1e-4);
}

/// 8 bytes of arrival a cell, an eighth of mask, half of keys and little of blocks: no solver holds more.
TEST(FrontHazards, BytesOfACell) {
    const BlockGrid grid(glm::ivec3(16));
    EXPECT_LE(double(grid.bytes()) / double(grid.cellCount()), 0.1);
    const FootPointLayer layer(256, 256);
    EXPECT_LE(double(layer.arrival.capacity()) / (256 * 256), 1.06);  // of ten values a point, two layers
}

}  // namespace
}  // namespace photic
