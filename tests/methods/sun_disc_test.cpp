// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/sun_disc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>

#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "tests/methods/glass_scene.h"
#include "tests/methods/photon_scenes.h"

namespace photic {
namespace {

/// Water over 1 m of voxels, a sun of 0.53 degrees: its disc has a radius of 3.5 mm at the bottom.
bool blurs(Scene scene, double voxel_size) {
    scene.lights[0].angular_diameter_deg = 0.53;
    const auto count = static_cast<int>(1 / voxel_size);
    return blurServes(scene, scene.lights[0],
                      test_scenes::boxFrame({-0.5, -0.5, -1}, glm::ivec3(count), glm::dvec3(voxel_size)));
}

Object wall(Role role) {
    return test_scenes::meshObject(test_scenes::rectangle({0, 0, -1}, {0.5, 0, 0}, {0, 0, 0.5}), role);
}

TEST(SunDisc, BlursWithoutSilhouettesWhateverItsReach) {
    const Scene water = test_scenes::waterScene(0.3);
    EXPECT_TRUE(blurs(water, 0.02));
    EXPECT_TRUE(blurs(water, 0.001));
}

TEST(SunDisc, BlursOverShadowsUpToAVoxel) {
    Scene scene = test_scenes::waterScene(0.3);
    scene.objects = {wall(Role::Receiver)};
    EXPECT_TRUE(blurs(scene, 0.02));
    EXPECT_TRUE(blurs(scene, 1.0 / 250));
    EXPECT_FALSE(blurs(scene, 1.0 / 350));
    EXPECT_FALSE(blurs(scene, 0.001));
    scene.objects = {wall(Role::Movable)};  // casts none
    EXPECT_TRUE(blurs(scene, 0.001));
}

TEST(SunDisc, SamplesWhatOneBlurCannotShow) {
    Scene both = test_scenes::waterScene(0.3);
    both.surfaces[0].event = SurfaceEvent::Both;
    EXPECT_FALSE(blurs(both, 0.02));
    Scene two = test_scenes::waterScene(0.3);
    two.surfaces.push_back(two.surfaces[0]);
    EXPECT_FALSE(blurs(two, 0.02));
    Scene mesh = test_scenes::waterScene(0.3);
    mesh.surfaces[0].height_field = nullptr;
    mesh.surfaces[0].mesh = test_scenes::rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    EXPECT_FALSE(blurs(mesh, 0.02));
}

/// What a bake by beams says of its ledgers.
BakeReport bakeOf(const Scene& scene, const GivenOptions& options = {}, const std::string& method = "beams") {
    Monitor monitor;
    const GridFrame frame = test_scenes::boxFrame({-0.5, -0.5, -1}, glm::ivec3(20), glm::dvec3(0.05));
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
    return findMethod(method)->bake(scene, needed, options, monitor).report;
}

TEST(SunDisc, LightsWithoutADiscMayStandBeforeAndBehindThoseWithOne) {
    Scene scene = test_scenes::waterScene(0.3);
    for (const double disc : {0.5, 0.0, 2.0}) {
        scene.lights.push_back(scene.lights[0]);
        scene.lights.back().angular_diameter_deg = disc;
    }
    Scene turned = scene;
    std::reverse(turned.lights.begin(), turned.lights.end());
    const BakeReport one = bakeOf(scene), other = bakeOf(turned);
    EXPECT_LT(one.path.imbalance(), 1e-6);
    EXPECT_LT(other.path.imbalance(), 1e-6);
    EXPECT_NEAR(one.path.deposited, other.path.deposited, 1e-6 * one.path.deposited);
}

// Under flat water all is lit alike up to a wall, whatever the disc: its blur must not mix in the dark behind the wall.
// Four voxels wide at the bottom, the disc took a fifth of the light there once.
TEST(SunDisc, ItsBlurLeavesAWallAsBrightAsTheWaterBeforeIt) {
    Scene scene = test_scenes::waterScene(0.3);
    scene.lights[0].angular_diameter_deg = 8;
    scene.objects = {test_scenes::planeObject({0.2, 0, 0}, {-1, 0, 0}),
                     test_scenes::planeObject({0, 0.3, 0}, {0, -1, 0})};
    Monitor monitor;
    const GridFrame frame = test_scenes::boxFrame({-0.5, -0.5, -1}, glm::ivec3(64), glm::dvec3(1.0 / 64));
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
    const BakeResult baked =
        findMethod("beams")->bake(scene, needed, {{"disc", {std::string("blur"), "test"}}}, monitor);
    const glm::ivec3 corner(glm::floor(frame.indexFromWorld({0.2, 0.3, -0.5}) + 0.5));
    const int east = corner.x, north = corner.y;  // voxels that the walls cut
    for (const int k : {2, 20, 40}) {
        const double open = baked.field.irradiance({20, 20, k});
        EXPECT_GT(open, 0.5);
        for (const int behind : {-1, 0, 1}) {
            EXPECT_NEAR(baked.field.irradiance({east + behind, 20, k}) / open, 1, 2e-3) << k << " " << behind;
            EXPECT_NEAR(baked.field.irradiance({20, north + behind, k}) / open, 1, 2e-3) << k << " " << behind;
        }
    }
    EXPECT_LT(baked.report.path.imbalance(), 1e-6);
}

/// Planes round the frame's four sides.
void addWalls(Scene& scene) {
    for (const double side : {-1.0, 1.0}) {
        scene.objects.push_back(test_scenes::planeObject({0.5 * side, 0, 0}, {-side, 0, 0}));
        scene.objects.push_back(test_scenes::planeObject({0, 0.5 * side, 0}, {0, -side, 0}));
    }
}

/// By default, by directions of the disc, and by photons.
std::array<BakeReport, 3> everyWay(const Scene& scene) {
    const GivenOptions sampled{{"disc", {std::string("sample"), "test"}}, {"disc_samples", {8.0, "test"}}};
    return {bakeOf(scene), bakeOf(scene, sampled), bakeOf(scene, {{"count", {65536.0, "test"}}}, "photons")};
}

// A pool between walls that are planes, as most pools are given, below a sun at its zenith: by the letter each wall
// hides half of the disc, and all four of them all of it. They go by the disc's middle, which none of them hides, by
// default and where the disc is sampled, as it is as soon as anything stands in the pool, and for photons.
TEST(SunDisc, APoolBetweenEndlessWallsIsLitBelowAZenithSun) {
    Scene scene = test_scenes::waterScene(0.0);
    scene.lights[0].direction = {0, 0, -1};
    scene.lights[0].angular_diameter_deg = 0.53;
    const double open = bakeOf(scene).path.deposited;
    addWalls(scene);
    for (const BakeReport& between : everyWay(scene)) {
        EXPECT_NEAR(between.path.deposited, open, 0.01 * open);
        EXPECT_LT(between.path.imbalance(), 1e-6);
    }
    // A sun that leans by less than its disc's radius goes by its middle too: it stands behind one of the walls.
    scene.lights[0].direction = glm::normalize(glm::dvec3(0.002, 0, -1));
    for (const BakeReport& dark : everyWay(scene)) EXPECT_LT(dark.path.deposited, 1e-3 * open);
}

// The same of bodies, whose tubes are launched across the light.
TEST(SunDisc, EndlessWallsGoByItsMiddleForBodiesToo) {
    Scene scene = test_scenes::waterScene(0.0);
    scene.lights[0].direction = {0, 0, -1};
    scene.lights[0].angular_diameter_deg = 0.53;
    scene.surfaces.clear();
    test::GlassScene ball(16);
    ball.addSphere({0, 0, -0.4}, 0.3, SurfaceEvent::Refract);
    scene.surfaces = ball.scene.surfaces, scene.media = ball.scene.media;
    const double open = bakeOf(scene).path.deposited;
    addWalls(scene);
    for (const BakeReport& between : everyWay(scene)) EXPECT_NEAR(between.path.deposited, open, 0.02 * open);
}

TEST(SunDisc, OneBlurIsRefusedWhereItCannotShowTheDisc) {
    const GivenOptions blur{{"disc", {std::string("blur"), "scene.toml:7"}}};
    Scene scene = test_scenes::waterScene(0.3);
    scene.lights[0].angular_diameter_deg = 0.5;
    EXPECT_NO_THROW(bakeOf(scene, blur));
    scene.surfaces.push_back(scene.surfaces[0]);
    try {
        bakeOf(scene, blur);
        ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
        EXPECT_EQ(error.where(), "scene.toml:7");
        EXPECT_NE(std::string(error.what()).find("\"sample\""), std::string::npos) << error.what();
    }
    scene.lights[0].angular_diameter_deg = 0;  // there is no disc to blur
    EXPECT_NO_THROW(bakeOf(scene, blur));
}

}  // namespace
}  // namespace photic
