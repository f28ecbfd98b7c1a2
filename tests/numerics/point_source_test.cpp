// SPDX-License-Identifier: Apache-2.0
// Fronts from a point inside the medium, in closed form: what the factorisation is for.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/numerics/fronts.h"

namespace photic {
namespace {

const glm::dvec3 kSource(0.53125, 0.46875, 0.3125);  // a corner of cells

struct Errors {
    double arrival, curvature;  // mean and relative L1
};

/// From a ball of three cells around the source; errors away from it and from the sides.
Errors marchFromPoint(int n, const test::Field& truth, const test::Field& slow, const glm::dvec3& gradient,
                      bool factored) {
    BlockGrid grid(glm::ivec3(n / BlockGrid::kSide));
    test::Marched m{n, grid, CellMask(grid), std::vector<double>(grid.cellCount(), kUnreached), {}, {}, {}};
    PointSource source;
    source.place = kSource - 0.5 / n, source.slowness = slow(kSource), source.gradient = gradient;
    for (std::int64_t c = 0; c < std::int64_t(m.arrival.size()); ++c) {
        const glm::dvec3 p = m.place(c);
        m.slowness.push_back(static_cast<float>(slow(p)));
        if (glm::length(p - kSource) > 3.01 / n) continue;
        m.fixed.set(c);
        m.arrival[std::size_t(c)] = source.arrival(p - kSource);
    }
    m.problem.grid = &m.grid, m.problem.spacing = 1.0 / n, m.problem.fixed = &m.fixed,
    m.problem.slownesses = m.slowness;
    if (factored) m.problem.source = &source;
    m.report = marchBlocks(m.problem, {}, m.arrival);
    EXPECT_TRUE(m.report.converged);
    const auto counts = [&](const glm::dvec3& p) {
        return glm::length(p - kSource) > 0.15 && !test::nearSides(n, 3)(p);
    };
    // div(grad T / n) of the truth, by fine differences.
    const auto curvature = [&](const glm::dvec3& p) {
        constexpr double e = 1e-4;
        double sum = 0;
        for (int a = 0; a < 3; ++a) {
            glm::dvec3 up(0);
            up[a] = e;
            sum += ((truth(p + up) - truth(p)) / slow(p + 0.5 * up) - (truth(p) - truth(p - up)) / slow(p - 0.5 * up)) /
                   (e * e);
        }
        return sum;
    };
    return {test::arrivalError(m, truth, counts) / n, test::curvatureError(m, curvature, counts)};
}

TEST(PointSources, InAConstantMediumTheFactorIsAll) {
    const auto truth = [](const glm::dvec3& p) { return 1.4 * glm::length(p - kSource); };
    const auto slow = [](const glm::dvec3&) { return 1.4; };
    const Errors plain = marchFromPoint(32, truth, slow, glm::dvec3(0), false);
    const Errors factored = marchFromPoint(32, truth, slow, glm::dvec3(0), true);
    EXPECT_LT(factored.arrival, 1e-7);  // the index is kept in single precision
    EXPECT_LT(factored.curvature, 1e-5);
    EXPECT_GT(plain.arrival, 1e-4);
}

/// n^2 = n0^2 + 2 G . x: rays are parabolas, T = S s - |G|^2 s^3 / 6.
TEST(PointSources, LinearSquaredIndexIsFarMoreExactThanWithoutTheFactor) {
    const glm::dvec3 G(0.3, -0.2, 0.4);
    const auto slow = [&](const glm::dvec3& p) { return std::sqrt(1.6 + 2 * glm::dot(G, p - kSource)); };
    const auto truth = [&](const glm::dvec3& p) {
        const double S = 0.5 * (1.6 + slow(p) * slow(p)), far = glm::dot(p - kSource, p - kSource), g2 = glm::dot(G, G);
        const double s = std::sqrt(2 * far / (S + std::sqrt(S * S - g2 * far)));
        return S * s - g2 * s * s * s / 6;
    };
    Errors last{}, plain{};
    for (const int n : {32, 64}) {
        const Errors e = marchFromPoint(n, truth, slow, G / std::sqrt(1.6), true);
        if (n > 32) {
            EXPECT_GT(std::log2(last.arrival / e.arrival), 1.0) << n << ": " << last.arrival << " " << e.arrival;
        }
        last = e;
    }
    EXPECT_LT(last.arrival * 64, 2e-4);  // cells
    EXPECT_LT(last.curvature, 1e-4);
    plain = marchFromPoint(64, truth, slow, G / std::sqrt(1.6), false);
    EXPECT_GT(plain.arrival / last.arrival, 20) << last.arrival;
    EXPECT_GT(plain.curvature / last.curvature, 5) << last.curvature;
}

/// Maxwell's fish-eye, n = n0 / (1 + |x - c|^2 / a^2).
TEST(PointSources, MaxwellsFishEyeConverges) {
    constexpr double n0 = 2, a = 1.1;
    const glm::dvec3 centre(0.4, 0.6, 0.5), from = kSource - centre;
    const auto slow = [&](const glm::dvec3& p) { return n0 / (1 + glm::dot(p - centre, p - centre) / (a * a)); };
    const auto truth = [&](const glm::dvec3& p) {
        const glm::dvec3 x = p - centre;
        return n0 * a *
               std::asin(a * glm::length(x - from) /
                         std::sqrt((a * a + glm::dot(x, x)) * (a * a + glm::dot(from, from))));
    };
    const glm::dvec3 gradient = -2 * slow(kSource) * slow(kSource) / (n0 * a * a) * from;
    Errors last{};
    for (const int n : {32, 64}) {
        const Errors e = marchFromPoint(n, truth, slow, gradient, true);
        if (n > 32) {
            EXPECT_GT(std::log2(last.arrival / e.arrival), 0.9) << n << ": " << last.arrival << " " << e.arrival;
            EXPECT_GT(std::log2(last.curvature / e.curvature), 1.2)
                << n << ": " << last.curvature << " " << e.curvature;
        }
        last = e;
    }
    EXPECT_LT(last.arrival * 64, 6e-3);  // cells
    EXPECT_LT(last.curvature, 3e-3);
}

}  // namespace
}  // namespace photic
