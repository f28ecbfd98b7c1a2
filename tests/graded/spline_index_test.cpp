// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/spline_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/graded/ray_integrator.h"
#include "bake/report/error.h"

namespace photic {
namespace {

SplineIndex sampled(const GradedIndex& index, const glm::dvec3& half, double spacing, SplineFit fit) {
    SplineIndex::Nodes nodes;
    nodes.spacing = glm::dvec3(spacing);
    nodes.first_world = -half;
    nodes.count = glm::ivec3(glm::round(2.0 * half / spacing)) + 1;
    return {nodes, [&](const glm::dvec3& p) { return index.at(p).half_square; }, fit};
}

double worstDifference(const GradedIndex& a, const SplineIndex& b, double reach) {
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 u(std::fmod(0.5 + 0.8191725 * i, 1.0), std::fmod(0.5 + 0.6710436 * i, 1.0),
                           std::fmod(0.5 + 0.5497004 * i, 1.0));
        const glm::dvec3 p = reach * (2.0 * u - 1.0);
        worst = std::max(worst, glm::length(a.at(p).gradient - b.at(p).gradient));
    }
    return worst;
}

TEST(SplineIndex, ConvergesToASmoothIndexWithItsGradient) {
    const auto eye = makeFishEye({0.1, 0, -0.05}, 1.7, 1, {});
    const double coarse = worstDifference(*eye, sampled(*eye, glm::dvec3(1), 1 / 16.0, SplineFit::Through), 0.4),
                 fine = worstDifference(*eye, sampled(*eye, glm::dvec3(1), 1 / 32.0, SplineFit::Through), 0.4);
    EXPECT_LT(fine, 5e-5);
    EXPECT_NEAR(std::log2(coarse / fine), 3, 0.6);  // a cubic spline's slope is of third order
}

TEST(SplineIndex, GoesThroughItsSamplesUpToTheRim) {
    const auto slope = makeSaltLayers({.thickness = 0.3}, {});
    const SplineIndex spline = sampled(*slope, {0.5, 0.5, 0.5}, 1 / 16.0, SplineFit::Through);
    for (const double z : {-0.4375, -0.25, 0.0, 0.375}) {
        const glm::dvec3 p(0.125, -0.25, z);
        EXPECT_NEAR(spline.at(p).half_square, slope->at(p).half_square, 1e-6);
    }
}

TEST(SplineIndex, GoesOnStraightBeyondTheRim) {
    // A slope that ends with the nodes must not ring into them.
    const auto slope = makeLinearSquare(glm::dvec3(0), 1.5, {0.3, -0.2, 0.5}, {});
    const SplineIndex spline = sampled(*slope, {0.5, 0.5, 0.5}, 1 / 16.0, SplineFit::Through);
    for (const glm::dvec3 p : {glm::dvec3(-0.43, 0.1, 0.2), {0.43, -0.43, 0.43}, {0, 0.43, -0.43}}) {
        EXPECT_NEAR(spline.at(p).half_square, slope->at(p).half_square, 1e-6);
        EXPECT_LT(glm::length(spline.at(p).gradient - slope->at(p).gradient), 2e-5);
    }
}

TEST(SplineIndex, ThePlainFitKeepsConstantRegionsConstantBesideAJump) {
    const auto step =
        makeLinearSquare(glm::dvec3(0), 1.5, glm::dvec3(0), WorldBox{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}});
    const SplineIndex plain = sampled(*step, glm::dvec3(1), 1 / 16.0, SplineFit::Plain),
                      through = sampled(*step, glm::dvec3(1), 1 / 16.0, SplineFit::Through);
    EXPECT_DOUBLE_EQ(plain.steepest(), 1);
    const glm::dvec3 inside(0.01, 0.02, 0.3), outside(0.01, 0.02, 0.75);
    EXPECT_FLOAT_EQ(static_cast<float>(plain.at(inside).half_square), 1.125f);
    EXPECT_LT(glm::length(plain.at(inside).gradient), 1e-12);
    EXPECT_LT(glm::length(plain.at(outside).gradient), 1e-12);
    EXPECT_GT(glm::length(through.at(inside).gradient), 1e-4);  // it rings
}

TEST(SplineIndex, RefusesWhatIsNoIndexAndSaysWhere) {
    const auto negative = makeLinearSquare(glm::dvec3(0), 1, {0, 0, 2}, {});
    try {
        sampled(*negative, glm::dvec3(1), 0.125, SplineFit::Plain);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Input);
        EXPECT_NE(std::string(error.what()).find("-1) m"), std::string::npos) << error.what();
    }
}

TEST(SplineIndex, RaysThroughItMeetThoseOfTheIndexItself) {
    // Runge-Kutta on the spline and on the formula, over voxels of 1/64: 1e-4 voxel apart at most.
    constexpr double kVoxel = 1 / 64.0;
    const std::shared_ptr<const GradedIndex> indices[] = {makeFishEye(glm::dvec3(0), 1.5, 1, {}),
                                                          makeSelfocRod({.n0 = 1.5, .g = 0.7})};
    for (const auto& index : indices) {
        const SplineIndex spline = sampled(*index, glm::dvec3(0.75), kVoxel, SplineFit::Through);
        const SplineGradedIndex on_spline(spline);
        for (const double x0 : {0.1, 0.3, 0.45}) {
            GradedRay a = startRay(*index, {x0, 0.1, -0.6}, {0, 0, 1}), b = a;
            for (int i = 0; i < 400; ++i) stepRungeKutta(*index, 2e-3, a), stepRungeKutta(on_spline, 2e-3, b);
            EXPECT_LT(glm::distance(a.position, b.position), 1e-4 * kVoxel);
        }
    }
}

TEST(SplineIndex, ASampledLuneburgLensFocusesToATenthOfAVoxel) {
    // The kink at its rim is what sampling costs.
    double before = 1;
    for (const int voxels : {16, 32, 64}) {
        const auto lens = makeLuneburgLens(glm::dvec3(0), 1);
        const SplineIndex spline = sampled(*lens, glm::dvec3(1.25), 1.0 / voxels, SplineFit::Through);
        const SplineGradedIndex on_spline(spline);
        double sum = 0;
        for (int i = 0; i <= 12; ++i) {
            GradedRay ray{{0.9 * (i / 6.0 - 1), 0, -1.125}, {0, 0, 1}, 0};
            while (ray.position.z < 1 - 1e-9) ASSERT_TRUE(stepBetweenPlanes(on_spline, 2, 0.125 / voxels, ray));
            sum += ray.position.x * ray.position.x / 13;
        }
        const double miss = std::sqrt(sum);
        EXPECT_LT(miss * voxels, 0.1);  // [voxels]
        EXPECT_LT(miss, 0.7 * before);  // [m]
        before = miss;
    }
}

}  // namespace
}  // namespace photic
