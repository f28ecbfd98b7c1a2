// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/obstacles.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using support::WaterScene;

/// Flat water, light straight down, and what stands in it.
struct Still {
    WaterScene water;
    OpticalScene optics;
    Emission emission;
    PathTracer tracer;
    Obstacles obstacles;
    explicit Still(std::vector<Object> objects)
        : water(withObjects(std::move(objects))),
          optics(water.scene, water.frame),
          emission(water.scene, 0, lightSamples(water.scene.lights[0], 1).front()),
          tracer(optics, emission, {{0, Branch::Refracted}}),
          obstacles(tracer) {}
    static WaterScene withObjects(std::vector<Object> objects) {
        WaterScene out;
        out.scene.objects = std::move(objects);
        return out;
    }
    Path path(double x, double y) const { return tracer.trace({{x, y, 0}, {}}, {}); }
    bool between(const glm::dvec2& a, const glm::dvec2& b) const {
        const Path p = path(a.x, a.y), q = path(b.x, b.y);
        std::int64_t searches = 0;
        return obstacles.between(p, q, glm::length(b - a) / 0.05, searches);
    }
};

TEST(Obstacles, EveryPoleBetweenThreePathsIsFoundByOneOfTheirEdges) {
    std::mt19937 random(2);
    std::uniform_real_distribution<> place(-0.9, 0.9);
    int inside = 0;
    for (int i = 0; i < 400; ++i) {
        const glm::dvec2 pole(place(random), place(random)), c[3] = {{-0.9, -0.8}, {0.9, -0.7}, {0.1, 0.9}};
        const auto side = [&](int k) {
            const glm::dvec2 e = c[(k + 1) % 3] - c[k], d = pole - c[k];
            return e.x * d.y - e.y * d.x > 0.01;
        };
        if (!side(0) || !side(1) || !side(2)) continue;
        ++inside;
        // Below the water, and above it.
        const double low = i % 2 ? -1.2 : 0.2;
        const Still still(
            {support::planeObject({0, 0, -1.5}, {0, 0, 1}),
             support::meshObject(support::boxMesh({pole.x, pole.y, low}, {pole.x + 1e-3, pole.y + 1e-3, low + 0.5}))});
        EXPECT_TRUE(still.between(c[0], c[1]) || still.between(c[1], c[2]) || still.between(c[2], c[0])) << i;
    }
    EXPECT_GT(inside, 50);
}

TEST(Obstacles, WhatStandsAsideIsNotBetween) {
    const Still still({support::meshObject(support::boxMesh({0.5, 0.5, -1}, {0.7, 0.7, -0.5}))});
    EXPECT_FALSE(still.between({-0.5, 0}, {0, 0}));
    EXPECT_FALSE(still.between({0.2, 0.2}, {0.35, 0.35}));
    EXPECT_TRUE(still.between({0.2, 0.2}, {0.9, 0.9}));
}

TEST(Obstacles, TheReceiverItselfIsNotBetween) {
    const Still still({support::meshObject(support::boxMesh({-3, -3, -1.8}, {3, 3, -1.5}))});
    EXPECT_FALSE(still.between({-0.9, -0.9}, {0.9, 0.8})) << "one triangle and its neighbour, in one plane";
    // A ball that stands out of it by more than a voxel is.
    const Still ball({support::meshObject(support::boxMesh({-3, -3, -1.8}, {3, 3, -1.5})),
                      support::meshObject(support::sphereMesh(12, {0.3, 0.1, -1.5}, 0.1))});
    EXPECT_TRUE(ball.between({-0.9, -0.9}, {0.9, 0.8}));
}

TEST(Obstacles, AGapInTheReceiverIsBetween) {
    // A plate of four boxes around a hole of 20 cm.
    TriangleMesh plate;
    for (const auto& [low, high] : {std::pair{glm::dvec3(-3, -3, -1), glm::dvec3(-0.1, 3, -0.8)},
                                    {glm::dvec3(0.1, -3, -1), glm::dvec3(3, 3, -0.8)},
                                    {glm::dvec3(-0.1, -3, -1), glm::dvec3(0.1, -0.1, -0.8)},
                                    {glm::dvec3(-0.1, 0.1, -1), glm::dvec3(0.1, 3, -0.8)}}) {
        const TriangleMesh box = support::boxMesh(low, high);
        const auto first = static_cast<std::uint32_t>(plate.positions.size());
        plate.positions.insert(plate.positions.end(), box.positions.begin(), box.positions.end());
        for (const auto& t : box.triangles) plate.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    plate.normals.assign(plate.positions.size(), {0, 0, 1});
    const Still still({support::meshObject(plate)});
    const glm::dvec2 a(-0.5, -0.4), b(0.5, -0.4), c(0, 0.5);
    EXPECT_TRUE(still.between(a, b) || still.between(b, c) || still.between(c, a));
    EXPECT_FALSE(still.between({-0.8, -0.9}, {-0.5, -0.8})) << "whole there";
}

TEST(Obstacles, AGapThatTwoFencesLeaveLightsTheirShadow) {
    // Two boards that overlap shade more than there is, and leave a gap of 2 cm between them and a third.
    const auto board = [](double low, double high, double z) {
        return support::meshObject(support::boxMesh({low, -3, z}, {high, 3, z + 0.01}));
    };
    const Still fences({board(-3, 0.1, 0.5), board(-3, 0, 0.6), board(0.12, 3, 0.5)});
    EXPECT_TRUE(fences.between({-0.2, 0}, {0.3, 0.1}));
    EXPECT_TRUE(fences.between({0.095, 0}, {0.125, 0})) << "less than a voxel apart";
    EXPECT_FALSE(fences.between({-0.7, 0}, {-0.5, 0.1})) << "two boards, one above the other";
    EXPECT_FALSE(fences.between({0.4, 0}, {0.7, 0.1}));
}

TEST(Obstacles, EdgesReadTheSameBothWays) {
    std::mt19937 random(4);
    std::uniform_real_distribution<> place(-0.9, 0.9);
    const Still still({support::meshObject(support::sphereMesh(10, {0.1, 0.2, -0.8}, 0.2)),
                       support::meshObject(support::boxMesh({-0.6, -0.6, 0.2}, {-0.5, 0.1, 0.3}))});
    for (int i = 0; i < 300; ++i) {
        const glm::dvec2 a(place(random), place(random)), b(place(random), place(random));
        if (still.path(a.x, a.y).outcome != still.path(b.x, b.y).outcome) continue;
        EXPECT_EQ(still.between(a, b), still.between(b, a));
    }
}

}  // namespace
}  // namespace photic
