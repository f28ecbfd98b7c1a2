// SPDX-License-Identifier: Apache-2.0
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <random>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

class Waves final : public HeightField {
public:
    explicit Waves(double sideways = 0) : sideways_(sideways) {}
    static double height(double u, double v) { return 0.05 * std::sin(9 * u) * std::cos(7 * v); }
    SurfacePoint at(glm::dvec2 uv) const override {
        return {{uv.x + sideways_ * std::cos(9 * uv.x), uv.y, height(uv.x, uv.y)}, {0, 0, 1}};
    }
    double minZ() const override { return -0.05; }
    double maxZ() const override { return 0.05; }
    double maxDisplacement() const override { return sideways_; }
    double featureSize() const override { return 0.05; }

private:
    double sideways_;
};

Scene poolScene() {
    Scene scene;
    scene.file = "pool.toml";
    scene.domain = {{-1, -1, -1}, {1, 1, 0.125}, 1.0 / 64, ShearMode::None, {}, 0};
    Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.433, 0.25, -0.866));
    scene.lights.push_back(sun);
    Surface water;
    water.height_field = std::make_shared<Waves>();
    water.size = {2, 2};
    scene.surfaces.push_back(water);
    return scene;
}

Object plane(const glm::dvec3& point, const glm::dvec3& normal) {
    Object o;
    o.shape = Plane{point, glm::normalize(normal)};
    return o;
}

std::string inputError(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::Input);
        return e.what();
    }
    return "";
}

TEST(SceneFrame, MultiplesOfTheVoxelGainNoLayer) {
    Scene scene = poolScene();
    const GridFrame frame = sceneFrame(scene);
    EXPECT_EQ(frame.min, glm::ivec3(-64));
    EXPECT_EQ(frame.max, glm::ivec3(63, 63, 7));
    EXPECT_TRUE(frame.axisAligned());
    EXPECT_EQ(frame.worldFromIndex({0, 0, 0}), glm::dvec3(1.0 / 128));

    // 0.1 / 3 is no exact multiple in binary; it must not gain one either, and one that is really cut must.
    scene.domain.min = glm::dvec3(-0.3), scene.domain.max = glm::dvec3(0.3), scene.domain.voxel_size = 0.1 / 3;
    EXPECT_EQ(sceneFrame(scene).size(), glm::ivec3(18));
    scene.domain.max.x = 0.3001;
    EXPECT_EQ(sceneFrame(scene).size(), glm::ivec3(19, 18, 18));
    scene.domain.layer_height = 0.1;
    EXPECT_EQ(sceneFrame(scene).size().z, 6);
}

// The normals of a closed mesh cancel but for rounding, which is no direction: its grid leaned any way, and another
// when all was moved.
TEST(SceneFrame, BesideAClosedBodyTheGridLeansWithTheLightItself) {
    for (const glm::dvec3& centre : {glm::dvec3(0.1, -0.2, -0.5), glm::dvec3(300.1, -70.2, 12.5)}) {
        Scene scene = poolScene();
        scene.surfaces[0].height_field = nullptr;
        scene.surfaces[0].mesh = std::make_shared<const TriangleMesh>(sphereMesh(centre, 0.2, 16));
        scene.domain.shear_mode = ShearMode::Light, scene.domain.layer_height = 1.0 / 16;
        const glm::dvec3 d = scene.lights[0].direction, layer = sceneFrame(scene).worldFromIndex()[2];
        EXPECT_NEAR(layer.x, d.x / d.z / 16, 1e-12);
        EXPECT_NEAR(layer.y, d.y / d.z / 16, 1e-12);
    }
}

