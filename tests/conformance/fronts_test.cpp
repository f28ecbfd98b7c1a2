// SPDX-License-Identifier: Apache-2.0
// The curvature of marched fronts at 256^3: what takes too long for the numerics' own tests.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/numerics/bump_front.h"
#include "tests/numerics/fronts.h"

namespace photic {
namespace {

/// As BlockMarching.ConvergingSphereHasSecondOrderCurvature, one octave further.
TEST(Fronts, ConvergingSphereAt256) {
    constexpr int n = 256;
    const glm::dvec3 focus(0.5, 0.5, -0.75);
    const test::Marched m = test::march(
        n, [&](const glm::dvec3& p) { return 3 - glm::length(p - focus); },
        [&](const glm::dvec3& p) { return test::nearSides(n, 2)(p) && p.z > 2.0 / n; });
    const double error = test::curvatureError(
        m, [&](const glm::dvec3& p) { return -2 / glm::length(p - focus); },
        [&](const glm::dvec3& p) { return !test::nearSides(n, 3)(p); });
    EXPECT_LE(error, 3.05e-5);  // a prototype, in a setting of its own: 2.9e-5
    EXPECT_TRUE(m.report.converged);
}

/// The bump's front from seeds beside a smooth surface, against foot points in closed form.
TEST(Fronts, GaussianBumpAt256) {
    const test::BumpFront front(256);
    std::vector<double> t(front.truth);
    EikonalProblem problem;
    problem.grid = &front.grid, problem.spacing = front.h, problem.fixed = &front.fixed;
    EXPECT_TRUE(marchBlocks(problem, {}, t).converged);
    const test::BumpErrors errors = errorsOf(front, t);
    EXPECT_LE(errors.curvature, 4.3e-3 / 4);  // scikit-fmm, second order: 0.21
    EXPECT_LE(errors.arrival, 2e-4);          // cells
}

}  // namespace
}  // namespace photic
