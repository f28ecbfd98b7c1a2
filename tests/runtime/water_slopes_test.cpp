// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/water_slopes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "tests/runtime/water_model.h"

namespace photic::runtime {
namespace {

constexpr double kPi = std::numbers::pi;

double height(double x, double y) { return 0.03 * std::sin(2 * kPi * x + 0.3) * std::cos(kPi * y); }

double worstSlope(int side, WaterOutside outside, int rim) {
    const auto sampled = test::sampleWater(side, height, 1, outside);
    const auto texels = waterTexels(sampled.water);
    EXPECT_TRUE(texels.ok());
    double worst = 0;
    for (int j = rim; j < side - rim; ++j) {
        for (int i = rim; i < side - rim; ++i) {
            const double x = -1 + (i + 0.5) * 2 / side, y = -1 + (j + 0.5) * 2 / side;
            const double dx = 0.03 * 2 * kPi * std::cos(2 * kPi * x + 0.3) * std::cos(kPi * y);
            const double dy = -0.03 * kPi * std::sin(2 * kPi * x + 0.3) * std::sin(kPi * y);
            const float* t = &texels->values[static_cast<std::size_t>(j * side + i) * 4];
            worst = std::max({worst, std::fabs(t[1] - dx), std::fabs(t[2] - dy)});
        }
    }
    return worst;
}

TEST(WaterSlopes, ConvergeAtFourthOrder) {
    const double a = worstSlope(16, WaterOutside::Periodic, 0), b = worstSlope(32, WaterOutside::Periodic, 0),
                 c = worstSlope(64, WaterOutside::Periodic, 0);
    EXPECT_GT(std::log2(a / b), 3.8);
    EXPECT_GT(std::log2(b / c), 3.7);
}

TEST(WaterSlopes, RimOfFlatWaterConvergesAtSecondOrder) {
    const double a = worstSlope(32, WaterOutside::Flat, 0), b = worstSlope(64, WaterOutside::Flat, 0);
    EXPECT_GT(std::log2(a / b), 1.8);
    EXPECT_LT(worstSlope(64, WaterOutside::Flat, 2), 0.1 * b);
}

TEST(WaterSlopes, VarianceIsTheMeanSquare) {
    const auto sampled = test::sampleWater(64, height, 1, WaterOutside::Periodic);
    const auto texels = waterTexels(sampled.water);
    ASSERT_TRUE(texels.ok());
    EXPECT_NEAR(texels->covariance[0], std::pow(0.03 * 2 * kPi, 2) / 4, 1e-6);
    EXPECT_NEAR(texels->covariance[1], 0, 1e-6);
    EXPECT_NEAR(texels->covariance[2], std::pow(0.03 * kPi, 2) / 4, 1e-6);
}

TEST(WaterSlopes, CovarianceOfMisalignmentIsThatOfSmallSlopes) {
    // exp(-tau a^2) with tau = 1 and a tiny a is 1 - a^2: the model's own rays, at two slopes that have the covariance.
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, -0.3, -0.8));
    const float direction[3] = {static_cast<float>(sun.x), static_cast<float>(sun.y), static_cast<float>(sun.z)};
    const double e = 1e-4;
    const glm::dvec2 a{2 * e, 0.5 * e}, b{-0.3 * e, e};
    const double covariance[3] = {a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y};
    for (const LookupAxes axes : {LookupAxes::One, LookupAxes::Both}) {
        const int count = static_cast<int>(axes);
        const auto below = [&](const glm::dvec2& s) {
            return -std::log(test::lookupOmega(s, sun, 1.333, 1, count, 0));
        };
        const auto above = [&](const glm::dvec2& s) { return -std::log(test::lookupReflected(s, sun, 1, count)); };
        const LookupCovariance c = lookupCovariance(direction, 1.333, covariance, axes);
        EXPECT_NEAR((below(a) + below(b)) / c.trace_below, 1, 1e-3) << count;
        EXPECT_NEAR((above(a) + above(b)) / c.trace_above, 1, 1e-3) << count;
        EXPECT_EQ(c.determinant_below == 0, axes == LookupAxes::One);
    }
    // The determinant follows from traces along single slopes: rank one has none.
    const double line[3] = {a.x * a.x, a.x * a.y, a.y * a.y};
    const LookupCovariance flat = lookupCovariance(direction, 1.333, line, LookupAxes::Both);
    EXPECT_NEAR(flat.determinant_below / (flat.trace_below * flat.trace_below), 0, 1e-12);
}

TEST(WaterSlopes, NonsenseIsRefused) {
    auto good = test::sampleWater(8, height, 1);
    EXPECT_TRUE(waterTexels(good.water).ok());
    auto bad = good.water;
    bad.heights = nullptr;
    EXPECT_FALSE(waterTexels(bad).ok());
    bad = good.water;
    bad.columns = 3;
    EXPECT_FALSE(waterTexels(bad).ok());
    bad = good.water;
    bad.size[1] = 0;
    EXPECT_FALSE(waterTexels(bad).ok());
    good.heights[9] = std::numeric_limits<float>::quiet_NaN();
    const auto refused = waterTexels(good.water);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("(1, 1)"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace photic::runtime