TEST(SceneFrame, ShearedGridCoversTheDomainAndLeansWithTheRefractedLight) {
    Scene scene = poolScene();
    scene.domain.shear_mode = ShearMode::Light;
    scene.domain.layer_height = 1.0 / 16;
    const GridFrame frame = sceneFrame(scene);
    // Snell: the horizontal part shrinks by the index.
    const glm::dvec3 d = scene.lights[0].direction;
    const glm::dvec2 horizontal = glm::dvec2(d) / 1.333;
    const glm::dvec2 shear = horizontal / -std::sqrt(1 - glm::dot(horizontal, horizontal));
    EXPECT_NEAR(frame.worldFromIndex()[2].x, shear.x / 16, 1e-12);
    EXPECT_NEAR(frame.worldFromIndex()[2].y, shear.y / 16, 1e-12);
    EXPECT_EQ(frame.worldFromIndex()[2].z, 1.0 / 16);
    EXPECT_FALSE(frame.axisAligned());
    EXPECT_NEAR(frame.voxelVolume(), 1.0 / 64 / 64 / 16, 1e-15);

    // Every point of the domain lies in a voxel of the frame, and no side of the frame could be one voxel nearer.
    glm::dvec3 low(1e9), high(-1e9);
    for (int c = 0; c < 8; ++c) {
        const auto p = frame.indexFromWorld({c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 0.125 : -1.0});
        low = glm::min(low, p), high = glm::max(high, p);
    }
    for (int a = 0; a < 3; ++a) {
        EXPECT_GE(low[a], frame.min[a] - 0.5 - 1e-5);
        EXPECT_LT(low[a], frame.min[a] + 0.5);
        EXPECT_LE(high[a], frame.max[a] + 0.5 + 1e-5);
        EXPECT_GT(high[a], frame.max[a] - 0.5);
    }

    // A mirror sends it the other way up.
    scene.surfaces[0].event = SurfaceEvent::Reflect;
    EXPECT_NEAR(sceneFrame(scene).worldFromIndex()[2].x * 16, d.x / -d.z, 1e-12);
}

TEST(SceneFrame, BadGridsAreRefusedWithARemedyThatWorks) {
    Scene scene = poolScene();
    scene.domain.voxel_size = 1e-4;
    const std::string message = inputError([&] { sceneFrame(scene); });
    const auto at = message.find("voxel_size = ");
    ASSERT_NE(at, std::string::npos) << message;
    scene.domain.voxel_size = std::stod(message.substr(at + 13));
    EXPECT_NO_THROW(sceneFrame(scene));
    EXPECT_LT(scene.domain.voxel_size, 5e-4);

    for (const double h : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        scene.domain.voxel_size = h;
        EXPECT_NE(inputError([&] { sceneFrame(scene); }).find("positive"), std::string::npos);
    }
    scene = poolScene();
    scene.domain.max.y = -1;
    EXPECT_NE(inputError([&] { sceneFrame(scene); }).find("empty along y"), std::string::npos);
    scene = poolScene();
    scene.domain.min.x += 1e9, scene.domain.max.x += 1e9;
    EXPECT_NE(inputError([&] { sceneFrame(scene); }).find("origin"), std::string::npos);
    scene = poolScene();
    scene.domain.shear_mode = ShearMode::Light, scene.lights.clear();
    EXPECT_NE(inputError([&] { sceneFrame(scene); }).find("[[light]]"), std::string::npos);
}

TEST(SceneNeededVoxels, AFloorGetsExactlyTwiceTheBand) {
    Scene scene = poolScene();
    scene.bake.where = Where::Receivers;
    scene.objects.push_back(plane({0, 0, -0.5}, {0, 0, 1}));
    Monitor monitor;
    for (const int band : {1, 2, 5}) {
        scene.bake.band = band;
        const GridFrame frame = sceneFrame(scene);
        const auto needed = sceneNeededVoxels(scene, frame, monitor);
        EXPECT_EQ(needed.count(), 128 * 128 * 2 * band);
        // The floor lies between two layers.
        const glm::dvec3 above = frame.indexFromWorld({0.1, 0.2, -0.5 + 0.5 * scene.domain.voxel_size});
        const glm::ivec3 first(glm::round(above));
        EXPECT_NEAR(above.z, first.z, 1e-9);
        EXPECT_TRUE(needed.contains(first + glm::ivec3(0, 0, band - 1)));
        EXPECT_FALSE(needed.contains(first + glm::ivec3(0, 0, band)));
        EXPECT_TRUE(needed.contains(first - glm::ivec3(0, 0, band)));
        EXPECT_FALSE(needed.contains(first - glm::ivec3(0, 0, band + 1)));
    }
}

