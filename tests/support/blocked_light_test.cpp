// SPDX-License-Identifier: Apache-2.0
// Counted rays against the closed forms of shadows in parallel light.
#include "tests/support/blocked_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/closed_forms.h"

namespace photic::truth {
namespace {

TEST(BlockedLight, IsTheShadowsAreaUnderFlatWater) {
    const SineWater water;
    for (const double zenith : {0.0, 0.6, 1.1}) {
        const glm::dvec3 sun(0.8 * std::sin(zenith), -0.6 * std::sin(zenith), -std::cos(zenith));
        const PlaneWater plane{1, std::cos(zenith), 1, 1.333};
        const glm::dvec3 below = refractDown(sun, {0, 0}, 1.333)->direction;
        EXPECT_NEAR(-below.z, plane.cosBelow(), 1e-14);
        EXPECT_NEAR(glm::length(below), 1, 1e-14);
        const Box box{{-0.1, -0.2, -0.9}, {0.15, 0.1, -0.4}};
        const Ball ball{{0.3, 0.2, -0.7}, 0.25};
        EXPECT_NEAR(blockedLight(water, sun, box, -1.5).power / (plane.horizontal(0) * shadowArea(box, below)), 1,
                    2e-3);
        EXPECT_NEAR(blockedLight(water, sun, ball, -1.5).power / (plane.horizontal(0) * shadowArea(ball, below)), 1,
                    2e-3);
    }
}

TEST(BlockedLight, LandsWhereLightWouldHave) {
    const BlockedLight blocked = blockedLight({}, {0, 0, -1}, Box{{-0.1, -0.2, -0.9}, {0.15, 0.1, -0.4}}, -1.5, 1000);
    EXPECT_NEAR(blocked.low.x, -0.1, 2e-3);
    EXPECT_NEAR(blocked.low.y, -0.2, 2e-3);
    EXPECT_NEAR(blocked.high.x, 0.15, 2e-3);
    EXPECT_NEAR(blocked.high.y, 0.1, 2e-3);
}

TEST(BlockedLight, MeshesBlockAsTheirShape) {
    // A rock without lumps is a ball; 5120 triangles of it, to their chords.
    Triangles ball = rock({0.1, 0, -0.6}, 0.4, 3, 1);
    for (glm::dvec3& p : ball.positions) p = ball.center + 0.2 * glm::normalize(p - ball.center);
    ball.radius = 0.2;
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, 0.2, -0.8));
    const SineWater waves{{{0.01, 0.7, 30, 0.4}, {0.004, 0.3, 120, 1}}};
    const double mesh = blockedLight(waves, sun, ball, -1.5, 300).power,
                 smooth = blockedLight(waves, sun, Ball{{0.1, 0, -0.6}, 0.2}, -1.5, 300).power;
    EXPECT_NEAR(mesh / smooth, 1, 0.01);
    EXPECT_LT(mesh, smooth);
    EXPECT_EQ(rock({0, 0, -1}, 0.4, 2, 7).triangles.size(), 320u);
    EXPECT_LE(rock({0, 0, -1}, 0.4, 2, 7).radius, 0.2);
}

TEST(BlockedLight, WavesFocusLightOnABallBelowACrest) {
    // Paraxial light below a crest of curvature c converges: (1 - c (1 - 1/n) depth) of its width is left.
    const double amplitude = 0.002, wavelength = 0.5, depth = 1, n = 1.333;
    const double k = 2 * 3.14159265358979 / wavelength, focus = 1 - amplitude * k * k * (1 - 1 / n) * depth;
    const SineWater waves{{{amplitude, wavelength, 0, 3.14159265358979 / 2}}};
    const Ball ball{{0, 0, -depth}, 0.01};
    const double power = blockedLight(waves, {0, 0, -1}, ball, -1.2).power;
    EXPECT_NEAR(power / (fresnelTransmittance(1, 1, n) * shadowArea(ball, {0, 0, -1})), 1 / focus, 0.01 / focus);
}

}  // namespace
}  // namespace photic::truth
