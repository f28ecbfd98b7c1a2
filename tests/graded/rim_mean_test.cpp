// SPDX-License-Identifier: Apache-2.0
// The course of a field across a body's rim: a raised cosine's, whichever way the rim looks.
#include "bake/graded/rim_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace photic {
namespace {

constexpr double kWidth = 2.8;

/// Part of a raised cosine's weight that lies above -depth.
double share(double depth) {
    const double t = std::clamp(depth / kWidth, -1.0, 1.0);
    return 0.5 + 0.5 * t + std::sin(std::numbers::pi * t) / (2 * std::numbers::pi);
}

glm::dvec3 wayOf(int i) {
    const double phi = 2.4 * i, z = -0.97 + 0.0485 * i;
    return {std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z};
}
/// A direction that is off by some twenty degrees, as a guess may be.
glm::dvec3 about(const glm::dvec3& way) { return way + 0.3 * glm::dvec3(way.y, way.z, way.x); }

TEST(RimMean, OfAPlaneIsThatOfItsNormal) {
    for (int i = 0; i < 40; ++i) {
        const glm::dvec3 up = wayOf(i), on(0.3, -0.2, 0.1);
        // A value that grows with the depth: its mean is known too.
        const RimMean mean{[&](const glm::dvec3& p) { return glm::dot(p - on, up) > 0; },
                           [](const glm::dvec3&) { return 2.0; }, kWidth};
        for (const double depth : {-2.7, -1.9, -0.6, 0.05, 0.8, 2.2}) {
            const auto got = mean.at(on + depth * up + 5.0 * glm::cross(up, on), about(up));
            ASSERT_TRUE(got) << i << ", " << depth;
            EXPECT_NEAR(*got, 2 * share(depth), 2e-4) << i << ", " << depth;
        }
    }
}

TEST(RimMean, OfABallIsTheSameAllAround) {
    const double radius = 7;
    const RimMean mean{[&](const glm::dvec3& p) { return glm::length(p) < radius; },
                       [&](const glm::dvec3& p) { return 1 + 0.1 * (radius - glm::length(p)); }, kWidth};
    for (const double depth : {-2.0, 0.4, 1.5}) {
        const auto first = mean.at((radius - depth) * wayOf(0), about(-wayOf(0)));
        ASSERT_TRUE(first);
        for (int i = 1; i < 40; ++i) {
            const auto got = mean.at((radius - depth) * wayOf(i), about(-wayOf(i)));
            ASSERT_TRUE(got) << i;
            EXPECT_NEAR(*got, *first, 3e-4) << i << ", " << depth;
        }
        // What grows with the depth, by a sum of many steps.
        double sum = 0;
        constexpr int kSteps = 20000;
        for (int k = 0; k < kSteps; ++k) {
            const double t = kWidth * (2 * (k + 0.5) / kSteps - 1), there = depth + t;
            if (there > 0) sum += (1 + 0.1 * there) * (1 + std::cos(std::numbers::pi * t / kWidth)) / kSteps;
        }
        EXPECT_NEAR(*first, sum, 3e-4) << depth;
    }
}

TEST(RimMean, OfAThinWallHasBothSides) {
    const double half = 0.9;
    const glm::dvec3 up = wayOf(13);
    const RimMean mean{[&](const glm::dvec3& p) { return std::fabs(glm::dot(p, up)) < half; },
                       [](const glm::dvec3&) { return 1.0; }, kWidth};
    for (const double height : {0.1, 0.7, 1.8}) {
        const auto got = mean.at(height * up, about(-up));
        ASSERT_TRUE(got) << height;
        EXPECT_NEAR(*got, share(half - height) - share(-half - height), 2e-4) << height;
    }
}

TEST(RimMean, KnowsNothingNearEdges) {
    const RimMean mean{[](const glm::dvec3& p) { return p.x < 0 && p.y < 0; }, [](const glm::dvec3&) { return 1.0; },
                       kWidth};
    EXPECT_FALSE(mean.at({-0.3, -0.2, 0}, {-1, -1, 0}));
    EXPECT_FALSE(mean.at({0.4, -1.2, 0}, {-1, -0.3, 0}));
    EXPECT_FALSE(mean.at({-1.5, -0.4, 0}, {-0.3, -1, 0}));
    EXPECT_TRUE(mean.at({0.4, -6, 0}, {-1, -0.3, 0}));
    // A ball so small that it is all bend.
    const RimMean pea{[](const glm::dvec3& p) { return glm::length(p) < 1.5; }, [](const glm::dvec3&) { return 1.0; },
                      kWidth};
    EXPECT_FALSE(pea.at({1.2, 0.3, 0}, {-1, 0, 0}));
}

}  // namespace
}  // namespace photic