TEST(SceneNeededVoxels, AThinBandFillsOneRowOfLeavesAndItsVoxelsStayInPlace) {
    Scene scene = poolScene();
    const GridFrame everything = sceneFrame(scene);
    scene.bake.where = Where::Receivers, scene.bake.band = 2;
    Monitor monitor;
    for (const double depth : {-0.5, -0.47, -0.61}) {
        scene.objects = {plane({0, 0, depth}, {0, 0, 1})};
        const GridFrame frame = sceneFrame(scene);
        EXPECT_EQ(sceneNeededVoxels(scene, frame, monitor).leafCount(), 16 * 16);
        const glm::dvec3 moved = frame.worldFromIndex(frame.min) - everything.worldFromIndex(everything.min);
        EXPECT_LT(glm::length(moved), 1e-12);
        EXPECT_EQ(frame.size(), everything.size());
    }
}

TEST(SceneNeededVoxels, TiltedPlanesOnShearedGridsAgreeWithBruteForce) {
    Scene scene = poolScene();
    scene.domain.voxel_size = 1.0 / 16;
    scene.domain.shear_mode = ShearMode::Explicit, scene.domain.shear = {0.4, -0.3};
    scene.bake.where = Where::Receivers;
    const GridFrame frame = sceneFrame(scene);
    Monitor monitor;
    for (const auto& normal :
         {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0.3, -0.5, 0.8), glm::dvec3(1, 0.2, 0.01)}) {
        const glm::dvec3 n = glm::normalize(normal), point(0.11, 0.07, -0.4);
        scene.objects = {plane(point, n)};
        const auto needed = sceneNeededVoxels(scene, frame, monitor);
        std::int64_t count = 0;
        const glm::dvec3 m = frame.indexNormal(n);
        for (int x = frame.min.x; x <= frame.max.x; ++x)
            for (int y = frame.min.y; y <= frame.max.y; ++y)
                for (int z = frame.min.z; z <= frame.max.z; ++z) {
                    const double distance = std::fabs(glm::dot(n, frame.worldFromIndex({x, y, z}) - point)) /
                                            (std::fabs(m.x) + std::fabs(m.y) + std::fabs(m.z));
                    const bool expected = distance <= 2;
                    count += expected;
                    ASSERT_EQ(needed.contains({x, y, z}), expected) << distance;
                }
        EXPECT_GT(count, 1000);
        EXPECT_EQ(needed.count(), count);
    }
}

TEST(SceneNeededVoxels, MeshesAgreeWithBruteForce) {
    Scene scene = poolScene();
    scene.domain.voxel_size = 1.0 / 16;
    scene.bake.where = Where::Receivers;
    auto mesh = std::make_shared<TriangleMesh>();
    mesh->positions = {{-0.4, -0.3, -0.8}, {0.5, -0.1, -0.3}, {0.1, 0.6, -0.55}, {0.11, 0.61, -0.55}, {1.4, 0.2, -0.2}};
    mesh->triangles = {{0, 1, 2}, {1, 3, 4}, {2, 2, 3}};  // one is degenerate
    Object rock;
    rock.shape = std::shared_ptr<const TriangleMesh>(mesh);
    rock.role = Role::Movable;
    scene.objects.push_back(rock);
    const GridFrame frame = sceneFrame(scene);
    Monitor monitor;
    const auto needed = sceneNeededVoxels(scene, frame, monitor);

    // Dense points of the triangles: a voxel near one is needed; a needed one has some near, to the points' spacing.
    auto near = NeededVoxels::none(frame), wide = NeededVoxels::none(frame);
    constexpr int kSteps = 300;
    for (const auto& t : mesh->triangles)
        for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; i + j <= kSteps; ++j) {
                const glm::dvec3 p = frame.indexFromWorld(
                    mesh->positions[t[0]] + (mesh->positions[t[1]] - mesh->positions[t[0]]) * (double(i) / kSteps) +
                    (mesh->positions[t[2]] - mesh->positions[t[0]]) * (double(j) / kSteps));
                for (auto [set, band] : {std::pair{&near, 2.0}, {&wide, 2.12}})
                    for (int x = int(std::ceil(p.x - band)); x <= int(std::floor(p.x + band)); ++x)
                        for (int y = int(std::ceil(p.y - band)); y <= int(std::floor(p.y + band)); ++y)
                            set->addColumn(x, y, int(std::ceil(p.z - band)), int(std::floor(p.z + band)));
            }
    near.finish(), wide.finish();
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                if (near.contains({x, y, z})) {
                    ASSERT_TRUE(needed.contains({x, y, z})) << x << ' ' << y << ' ' << z;
                }
                if (needed.contains({x, y, z})) {
                    ASSERT_TRUE(wide.contains({x, y, z})) << x << ' ' << y << ' ' << z;
                }
            }
    EXPECT_GT(near.count(), 500);
}

