// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/emission.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/optics/tangent_frame.h"

namespace photic {
namespace {

TEST(LightSamples, ADiscHasItsOwnMeanAndMomentsForAnyNumber) {
    Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.45, -0.89, -0.09)), sun.irradiance = glm::dvec3(7);
    sun.angular_diameter_deg = 3;
    const double radius = 1.5 * std::numbers::pi / 180, c = std::cos(radius);
    const TangentFrame frame(sun.direction);
    for (const int count : {3, 4, 5, 9, 32, 100}) {
        const auto samples = lightSamples(sun, count);
        ASSERT_EQ(samples.size(), static_cast<std::size_t>(count));
        double x = 0, y = 0, xx = 0, xy = 0, yy = 0, power = 0;
        for (const LightSample& s : samples) {
            const double px = glm::dot(s.direction, frame.across), py = glm::dot(s.direction, frame.up);
            EXPECT_NEAR(glm::length(s.direction), 1, 1e-12);
            EXPECT_LT(std::acos(glm::dot(s.direction, sun.direction)), 1.1 * radius) << count;
            x += px / count, y += py / count, xx += px * px / count, xy += px * py / count, yy += py * py / count;
            power += s.strength.x;
        }
        const double moment = (1 - (1 + c + c * c) / 3) / 2;
        EXPECT_NEAR(x, 0, 1e-12 * radius);
        EXPECT_NEAR(y, 0, 1e-12 * radius);
        EXPECT_NEAR(xx / moment, 1, 1e-9);
        EXPECT_NEAR(yy / moment, 1, 1e-9);
        EXPECT_NEAR(xy / moment, 0, 1e-9);
        EXPECT_NEAR(power, 7, 1e-12);
        // Whoever takes the first alone takes the middle.
        for (const LightSample& s : samples)
            EXPECT_GE(glm::dot(samples[0].direction, sun.direction) + 1e-15, glm::dot(s.direction, sun.direction));
    }
}

TEST(LightSamples, TwoOfADiscFaceEachOther) {
    Light sun;
    sun.angular_diameter_deg = 1, sun.direction = {0, 0, -1};
    const auto samples = lightSamples(sun, 2);
    ASSERT_EQ(samples.size(), 2u);
    EXPECT_NEAR(samples[0].direction.x, -samples[1].direction.x, 1e-15);
    EXPECT_NEAR(samples[0].direction.y, -samples[1].direction.y, 1e-15);
}

TEST(LightSamples, ALampsPointsLieOnItEvenlyAboutItsCentre) {
    Light lamp;
    lamp.type = LightType::Rectangle, lamp.position = glm::dvec3(1, 2, 3), lamp.direction = {0, 0, -1};
    lamp.tangent = {1, 0, 0}, lamp.size = {0.4, 0.2}, lamp.power = glm::dvec3(10);
    for (const int count : {1, 2, 5, 16, 64}) {
        lamp.samples = count;
        glm::dvec3 mean(0);
        double across = 0;
        for (const LightSample& s : lightSamples(lamp, 1)) {
            const glm::dvec3 off = *s.source - *lamp.position;
            EXPECT_LE(std::fabs(off.x), 0.2 + 1e-12);
            EXPECT_LE(std::fabs(off.y), 0.1 + 1e-12);
            mean += off / static_cast<double>(count), across += off.x * off.x / count;
        }
        EXPECT_NEAR(glm::length(mean), 0, 1e-12);
        if (count >= 16) {
            EXPECT_NEAR(across / (0.4 * 0.4 / 12), 1, 0.05) << count;
        }
    }
}

}  // namespace
}  // namespace photic
