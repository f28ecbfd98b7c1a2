// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
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

TEST(Solids, AbsorptionIsPaintedAlongTheHeight) {
    Monitor monitor;
    Solid body = solid(boxMesh({-0.1, -0.1, 0}, {0.1, 0.1, 0.4}), 1.5);
    body.pattern.painted = {{0.1, {2, 4, 8}}, {0.3, {0, 0, 16}}};
    // It stands upside down, twice as high, a metre above the ground: the body's own heights are painted.
    body.placement.position = {0, 0, 1}, body.placement.scale = {1, 1, 2};
    body.placement.rotation = glm::dmat3({1, 0, 0}, {0, -1, 0}, {0, 0, -1});
    place(body.mesh, body.placement);
    EXPECT_EQ(body.absorptionAt({0, 0, 0.95}), glm::dvec3(2, 4, 8)) << "below the lowest height as there";
    EXPECT_LT(glm::distance(body.absorptionAt({0, 0, 0.6}), {1, 2, 12}), 1e-12);
    EXPECT_EQ(body.absorptionAt({0, 0, 0.2}), glm::dvec3(0, 0, 16));
    const SolidVolume volume = voxelise({body}, 0.02, 1, monitor);
    const glm::ivec3 p = glm::ivec3(glm::floor(glm::dvec3(0.01, 0.01, 0.59) / 0.02)) - volume.min;
    ASSERT_EQ(volume.absorption.size(), 3 * volume.index.size());
    EXPECT_NEAR(double(volume.absorption[3 * volume.flat(p.x, p.y, p.z) + 2]), body.absorptionAt({0, 0, 0.59}).z, 1e-5);
}

TEST(Solids, NoiseMakesAbsorptionMoreAndLess) {
    Solid body = solid(sphereMesh(glm::dvec3(0), 0.1, 16), 1.5, {10, 20, 0});
    body.pattern.noise = 0.6, body.pattern.noise_size = 0.05;
    double least = 1e300, most = 0, sum = 0;
    glm::dvec3 before(0);
    double jump = 0;
    constexpr int kPlaces = 20000;
    for (int i = 0; i < kPlaces; ++i) {
        const glm::dvec3 a = body.absorptionAt(glm::dvec3(0.0005 * i, 0.31, -0.17));
        EXPECT_NEAR(a.y, 2 * a.x, 1e-12);
        EXPECT_EQ(a.z, 0);
        least = std::min(least, a.x), most = std::max(most, a.x), sum += a.x;
        if (i > 0) jump = std::max(jump, std::fabs(a.x - before.x));
        before = a;
    }
    EXPECT_GE(least, 4);
    EXPECT_LE(most, 16);
    EXPECT_LT(least, 8);
    EXPECT_GT(most, 12);
    EXPECT_NEAR(sum / kPlaces, 10, 0.5);
    EXPECT_LT(jump, 1) << "it is smooth";
    const glm::dvec3 here = body.absorptionAt({0.01, 0.02, 0.03});
    body.pattern.seed = 2;
    EXPECT_NE(body.absorptionAt({0.01, 0.02, 0.03}), here);
}

TEST(Solids, ATableSaysHowAbsorptionVaries) {
    Monitor monitor;
    const std::string
        path = testing::TempDir() + "/photic_painted_bodies.toml",
        body = "voxel_size = 0.01\n[[solid]]\nprofile = [[0, 0], [0.1, 0], [0.1, 0.2], [0, 0.2]]\nior = 1.4\n";
    const auto load = [&](const std::string& more) {
        std::ofstream(path) << body << more;
        return loadSolids(path, 1.5, glm::dvec3(0), monitor);
    };
    const SolidsFile file = load("painted = [[0, 0, 0, 0], [0.1, 6, 55, 50]]\nnoise = { amount = 0.3, size = 0.02 }\n");
    ASSERT_EQ(file.solids.size(), 1U);
    EXPECT_TRUE(file.solids[0].absorbs());
    EXPECT_EQ(file.solids[0].pattern.painted[1].second, glm::dvec3(6, 55, 50));
    EXPECT_EQ(file.solids[0].pattern.noise, 0.3);
    for (const char* wrong :
         {"painted = 3\n", "painted = []\n", "painted = [[0, 1, 2]]\n", "painted = [[0, 1, 2, -3]]\n",
          "painted = [[0, 1, 1, nan]]\n", "painted = [[0, nan, 1, 1]]\n", "painted = [[nan, 1, 1, 1]]\n",
          "painted = [[0, 1, 1, inf]]\n", "noise = { amount = 0.3, size = 0.02 }\n",
          "painted = [[0.1, 1, 1, 1], [0.1, 2, 2, 2]]\n", "noise = { amount = 0.5 }\n",
          "noise = { amount = 2, size = 0.1 }\n", "noise = { size = 0 }\n"})
        EXPECT_THROW(load(wrong), Error) << wrong;
    std::filesystem::remove(path);
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