TEST(SceneNeededVoxels, MediaReachUpToTheSurfaceAndNotMuchFurther) {
    for (const double sideways : {0.0, 0.03})
        for (const glm::dvec2 shear : {glm::dvec2(0), glm::dvec2(0.35, -0.2)}) {
            Scene scene = poolScene();
            scene.surfaces[0].height_field = std::make_shared<Waves>(sideways);
            scene.domain.shear_mode = ShearMode::Explicit, scene.domain.shear = shear;
            scene.bake.where = Where::Media;
            const GridFrame frame = sceneFrame(scene);
            Monitor monitor;
            const auto needed = sceneNeededVoxels(scene, frame, monitor);
            // Random points below the surface lie in needed voxels; points well above do not.
            std::mt19937 random(3);
            std::uniform_real_distribution<double> unit(-1, 1);
            int above = 0;
            for (int i = 0; i < 40000; ++i) {
                const double u = unit(random), v = unit(random), z = -0.44 + 0.56 * unit(random);
                const glm::dvec3 top = scene.surfaces[0].height_field->at({u, v}).position;
                if (std::fabs(top.x) >= 1) continue;
                const glm::dvec3 p(top.x, top.y, z);
                const glm::ivec3 voxel(glm::floor(frame.indexFromWorld(p) + 0.5));
                if (z < top.z) {
                    ASSERT_TRUE(needed.contains(voxel)) << z << ' ' << top.z;
                }
                // Three and a half voxels up the steepest slope (0.45), or the sideways surface's dilation.
                if (z > top.z + 4.0 / 64) {
                    ASSERT_FALSE(needed.contains(voxel)) << z << ' ' << top.z;
                    ++above;
                }
            }
            EXPECT_GT(above, 1000);
            EXPECT_GT(needed.count(), 128 * 128 * 60);
            EXPECT_LT(needed.count(), 128 * 128 * 70);
        }
}

TEST(SceneNeededVoxels, NothingToLightIsAnError) {
    Scene scene = poolScene();
    Monitor monitor;
    const GridFrame frame = sceneFrame(scene);
    scene.bake.where = Where::Receivers;
    EXPECT_NE(inputError([&] { sceneNeededVoxels(scene, frame, monitor); }).find("[[object]]"), std::string::npos);
    scene.bake.where = Where::Media;
    scene.surfaces.clear();
    EXPECT_NE(inputError([&] { sceneNeededVoxels(scene, frame, monitor); }).find("[[surface]]"), std::string::npos);
    scene.bake.where = Where::Everywhere;
    EXPECT_TRUE(sceneNeededVoxels(scene, frame, monitor).isEverything());
}

TEST(SceneNeededVoxels, AThinBandIsQuick) {
    Scene scene = poolScene();
    scene.domain = {{-1, -1, -1}, {1, 1, 0}, 1.0 / 128, ShearMode::None, {}, 0};
    scene.bake.where = Where::Receivers;
    scene.objects.push_back(plane({0, 0, -0.5}, {0, 0, 1}));
    const GridFrame frame = sceneFrame(scene);
    ASSERT_EQ(frame.size(), glm::ivec3(256, 256, 128));
    Monitor monitor;
    double best = 1;
    for (int run = 0; run < 5; ++run) {
        const auto start = std::chrono::steady_clock::now();
        const auto needed = sceneNeededVoxels(scene, frame, monitor);
        best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        ASSERT_EQ(needed.count(), 256 * 256 * 4);
    }
    RecordProperty("seconds", std::to_string(best));
    EXPECT_LT(best, 0.1);  // 1 ms on an idle core; the limit allows for sanitizers
}

}  // namespace
}  // namespace photic
