// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/shadowed_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace photic {
namespace {

using Triangle = std::array<glm::dvec3, 3>;

ShadowedPatch::Corners square(double z) { return {{{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}}}; }

ShadowedPatch under(double height) { return {square(0), square(height), {0, 0, -1}, std::nullopt}; }

/// A board over x in [low, high], all along y.
void shadeByBoard(ShadowedPatch& patch, double low, double high, double z) {
    patch.shade({{{low, -1, z}, {high, -1, z}, {high, 2, z}}});
    patch.shade({{{low, -1, z}, {high, 2, z}, {low, 2, z}}});
}

TEST(ShadowedPatch, BoardsThatOverlapCountOnce) {
    ShadowedPatch patch = under(3);
    EXPECT_FALSE(patch.isShaded());
    EXPECT_NEAR(patch.openShare(), 1, 1e-12);
    shadeByBoard(patch, -0.5, 0.5, 1);
    shadeByBoard(patch, -0.5, 0.6, 2);
    EXPECT_TRUE(patch.isShaded());
    EXPECT_NEAR(patch.openShare(), 0.4, 1e-12);
    shadeByBoard(patch, 0.61, 1.5, 2.5);
    EXPECT_NEAR(patch.openShare(), 0.01, 1e-12) << "the gap that both leave";
    EXPECT_FALSE(patch.dark());
    shadeByBoard(patch, 0.55, 0.65, 0.5);
    EXPECT_TRUE(patch.dark());
}

TEST(ShadowedPatch, WhatStandsBehindOrBeforeItsLightShadesNothing) {
    ShadowedPatch patch = under(3);
    shadeByBoard(patch, -1, 2, -0.1), shadeByBoard(patch, -1, 2, 3.1);
    EXPECT_FALSE(patch.isShaded());
    // Half of a slanting board stands in the way.
    patch.shade({{{0, -1, -0.5}, {1, -1, 0.5}, {1, 2, 0.5}}}),
        patch.shade({{{0, -1, -0.5}, {1, 2, 0.5}, {0, 2, -0.5}}});
    EXPECT_NEAR(patch.openShare(), 0.5, 1e-12);
}

TEST(ShadowedPatch, ALampSeesThingsLargerThatStandNearToIt) {
    const glm::dvec3 lamp(0.5, 0.5, 2);
    ShadowedPatch patch(square(0), {lamp, lamp, lamp, lamp}, {0, 0, -1}, lamp);
    // Halfway: half as large as what it shades.
    patch.shade({{{0.4, 0.4, 1}, {0.6, 0.4, 1}, {0.6, 0.6, 1}}}),
        patch.shade({{{0.4, 0.4, 1}, {0.6, 0.6, 1}, {0.4, 0.6, 1}}});
    EXPECT_NEAR(patch.openShare(), 1 - 0.16, 1e-12);
    // One that reaches behind the lamp shades what it does before it.
    ShadowedPatch other(square(0), {lamp, lamp, lamp, lamp}, {0, 0, -1}, lamp);
    other.shade({{{0.5, -9, 1}, {0.5, 9, 1}, {20.5, 0, 21}}});
    EXPECT_NEAR(other.openShare(), 0.5, 1e-6);
}

TEST(ShadowedPatch, ManyTrianglesLeaveWhatRaysFindOpen) {
    std::mt19937 random(5);
    std::uniform_real_distribution<> place(-0.2, 1.2), side(-0.35, 0.35), height(0.1, 2.8), inside(0, 1);
    for (int round = 0; round < 20; ++round) {
        const glm::dvec3 direction = glm::normalize(glm::dvec3(side(random), side(random), -1));
        const glm::dvec3 back = 3 / direction.z * direction;
        ShadowedPatch::Corners from = square(0);
        for (glm::dvec3& p : from) p += back;
        ShadowedPatch patch(square(0), from, direction, std::nullopt);
        std::vector<Triangle> triangles;
        for (int i = 0; i < 12; ++i) {
            const glm::dvec3 p(place(random), place(random), height(random));
            Triangle t;
            for (glm::dvec3& c : t) c = p + glm::dvec3(side(random), side(random), 0.2 * side(random));
            triangles.push_back(t);
            patch.shade(t);
        }
        int open = 0;
        constexpr int kRays = 20000;
        for (int r = 0; r < kRays; ++r) {
            const glm::dvec3 at(inside(random), inside(random), 0);
            bool lit = true;
            for (const Triangle& t : triangles) {
                // Seen along the light: the signs of the three cross products.
                double sign[3];
                for (int k = 0; k < 3; ++k) {
                    const auto i = static_cast<std::size_t>(k), j = static_cast<std::size_t>((k + 1) % 3);
                    sign[k] = glm::dot(direction, glm::cross(t[i] - at, t[j] - at));
                }
                const bool same = (sign[0] > 0) == (sign[1] > 0) && (sign[1] > 0) == (sign[2] > 0);
                lit = lit && !same;
            }
            open += lit;
        }
        EXPECT_NEAR(patch.openShare(), double(open) / kRays, 0.015) << round;
    }
}

}  // namespace
}  // namespace photic
