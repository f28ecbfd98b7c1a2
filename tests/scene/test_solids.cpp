// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <numbers>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

Solid solid(TriangleMesh mesh, double ior, const glm::dvec3& absorption = glm::dvec3(0)) {
    return {"body", "test", std::move(mesh), ior, absorption};
}

/// The integral of n - 1.
double excess(const SolidVolume& volume) {
    double sum = 0;
    for (const float n : volume.index) sum += double(n) - 1;
    return sum * std::pow(volume.voxel_size, 3);
}

/// n at a point; 1 beside the grid.
float at(const SolidVolume& volume, const glm::dvec3& world) {
    const glm::ivec3 p = glm::ivec3(glm::floor(world / volume.voxel_size)) - volume.min;
    for (int axis = 0; axis < 3; ++axis)
        if (p[axis] < 0 || p[axis] >= volume.size[axis]) return 1;
    return volume.index[volume.flat(p.x, p.y, p.z)];
}

TEST(Solids, VoxelsHoldTheMeanOverTheirVolume) {
    Monitor monitor;
    // A box that ends within voxels: exact along z, to an eighth of a voxel across.
    const SolidVolume box =
        voxelise({solid(boxMesh({-0.25, -0.25, -0.317}, {0.25, 0.25, 0.243}), 1.5)}, 0.02, 2, monitor);
    EXPECT_NEAR(excess(box), 0.5 * 0.5 * 0.5 * 0.56, 1e-6);
    EXPECT_FLOAT_EQ(at(box, {0.001, 0.001, 0.001}), 1.5f);
    EXPECT_NEAR(at(box, {0.001, 0.001, 0.241}), 1 + 0.5 * 0.15, 1e-5);
    EXPECT_EQ(at(box, {0.001, 0.001, 0.27}), 1.0f);
    const SolidVolume ball = voxelise({solid(sphereMesh({0.01, 0.02, 0.03}, 0.3, 128), 1.4)}, 0.025, 2, monitor);
    EXPECT_NEAR(excess(ball), 0.4 * 4 / 3 * std::numbers::pi * 0.027, 2e-3 * 0.045);
}

TEST(Solids, TheLastOfSeveralIsThere) {
    Monitor monitor;
    const SolidVolume volume = voxelise({solid(boxMesh({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}), 1.5, {1, 2, 3}),
                                         solid(sphereMesh(glm::dvec3(0), 0.1, 64), 1.0)},
                                        0.02, 1, monitor);
    EXPECT_FLOAT_EQ(at(volume, {0.001, 0.001, 0.001}), 1.0f);
    EXPECT_FLOAT_EQ(at(volume, {0.15, 0.15, 0.15}), 1.5f);
    ASSERT_EQ(volume.absorption.size(), 3 * volume.index.size());
    const auto absorption = [&](const glm::dvec3& world) {
        const glm::ivec3 p = glm::ivec3(glm::floor(world / volume.voxel_size)) - volume.min;
        return volume.absorption[3 * volume.flat(p.x, p.y, p.z) + 1];
    };
    EXPECT_EQ(absorption({0.001, 0.001, 0.001}), 0.0f);
    EXPECT_EQ(absorption({0.15, 0.15, 0.15}), 2.0f);
}

TEST(Solids, PaintIsThatOfTheBodyThatFillsTheVoxel) {
    Monitor monitor;
    std::vector<Solid> bodies{solid(boxMesh({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}), 1.5),
                              solid(boxMesh({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.107}), 1.6)};
    EXPECT_TRUE(voxelise(bodies, 0.02, 1, monitor).albedo.empty());
    bodies[1].albedo = {0.2, 0.4, 0.8};
    const SolidVolume volume = voxelise(bodies, 0.02, 1, monitor);
    const auto blue = [&](const glm::dvec3& world) {
        const glm::ivec3 p = glm::ivec3(glm::floor(world / volume.voxel_size)) - volume.min;
        return volume.albedo[3 * volume.flat(p.x, p.y, p.z) + 2];
    };
    EXPECT_EQ(blue({0.001, 0.001, 0.001}), 0.8f);
    EXPECT_EQ(blue({0.001, 0.001, 0.103}), 0.8f) << "a third of the voxel is enough";
    EXPECT_EQ(blue({0.001, 0.001, 0.15}), 0.0f);
}

TEST(Solids, ProfilesTurnAboutTheAxis) {
    Monitor monitor;
    // A hollow cylinder, whichever way its outline goes.
    const std::vector<glm::dvec2> outline{{0, -0.2}, {0.2, -0.2}, {0.2, 0.2}, {0.1, 0.2}, {0.1, -0.1}, {0, -0.1}};
    const double volume = std::numbers::pi * (0.04 * 0.4 - 0.01 * 0.3);
    for (const std::vector<glm::dvec2>& profile :
         {outline, std::vector<glm::dvec2>(outline.rbegin(), outline.rend())}) {
        const SolidVolume cup = voxelise({solid(revolve(profile), 2)}, 0.01, 1, monitor);
        EXPECT_NEAR(excess(cup), volume, 2e-3 * volume);
        EXPECT_EQ(at(cup, {0.001, 0.001, 0.1}), 1.0f);
        EXPECT_EQ(at(cup, {0.001, 0.001, -0.15}), 2.0f);
    }
}

TEST(Solids, SmoothingSpreadsFacesAndKeepsWhatIsThere) {
    Monitor monitor;
    SolidVolume volume = voxelise({solid(boxMesh({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}), 1.5)}, 0.02, 10, monitor);
    const double before = excess(volume);
    const SmoothingEffect effect = smooth(volume, 2);
    EXPECT_NEAR(excess(volume), before, 1e-5 * before);
    // Half a voxel from a flat face: the share of the jump that a normal distribution has there.
    const auto normal = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
    EXPECT_NEAR(at(volume, {0.001, 0.001, 0.201}), 1 + 0.5 * normal(-0.25), 2e-3);
    EXPECT_NEAR(at(volume, {0.001, 0.001, 0.181}), 1 + 0.5 * normal(0.25), 2e-3);
    EXPECT_GT(effect.largest, 0.2);
    EXPECT_LT(effect.largest, 0.5);
    EXPECT_GT(effect.mean, 0);
    EXPECT_LT(effect.mean, effect.largest);
    // Measured: where n has 90 % and 10 % of its jump.
    double from = 0, to = 0;
    for (double z = 0.05; z < 0.4; z += 0.02) {
        const double here = double(at(volume, {0.001, 0.001, z + 0.001}) - 1) / 0.5,
                     next = double(at(volume, {0.001, 0.001, z + 0.021}) - 1) / 0.5;
        const auto cross = [&](double level) { return z + 0.02 * (here - level) / (here - next); };
        if (here >= 0.9 && next < 0.9) from = cross(0.9);
        if (here >= 0.1 && next < 0.1) to = cross(0.1);
    }
    EXPECT_NEAR((to - from) / 0.02, effect.face_voxels, 0.15);
}

TEST(Solids, TooManyVoxelsAreRefused) {
    Monitor monitor;
    EXPECT_THROW(voxelise({solid(boxMesh(glm::dvec3(-1), glm::dvec3(1)), 1.5)}, 1e-3, 1, monitor), Error);
}

}  // namespace
}  // namespace photic
