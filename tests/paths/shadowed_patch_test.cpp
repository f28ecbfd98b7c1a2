// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/shadowed_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

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

/// Whether the line through a point along a direction passes a triangle: the signs of the three cross products.
bool passes(const Triangle& t, const glm::dvec3& at, const glm::dvec3& direction) {
    double sign[3];
    for (std::size_t i = 0; i < 3; ++i) sign[i] = glm::dot(direction, glm::cross(t[i] - at, t[(i + 1) % 3] - at));
    return (sign[0] > 0) == (sign[1] > 0) && (sign[1] > 0) == (sign[2] > 0);
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

// The triangles around a ball's pole, whose corners are one but for rounding: a piece got them all, and a line through
// them cut it more than twice, which gave it more corners than it had room for (a crash).
TEST(ShadowedPatch, TrianglesThatMeetInOnePointAreCutOff) {
    const glm::dvec3 lamp(12585.952785828344, 28243.352391885423, 145.30830017503817);
    const ShadowedPatch::Corners corners = {{{-2014.2374081994528, -2657.8085254789826, 1.4087840726841683},
                                             {-1971.1151648495311, -2618.3775219915274, 44.462899036778673},
                                             {-1928.9458635379783, -2578.0945646590094, 1.2538479208256215},
                                             {-1972.0681068878998, -2617.5255681464646, -41.800267043268882}}};
    ShadowedPatch patch(corners, {lamp, lamp, lamp, lamp},
                        glm::normalize(glm::dvec3(-0.42662268303571377, -0.90441985998276464, -0.0042193824388391714)),
                        lamp);
    const std::vector<glm::dvec3> p = {{-1340.5608523338458, -1292.9093087552394, 10.588865412521614},
                                       {-1326.3505041670169, -1258.6024934848372, 7.8497391122689351},
                                       {-1329.755555898598, -1257.2890200916111, 7.8497391122689351},
                                       {-1354.8055171458923, -1327.2989717359408, 11.502641301323706},
                                       {-1332.6317405890632, -1297.4010950765257, 10.588865412521614},
                                       {-1334.125469149028, -1296.3490927316348, 10.588865412521614},
                                       {-1342.2654314398212, -1292.2517800364883, 10.588865412521614},
                                       {-1344.0002207106445, -1291.6786830723124, 10.588865412521614},
                                       {-1345.7610408870123, -1291.1913985034962, 10.588865412521614},
                                       {-1347.5436499988905, -1290.791100241247, 10.588865412521614},
                                       {-1352.979066051365, -1290.1207056126655, 10.588865412521614},
                                       {-1354.8055171458923, -1290.0758687549455, 10.588865412521614},
                                       {-1356.6319682404196, -1290.1207056126655, 10.588865412521614},
                                       {-1358.4540192542822, -1290.2551081699078, 10.588865412521614},
                                       {-1360.2672807069946, -1290.4787526391401, 10.588865412521614},
                                       {-1365.6108135811401, -1291.6786830723124, 10.588865412521614},
                                       {-1367.3456028519633, -1292.2517800364883, 10.588865412521614},
                                       {-1369.0501819579388, -1292.9093087552394, 10.588865412521614},
                                       {-1370.7204444186968, -1293.6496851842896, 10.588865412521614},
                                       {-1372.3523664256716, -1294.4711256919722, 10.588865412521614},
                                       {-1373.942016535809, -1295.3716513561546, 10.588865412521614},
                                       {-1375.4855651427565, -1296.3490927316348, 10.588865412521614},
                                       {-1379.8030252799724, -1299.7184716929687, 10.588865412521614},
                                       {-1381.1262256805592, -1300.9782632012739, 10.588865412521614},
                                       {-1376.9792937027214, -1297.4010950765257, 10.588865412521614}};
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : std::vector<std::array<std::size_t, 3>>{{0, 1, 2},
                                                                         {3, 4, 5},
                                                                         {3, 0, 6},
                                                                         {3, 6, 7},
                                                                         {3, 7, 8},
                                                                         {3, 8, 9},
                                                                         {3, 10, 11},
                                                                         {3, 11, 12},
                                                                         {3, 12, 13},
                                                                         {3, 13, 14},
                                                                         {3, 15, 16},
                                                                         {3, 17, 18},
                                                                         {3, 18, 19},
                                                                         {3, 19, 20},
                                                                         {3, 20, 21},
                                                                         {3, 22, 23},
                                                                         {3, 21, 24}})
        triangles.push_back({p[a], p[b], p[c]}), patch.shade(triangles.back());
    int open = 0;
    constexpr int kSide = 200;
    for (int i = 0; i < kSide * kSide; ++i) {
        const glm::dvec3 at = corners[0] + (i % kSide + 0.5) / kSide * (corners[1] - corners[0]) +
                              (i / kSide + 0.5) / kSide * (corners[3] - corners[0]);
        bool lit = true;
        for (const Triangle& t : triangles) lit = lit && !passes(t, at, at - lamp);
        open += lit;
    }
    EXPECT_NEAR(patch.openShare(), open / double(kSide * kSide), 5e-4);
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
            for (const Triangle& t : triangles) lit = lit && !passes(t, at, direction);
            open += lit;
        }
        EXPECT_NEAR(patch.openShare(), double(open) / kRays, 0.015) << round;
    }
}

}  // namespace
}  // namespace photic
