// SPDX-License-Identifier: Apache-2.0
// Media that surfaces enclose, as bodies for eye rays.
#include "bake/graded/enclosed_bodies.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/graded/object_samples.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic {
namespace {

std::shared_ptr<const TriangleMesh> block(const glm::dvec3& low, const glm::dvec3& high) {
    TriangleMesh mesh;
    for (int corner = 0; corner < 8; ++corner)
        mesh.positions.emplace_back(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                    corner & 4 ? high.z : low.z);
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    mesh.normals.assign(8, glm::dvec3(0, 0, 1));
    return std::make_shared<const TriangleMesh>(mesh);
}

Scene sceneWith(const std::string& media) {
    Monitor monitor;
    return parseScene(
        "photic = 1\n[domain]\nmin = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0.1]\nvoxel_size = 0.0125\n"
        "[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1\nangular_diameter = 0\n" +
            media,
        "s.toml", "", 0, monitor);
}

std::string medium(const std::string& name, const std::string& index) {
    return fmt::format("[[medium]]\nname = \"{}\"\nindex = {}\n", name, index);
}
std::string ball(const std::string& name, const std::string& inside, double radius) {
    return fmt::format(
        "[[surface]]\nname = \"{}\"\nkind = \"sphere\"\nposition = [0, 0, -0.4]\nradius = {}\ninside = "
        "\"{}\"\n",
        name, radius, inside);
}

/// A scene with a block of a medium.
Scene blockOf(const std::string& index) {
    Scene scene = sceneWith(medium("core", index) + ball("block", "core", 0.1));
    Surface& surface = scene.surfaces.front();
    surface.sphere.reset(), surface.mesh = block({-0.35, -0.35, -0.4}, {0.35, 0.35, 0});
    return scene;
}

ObjectSamples sampled(const Scene& scene, double voxel, std::size_t number = 0) {
    Monitor monitor;
    return sampleObject(bodiesOf(scene), number, {voxel, {scene.domain.min, scene.domain.max}}, monitor);
}

float least(const ObjectSamples& s) { return *std::min_element(s.spline.front().begin(), s.spline.front().end()); }

// The rod's index falls to that of air and to 0 far from its axis: neither is of the block.
TEST(EnclosedBodies, ABlockOfSelfocEndsWithTheBlock) {
    for (const double voxel : {0.0125, 0.05}) {
        const ObjectSamples s = sampled(blockOf("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }"), voxel);
        EXPECT_TRUE(s.sharp_sides);
        const glm::dvec3 low = s.origin_world + s.world_from_node * glm::dvec3(s.box_low),
                         high = s.origin_world + s.world_from_node * glm::dvec3(s.box_high);
        EXPECT_LT(glm::distance(low, {-0.35, -0.35, -0.4}), 1e-6);
        EXPECT_LT(glm::distance(high, {0.35, 0.35, 0}), 1e-6);
    }
}

// Four nodes beyond a side a straight line may lie far below 0, where readers refuse it.
TEST(EnclosedBodies, NoSplineOfOneFallsBelowZero) {
    for (const double voxel : {0.0125, 0.025, 0.05})
        for (const char* index :
             {"{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }", "{ kind = \"selfoc\", n0 = 2.4, g = 1.99 }",
              "{ kind = \"linear\", n0 = 1.5, slope = [6.3, 0, 0] }",
              "{ kind = \"linear\", n0 = 1.5, slope = [0, 0, 5] }"}) {
            const ObjectSamples s = sampled(blockOf(index), voxel);
            EXPECT_GT(least(s), -0.5f) << index << ", voxels of " << voxel;
            EXPECT_EQ(s.fit, SplineFit::Through);
        }
    // A block by itself, without a surface, goes the same way.
    const Scene alone = sceneWith(medium(
        "core",
        "{ kind = \"linear\", n0 = 1.5, slope = [6.3, 0, 0], min = [-0.35, -0.35, -0.4], max = [0.35, 0.35, 0] }"));
    EXPECT_GT(least(sampled(alone, 0.05)), -0.5f);
}

TEST(EnclosedBodies, SaysWhereAnIndexFallsToNothing) {
    const Scene scene = blockOf("{ kind = \"linear\", n0 = 1.5, slope = [7, 0, 0] }");
    try {
        sampled(scene, 0.0125);
        FAIL();
    } catch (const Error& error) {
        const std::string what = error.what();
        for (const char* part : {"'core'", "(-0.35,", "above 0"}) EXPECT_NE(what.find(part), std::string::npos) << what;
        EXPECT_EQ(error.where(), "s.toml:11:1");
    }
}

TEST(EnclosedBodies, ABallHasTheShapeOfItsSurface) {
    const Scene scene =
        sceneWith(medium("core", "{ kind = \"fish_eye\", center = [0, 0, -0.4], n0 = 1.6, scale = 1 }") +
                  ball("ball", "core", 0.3));
    const std::vector<GradedObject> bodies = bodiesOf(scene);
    ASSERT_EQ(bodies.size(), 1U);
    const GradedIndex& index = *bodies.front().index.front();
    ASSERT_TRUE(index.bounds());
    EXPECT_LT(glm::distance(index.bounds()->min, {-0.3, -0.3, -0.7}), 1e-12);
    EXPECT_TRUE(index.contains({0.17, 0.17, -0.4 + 0.17}));
    EXPECT_FALSE(index.contains({0.175, 0.175, -0.4 - 0.175}));
    EXPECT_EQ(index.halfSquareAt({0, 0, 0}), 0.5);
    const double n = 1.6 / 1.04;
    EXPECT_NEAR(index.halfSquareAt({0.2, 0, -0.4}), n * n / 2, 1e-12);
    const ObjectSamples s = sampled(scene, 0.0125);
    EXPECT_FALSE(s.sharp_sides);
    EXPECT_FALSE(s.faces.empty()) << "it has a face all around";
}

// The mesh of a ball, against its closed form.
TEST(EnclosedBodies, AMeshKnowsItsInside) {
    Scene scene =
        sceneWith(medium("core", "{ kind = \"linear\", n0 = 1.5, slope = [0, 0, 0] }") + ball("ball", "core", 0.3));
    ASSERT_TRUE(scene.surfaces.front().mesh);
    scene.surfaces.front().sphere.reset();
    const auto bodies = bodiesOf(scene);
    const GradedIndex& index = *bodies.front().index.front();
    int in = 0, wrong = 0;
    constexpr int kSide = 40;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
        const glm::dvec3 at(i % kSide, i / kSide % kSide, i / (kSide * kSide));
        const glm::dvec3 p = glm::dvec3(0, 0, -0.4) + 0.32 * (2.0 * (at + 0.5) / double(kSide) - 1.0);
        const double r = glm::distance(p, {0, 0, -0.4});
        const bool contained = index.contains(p);
        in += contained;
        if (std::fabs(r - 0.3) > 0.003) wrong += contained != (r < 0.3);
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_NEAR(in * std::pow(0.64 / kSide, 3), 4 * M_PI / 3 * 0.027, 0.01 * 4 * M_PI / 3 * 0.027);
}

// A bubble of air, and a core of another index, are holes in what is around them.
TEST(EnclosedBodies, WhatLiesInsideIsCutOut) {
    const std::string outer = medium("shell", "{ kind = \"linear\", n0 = 1.5, slope = [0, 0, 0.1] }"),
                      inner = medium("core", "{ kind = \"linear\", n0 = 1.7, slope = [0, 0, 0.1] }");
    const Scene nested = sceneWith(outer + inner + ball("shell", "shell", 0.3) + ball("core", "core", 0.15));
    const auto bodies = bodiesOf(nested);
    ASSERT_EQ(bodies.size(), 2U);
    const auto holds = [&](int body, const glm::dvec3& p) {
        return bodies[std::size_t(body)].index.front()->contains(p);
    };
    EXPECT_FALSE(holds(0, {0, 0, -0.4}));
    EXPECT_TRUE(holds(1, {0, 0, -0.4}));
    EXPECT_TRUE(holds(0, {0.2, 0, -0.4}));
    EXPECT_FALSE(holds(1, {0.2, 0, -0.4}));
    const Scene bubble = sceneWith(outer + ball("shell", "shell", 0.3) + ball("bubble", "air", 0.15));
    const auto shell = bodiesOf(bubble);
    EXPECT_FALSE(shell.front().index.front()->contains({0, 0, -0.4}));
    EXPECT_TRUE(shell.front().index.front()->contains({0, 0, -0.6}));
}

// Water ends at its waves, and with the domain; what stands in air stays as it is.
TEST(EnclosedBodies, WaterEndsAtItsWaves) {
    const Scene scene =
        sceneWith("[[surface]]\nkind = \"height_field\"\nwaves = [{ amplitude = 0.02, wavelength = 0.5 }]\n" +
                  medium("water", "{ kind = \"salt\", level = -0.4, thickness = 0.05 }") +
                  medium("lens", "{ kind = \"luneburg\", center = [0, 0, 0.5], radius = 0.1 }"));
    const auto bodies = bodiesOf(scene);
    ASSERT_EQ(bodies.size(), 2U);
    EXPECT_EQ(bodies[0].name, "water");
    EXPECT_TRUE(bodies[0].index.front()->contains({0, 0, -0.03}));
    EXPECT_FALSE(bodies[0].index.front()->contains({0, 0, 0.03}));
    EXPECT_TRUE(bodies[1].index.front()->contains({0, 0, 0.5}));
    const ObjectSamples s = sampled(scene, 0.0125);
    EXPECT_FALSE(s.sharp_sides);
    // Around the object there is nothing.
    EXPECT_EQ(s.spline.front().front(), 0);
    EXPECT_EQ(s.spline.front().back(), 0);
    EXPECT_GT(*std::max_element(s.spline.front().begin(), s.spline.front().end()), 0.38f);
}

}  // namespace
}  // namespace photic
