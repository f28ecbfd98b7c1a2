// SPDX-License-Identifier: Apache-2.0
// Glass, mirrors and many events: tubes against closed forms, and against photons.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "bake/field/scene_grid.h"
#include "bake/methods/beams.h"
#include "bake/methods/photons.h"
#include "bake/paths/emission.h"
#include "bake/scene/load_toml.h"
#include "bake/tubes/histories.h"
#include "tests/methods/glass_scene.h"
#include "tests/methods/photon_scenes.h"
#include "tests/support/closed_forms.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using test::GlassScene;
using test::option;
using test::relativeL1;

void expectLikePhotons(const GlassScene& glass, double noise, std::int64_t count = 4'000'000) {
    const BakeResult tubes = glass.bake(beamsMethod());
    const BakeResult photons = glass.bake(photonsMethod(), option("count", count));
    EXPECT_LT(tubes.report.power.imbalance(), 1e-5);
    EXPECT_LT(tubes.report.path.imbalance(), 1e-4);
    EXPECT_LT(photons.report.power.imbalance(), 1e-9);
    EXPECT_NEAR(tubes.report.power.emitted / photons.report.power.emitted, 1, 5e-3);
    EXPECT_NEAR(tubes.field.sum(0) / photons.field.sum(0), 1, 5e-3);
    const double apart = relativeL1(tubes.field, photons.field);
    EXPECT_LT(apart, noise);
}

TEST(Glass, ABallPassesWhatItsTwoFacesDo) {
    GlassScene glass(32);
    glass.addSphere({0, 0, 0.3}, 0.4, SurfaceEvent::Both);
    glass.scene.bake.bounces = 2;
    const BakeResult r = glass.bake(beamsMethod());
    // In and out again: (1 - R)^2 over the disc, at the angle whose sine is b / R.
    double passed = 0;
    constexpr int kRings = 20000;
    for (int i = 0; i < kRings; ++i) {
        const double sine = (i + 0.5) / kRings, t = truth::fresnelTransmittance(std::sqrt(1 - sine * sine), 1, 1.5);
        passed += 2 * sine / kRings * t * t;
    }
    const double disc = std::numbers::pi * 0.16;
    EXPECT_NEAR(r.report.power.emitted / disc, 1, 0.01) << "the facets that stand for the ball are a little smaller";
    // All that does not pass: reflected outside, or inside and given up after the second event.
    const double left = r.report.power.escaped - 0.0;
    EXPECT_GT(left / disc, passed * 0.98);
    EXPECT_LT(r.report.power.imbalance(), 1e-9);
}

TEST(Glass, ABallCatchesWhatItsDiscDoes) {
    for (const glm::dvec3 sun : {glm::dvec3(0, 0, -1), glm::dvec3(0.4, 0.1, -1)}) {
        GlassScene glass(32, sun);
        glass.addSphere({0.1, -0.05, 0.3}, 0.4, SurfaceEvent::Both);
        const BakeResult r = glass.bake(beamsMethod());
        EXPECT_NEAR(r.report.power.emitted / (std::numbers::pi * 0.16), 1, 1e-3) << "rim cut off, or counted twice";
        EXPECT_LT(r.report.power.dropped / r.report.power.emitted, 2e-3) << "faint, after many events";
    }
}

// The reflectance is steep where a ball turns away from the light: the last tubes there are not the mean of their
// corners.
TEST(Glass, ABallReflectsWhatItsDiscDoes) {
    double reflected = 0;
    constexpr int kRings = 200000;
    for (int i = 0; i < kRings; ++i) {
        const double cosine = std::sqrt((i + 0.5) / kRings);  // rings of one area
        reflected += (1 - truth::fresnelTransmittance(cosine, 1, 1.5)) / kRings;
    }
    struct Ball {
        double radius, most;  ///< [m], and by how much of it the reflected light may be off
    };
    // With the mean of the corners 2.4, 6.4 and 12 %. What is left is the chord of a curve over wide tubes, and the
    // rim.
    for (const auto& [radius, most] : {Ball{0.4, 0.019}, {0.1, 0.048}, {0.03, 0.088}}) {
        GlassScene glass(32, {0.2, 0.1, -1});
        glass.addSphere({0.1, -0.05, 0.3}, radius, SurfaceEvent::Refract);
        glass.scene.bake.bounces = 1;
        const BakeResult r = glass.bake(beamsMethod());
        EXPECT_NEAR(r.report.power.reflected / r.report.power.emitted / reflected, 1, most) << radius;
        EXPECT_LT(r.report.power.imbalance(), 1e-9);
    }
}

// Corners on a sharp edge belong to both of its faces: the one behind must not count the light of the one before.
TEST(Glass, ABoxCatchesWhatItsSidesDo) {
    for (const glm::dvec3 sun : {glm::dvec3(0.3, 0.2, -1), glm::dvec3(1, 0, -0.6), glm::dvec3(0.9, -0.8, -0.1)}) {
        GlassScene glass(32, sun);
        glass.add(support::boxMesh({-0.4, -0.3, -0.2}, {0.3, 0.4, 0.3}), SurfaceEvent::Both).smooth = false;
        const glm::dvec3 d = glm::abs(glass.scene.lights[0].direction);
        const double exact = d.x * 0.7 * 0.5 + d.y * 0.7 * 0.5 + d.z * 0.7 * 0.7;
        EXPECT_NEAR(glass.bake(beamsMethod()).report.power.emitted / exact, 1, 1e-5);
    }
}

// What enters a body within a hair of a sharp edge meets the face beyond the edge, and is not beside the body unseen:
// that light stood for all within half a voxel of the edge, and lit what stands behind.
TEST(Glass, LightBesideASharpEdgeMeetsTheFaceThere) {
    GlassScene glass(32, {0.4, 0.2, -1});
    TriangleMesh slab = support::boxMesh({-0.44, -0.36, -0.04}, {0.44, 0.36, 0.04});
    const glm::dmat3 tilted =
        glm::mat3_cast(glm::angleAxis(0.35, glm::dvec3(1, 0, 0)) * glm::angleAxis(0.26, glm::dvec3(0, 1, 0)));
    for (glm::dvec3& p : slab.positions) p = tilted * p + glm::dvec3(-0.2, 0, 0.4);
    for (glm::dvec3& n : slab.normals) n = tilted * n;
    glass.add(std::move(slab), SurfaceEvent::Refract).smooth = false;
    Surface& ball = glass.addSphere({0.36, 0.2, 0}, 0.2, SurfaceEvent::Mirror);
    ball.colour = glm::dvec3(0.5), ball.medium_below = 0;
    glass.scene.bake.bounces = 3;
    const PowerLedger tubes = glass.bake(beamsMethod()).report.power;
    const PowerLedger photons = glass.bake(photonsMethod(), option("count", std::int64_t{1'000'000})).report.power;
    EXPECT_NEAR(tubes.emitted / photons.emitted, 1, 5e-4);
    EXPECT_NEAR(tubes.absorbed_surface / photons.absorbed_surface, 1, 5e-3) << "3.5 % too much reached the ball";
    EXPECT_NEAR(tubes.reflected / photons.reflected, 1, 5e-3) << "and was not reflected";
}

// Launched across the light, an outline that lies along the lattice must not be cut off by part of a tube.
TEST(Glass, AFineSlabCatchesWhatItsFaceDoes) {
    GlassScene glass(32);
    constexpr int kCells = 60;
    TriangleMesh slab;
    for (const double z : {0.3, 0.2})
        for (int j = 0; j <= kCells; ++j)
            for (int i = 0; i <= kCells; ++i) {
                slab.positions.emplace_back(-0.5 + i * 0.93 / kCells, -0.4 + j * 0.81 / kCells, z);
                slab.normals.emplace_back(0, 0, z > 0.25 ? 1 : -1);
            }
    constexpr std::uint32_t kRow = kCells + 1, kBottom = kRow * kRow;
    for (std::uint32_t j = 0; j < kCells; ++j)
        for (std::uint32_t i = 0; i < kCells; ++i) {
            const std::uint32_t a = j * kRow + i, b = a + 1, c = b + kRow, d = a + kRow;
            slab.triangles.push_back({a, b, c}), slab.triangles.push_back({a, c, d});
            slab.triangles.push_back({a + kBottom, c + kBottom, b + kBottom});
            slab.triangles.push_back({a + kBottom, d + kBottom, c + kBottom});
        }
    glass.add(std::move(slab), SurfaceEvent::Both);
    EXPECT_NEAR(glass.bake(beamsMethod()).report.power.emitted / (0.93 * 0.81), 1, 1e-3);
}

// The rim of a spot's cone is narrow beside the smallest tubes, and steep.
TEST(Glass, ASpotSendsWhatItsConeDoes) {
    for (const double blend : {0.02, 0.1, 1.0}) {
        GlassScene glass(32);
        Light& spot = glass.scene.lights[0];
        spot.type = LightType::Spot, spot.position = glm::dvec3(0.1, 0.05, 0.9), spot.direction = {0, 0, -1};
        spot.power = glm::dvec3(4 * std::numbers::pi), spot.cone_angle_deg = 10, spot.blend = blend;
        glass.add(support::boxMesh({-0.9, -0.9, -0.8}, {0.9, 0.9, -0.7}), SurfaceEvent::Mirror).smooth = false;
        const double rim = std::cos(5 * std::numbers::pi / 180);
        // The mean of smoothstep over its width is a half.
        const double exact = 2 * std::numbers::pi * (1 - rim) * (1 - blend / 2);
        EXPECT_NEAR(glass.bake(beamsMethod()).report.power.emitted / exact, 1, 1e-3) << blend;
    }
}

// A torch close over water or a mirror lights less than a voxel, and far less than the first tubes are wide.
// What passes the grid may be sent back into it from beyond: a mirror below the floor of the volume was not seen by
// light that had come through the water, whose tubes were looked at up to the grid's end.
TEST(Glass, AMirrorBelowTheGridSendsLightBackIntoIt) {
    for (const double amplitude : {0.0, 0.005}) {
        Scene scene = test_scenes::waterScene(0.3, std::make_shared<test_scenes::CosineField>(amplitude, 8));
        GlassScene ball(16);
        Surface& mirror = ball.addSphere({0, 0, -0.8}, 0.15, SurfaceEvent::Mirror);
        mirror.medium_above = mirror.medium_below = -1;
        scene.surfaces.push_back(mirror);
        ball.scene = scene;
        ball.frame = test_scenes::boxFrame({-0.5, -0.5, -0.6}, {16, 16, 11}, glm::dvec3(1.0 / 16));
        const BakeReport tubes = ball.bake(beamsMethod()).report;
        const BakeReport photons = ball.bake(photonsMethod(), {{"count", {200000.0, "test"}}}).report;
        ball.scene.surfaces.pop_back();
        const BakeReport without = ball.bake(beamsMethod()).report;
        EXPECT_GT(photons.path.deposited, 1.01 * without.path.deposited) << amplitude;
        EXPECT_NEAR(tubes.path.deposited, photons.path.deposited, 3e-3 * photons.path.deposited) << amplitude;
        EXPECT_LT(tubes.path.imbalance(), 1e-6);
        EXPECT_LT(tubes.power.imbalance(), 1e-9);
    }
}

// Light along an axis comes to corners on the very rim of a ball, where rounding said whether it came from within: a
// ball that only reflects, some thousand voxels from the origin, sent 46 % too much on.
TEST(Glass, ABallsRimIsTheSameFarFromTheOrigin) {
    const auto lightOf = [](const glm::dvec3& place) {
        GlassScene glass(16);
        glass.addSphere(place, 0.4, SurfaceEvent::Reflect);
        glass.frame.origin_world += place;
        const BakeReport report = glass.bake(beamsMethod()).report;
        return glm::dvec2(report.power.emitted, report.path.deposited);
    };
    const glm::dvec2 near = lightOf({0, 0, 0});
    for (const glm::dvec3& far : {glm::dvec3(10, -10, -10), glm::dvec3(4047, -5441, -5733)}) {
        const glm::dvec2 there = lightOf(far);
        EXPECT_NEAR(there.x, near.x, 1e-3 * near.x);
        EXPECT_NEAR(there.y, near.y, 5e-3 * near.y);
    }
}

// A cone far narrower than a mesh's triangles, and a lamp close to one of them: few photons started where the light is.
TEST(Glass, FewPhotonsFindALampOverACoarseMesh) {
    GlassScene glass(16);
    Light spot;
    spot.type = LightType::Spot, spot.name = "torch", spot.position = glm::dvec3(0.1, 0.05, -0.5);
    spot.power = glm::dvec3(4 * std::numbers::pi), spot.cone_angle_deg = 7;
    glass.scene.lights = {spot};
    glass.add(support::boxMesh({-0.9, -0.9, -0.8}, {0.9, 0.9, -0.7}), SurfaceEvent::Mirror).smooth = false;
    const auto emitted = [&] { return glass.bake(photonsMethod(), {{"count", {3e4, "test"}}}).report.power.emitted; };
    const double cone = 2 * std::numbers::pi * (1 - std::cos(3.5 * std::numbers::pi / 180));
    EXPECT_NEAR(emitted() / (cone * (1 - 0.5 * spot.blend)), 1, 0.01) << "spot";
    // A hundredth above the middle of the top, which it sees from all but level.
    Light& lamp = glass.scene.lights[0];
    lamp.type = LightType::Point, lamp.position = glm::dvec3(0, 0, -0.69);
    const double half2 = 0.9 * 0.9, top = 4 * std::asin(half2 / (half2 + 1e-4));
    EXPECT_NEAR(emitted() / top, 1, 0.01) << "point";
    // A lamp with a face, nearer than it is wide: by its form factor, over centres of 40 parts a side.
    lamp.type = LightType::Rectangle, lamp.position = glm::dvec3(0, 0, -0.4), lamp.direction = {0, 0, -1};
    lamp.tangent = {1, 0, 0}, lamp.size = {1, 1}, lamp.power = glm::dvec3(1);
    constexpr int kParts = 40;
    const auto centre = [](int i, double wide) { return ((i + 0.5) / kParts - 0.5) * wide; };
    double factor = 0;
    for (int i = 0; i < kParts; ++i)
        for (int j = 0; j < kParts; ++j)
            for (int k = 0; k < kParts; ++k)
                for (int l = 0; l < kParts; ++l) {
                    const glm::dvec3 to(centre(k, 1.8) - centre(i, 1), centre(l, 1.8) - centre(j, 1), -0.3);
                    factor += 0.09 / std::pow(glm::dot(to, to), 2);
                }
    factor *= 1.8 * 1.8 / (std::numbers::pi * std::pow(kParts, 4));
    EXPECT_NEAR(emitted() / factor, 1, 0.01) << "rectangle";
}

TEST(Glass, ANarrowSpotSendsWhatItsConeDoes) {
    for (const double blend : {0.0, 0.3}) {
        GlassScene glass(32);
        Light spot;
        spot.type = LightType::Spot, spot.name = "torch", spot.position = glm::dvec3(0.1, 0.05, -0.65);
        spot.direction = glm::normalize(glm::dvec3(0.1, 0, -1));
        spot.power = glm::dvec3(4 * std::numbers::pi), spot.cone_angle_deg = 2, spot.blend = blend;
        glass.scene.lights = {spot};
        glass.add(support::boxMesh({-0.9, -0.9, -0.8}, {0.9, 0.9, -0.7}), SurfaceEvent::Mirror).smooth = false;
        const double rim = std::cos(std::numbers::pi / 180);
        const double exact = 2 * std::numbers::pi * (1 - rim) * (1 - blend / 2);
        EXPECT_NEAR(glass.bake(beamsMethod()).report.power.emitted / exact, 1, 0.01) << "mirror, " << blend;

        Scene pool = test_scenes::waterScene(0, std::make_shared<test_scenes::CosineField>(0.01, 8));
        spot.position = glm::dvec3(0.1, 0.05, 0.06), pool.lights = {spot};
        Monitor monitor;
        const auto needed = std::make_shared<const NeededVoxels>(
            NeededVoxels::everything(test_scenes::boxFrame({-1, -1, -1}, {16, 16, 8}, glm::dvec3(0.125))));
        const BakeResult baked = beamsMethod().bake(pool, needed, {}, monitor);
        EXPECT_NEAR(baked.report.power.emitted / exact, 1, 0.01) << "water, " << blend;
    }
}

// Long histories carry little: they must not cost as much each as the first one does.
TEST(Glass, FaintHistoriesAreCheap) {
    GlassScene glass(100, {0.4, 0.1, -1});
    glass.addSphere({0, 0, 0.3}, 0.4, SurfaceEvent::Both);
    glass.scene.bake.bounces = 2;
    const auto few = glass.bake(beamsMethod()).report.corner_rays;
    glass.scene.bake.bounces = 12;
    EXPECT_LT(glass.bake(beamsMethod()).report.corner_rays, 4 * few);
}

// The light that a glass ball throws back at its first face is a twelfth of all: one direction of the disc launches it,
// with the power of all.
TEST(Glass, WhatABodyThrowsBackIsLaunchedForOneDirectionOfADisc) {
    GlassScene glass(48, {0.4, 0.1, -1});
    glass.addSphere({0, 0, 0.3}, 0.4, SurfaceEvent::Both);
    const BakeResult one = glass.bake(beamsMethod(), option("disc", "off"));
    glass.scene.lights[0].angular_diameter_deg = 0.53;
    const BakeResult five = glass.bake(beamsMethod(), option("disc_samples", std::int64_t{5}));
    EXPECT_LT(five.report.tubes, 3 * one.report.tubes);
    EXPECT_GT(five.report.tubes, 2 * one.report.tubes);
    EXPECT_LT(five.report.power.imbalance(), 1e-9);
    EXPECT_NEAR(five.report.power.escaped / one.report.power.escaped, 1, 2e-3);
    EXPECT_LT(relativeL1(five.field, one.field), 0.05);
    // Above the ball there is nothing but sunlight that it throws back.
    EXPECT_NEAR(five.field.irradiance({0, 0, 22}) / one.field.irradiance({0, 0, 22}), 1, 0.02);
}

TEST(Glass, ANarrowDiscNeedsFewDirections) {
    GlassScene glass(32, {0.4, 0.1, -1});
    glass.addSphere({0, 0, 0.3}, 0.4, SurfaceEvent::Both);
    const auto rays = [&](double degrees, int most) {
        glass.scene.lights[0].angular_diameter_deg = degrees;
        const BakeResult r = glass.bake(beamsMethod(), option("disc_samples", std::int64_t{most}));
        EXPECT_LT(r.report.power.imbalance(), 1e-9) << degrees << " degrees: faint light is left to one sample";
        return static_cast<double>(r.report.corner_rays);
    };
    const double one = rays(0.53, 1);
    EXPECT_LT(rays(0.53, 32), 4.5 * one);
    EXPECT_GT(rays(5, 32), 1.5 * one);
    // What the few give is what many do: at 1.5 degrees, a third of a voxel of blur and more.
    glass.scene.lights[0].angular_diameter_deg = 1.5;
    const BakeResult few = glass.bake(beamsMethod());
    GlassScene many_scene = glass;
    Light light = glass.scene.lights[0];
    double apart = 0, total = 0;
    std::vector<double> mean;
    const GridFrame& frame = few.field.frame();
    constexpr int kMany = 24;
    for (const LightSample& sample : lightSamples(light, kMany)) {
        many_scene.scene.lights[0].angular_diameter_deg = 0;
        many_scene.scene.lights[0].direction = sample.direction;
        const BakeResult one_of_many = many_scene.bake(beamsMethod());
        std::size_t v = 0;
        for (int x = frame.min.x; x <= frame.max.x; ++x)
            for (int y = frame.min.y; y <= frame.max.y; ++y)
                for (int z = frame.min.z; z <= frame.max.z; ++z, ++v) {
                    if (mean.size() <= v) mean.push_back(0);
                    mean[v] += one_of_many.field.irradiance({x, y, z}) / kMany;
                }
    }
    std::size_t v = 0;
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z, ++v)
                apart += std::fabs(few.field.irradiance({x, y, z}) - mean[v]), total += mean[v];
    EXPECT_LT(apart / total, 0.01);
}

// A fine mesh is launched across the light, whatever its triangles; a sphere by its own.
TEST(Glass, AFineMeshOfABallIsTheBall) {
    GlassScene exact(32, {0.3, 0.2, -1}), fine(32, {0.3, 0.2, -1});
    exact.addSphere({0.1, -0.05, 0.3}, 0.4, SurfaceEvent::Both);
    fine.add(support::sphereMesh(96, {0.1, -0.05, 0.3}, 0.4), SurfaceEvent::Both);
    const BakeResult ball = exact.bake(beamsMethod()), mesh = fine.bake(beamsMethod());
    EXPECT_NEAR(mesh.report.power.emitted / ball.report.power.emitted, 1, 5e-3);
    EXPECT_LT(mesh.report.power.imbalance(), 1e-9);
    EXPECT_LT(mesh.report.power.dropped / mesh.report.power.emitted, 5e-3);
    EXPECT_LT(relativeL1(mesh.field, ball.field), 0.03);
}

// Two bodies that overlap, walls thinner than a voxel, a foot on the table: refinement has gone on here without end.
TEST(Glass, AGlassOfWineComesToAnEnd) {
    Monitor monitor;
    Scene scene = loadScene(PHOTIC_SOURCE_DIR "/examples/glass/wine_glass.toml", 0, monitor);
    scene.domain.voxel_size = 0.007;
    const GridFrame frame = sceneFrame(scene);
    for (const double turn : {0.0, 0.01, 0.3}) {
        scene.lights[0].direction = glm::normalize(glm::dvec3(1, 0.12 + turn, -0.72));
        const BakeResult r =
            beamsMethod().bake(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)),
                               option("disc", "off"), monitor);
        EXPECT_LT(r.report.corner_rays, 1'500'000) << turn;
        EXPECT_LT(r.report.tubes, 500'000) << turn;
        EXPECT_LT(r.report.power.imbalance(), 1e-9) << turn;
        EXPECT_LT(r.report.power.dropped / r.report.power.emitted, 0.1) << turn;
    }
}

// What an estimate is made of: some of the triangles, or of their parts, speak for all.
TEST(Glass, AFewTrianglesTellWhatAllTake) {
    for (const bool box : {false, true}) {
        GlassScene glass(48, {0.2, 0.3, -1});
        if (box) {
            glass.add(support::boxMesh({-0.4, -0.3, -0.2}, {0.3, 0.4, 0.3}), SurfaceEvent::Both).smooth = false;
        } else {
            glass.addSphere({0.1, -0.05, 0.3}, 0.4, SurfaceEvent::Both);
        }
        const OpticalScene optics(glass.scene, glass.frame);
        const std::vector<SpectralSample> spectrum = spectralSamples(1);
        const TubeSink nowhere = [](TubeSets&&) {};
        Monitor quiet;
        const auto launched = [&](int sampled) {
            LaunchOptions options;
            options.sampled = sampled;
            HistoryLauncher launcher(optics, spectrum, options, {6, 1e-3}, nowhere, quiet);
            LaunchTotals totals;
            launcher.launch(Emission(glass.scene, 0, lightSamples(glass.scene.lights[0], 1).front()), {}, totals);
            const double part = double(totals.triangles_launched) / double(totals.triangles);
            EXPECT_EQ(sampled == 0, part == 1);
            return double(totals.corner_rays) / part;
        };
        const double some = launched(48), all = launched(0);
        EXPECT_NEAR(some / all, 1, 0.35) << (box ? "box" : "ball");
    }
}

// A cone narrower than the triangles: their corners stand in the dark.
TEST(Glass, ASpotOnABigMirrorLosesNothing) {
    GlassScene glass(32);
    Light& spot = glass.scene.lights[0];
    spot.type = LightType::Spot, spot.position = glm::dvec3(0.1, 0.05, 0.9), spot.direction = {0, 0, -1};
    spot.power = glm::dvec3(4 * std::numbers::pi), spot.cone_angle_deg = 10, spot.blend = 0.4;
    Surface& mirror = glass.add(support::boxMesh({-0.9, -0.9, -0.8}, {0.9, 0.9, -0.7}), SurfaceEvent::Mirror);
    mirror.smooth = false;
    const BakeResult r = glass.bake(beamsMethod());
    // Intensity 1 W/sr on the axis: its falloff over the cone.
    double expected = 0;
    constexpr int kRings = 20000;
    const double rim = std::cos(5 * std::numbers::pi / 180);
    for (int i = 0; i < kRings; ++i)
        expected += 2 * std::numbers::pi * (1 - rim) / kRings * spot.spotFalloff(rim + (1 - rim) * (i + 0.5) / kRings);
    EXPECT_NEAR(r.report.power.emitted / expected, 1, 5e-3);
    EXPECT_LT(r.report.corner_rays, 50'000);
}

TEST(Glass, ABallFocusesLikePhotons) {
    GlassScene glass(32);
    glass.addSphere({0.1, -0.05, 0.3}, 0.4, SurfaceEvent::Both);
    expectLikePhotons(glass, 0.05);
}

TEST(Glass, ABallOnAFloorLikePhotons) {
    GlassScene glass(32, {0.3, 0.2, -1});
    glass.addSphere({0.1, -0.05, 0.1}, 0.4, SurfaceEvent::Both);
    glass.scene.objects = {support::planeObject({0, 0, -0.7}, {0, 0, 1})};
    expectLikePhotons(glass, 0.05);
}

TEST(Glass, APaneShiftsLightAndNothingElse) {
    GlassScene glass(32, {0.5, 0, -1});
    Surface& pane = glass.add(support::boxMesh({-1.4, -1.4, 0.2}, {1.4, 1.4, 0.5}), SurfaceEvent::Both);
    pane.smooth = false;
    glass.scene.bake.bounces = 4;
    expectLikePhotons(glass, 0.02);
    const BakeResult r = glass.bake(beamsMethod());
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, 0, -1));
    // Under the pane: straight through, and after two reflections inside, in the sun's own direction.
    const double once = 1 - truth::fresnelTransmittance(-sun.z, 1, 1.5);
    const glm::ivec3 below(0, 0, -10);
    EXPECT_NEAR(r.field.irradiance(below), (1 - once) * (1 - once) * (1 + once * once), 2e-4);
    EXPECT_LT(glm::length(r.field.flux(below) / r.field.irradiance(below) - sun), 1e-4);
}

TEST(Glass, AMirrorBallLikePhotons) {
    GlassScene glass(32, {0.2, 0.1, -1});
    Surface& ball = glass.addSphere({0, 0, -0.4}, 0.3, SurfaceEvent::Mirror);
    ball.colour = {0.9, 0.6, 0.3};
    expectLikePhotons(glass, 0.05);
}

TEST(Glass, GlassInTheWaterLikePhotons) {
    GlassScene glass(32, {0.3, 0.1, -1});
    Surface water;
    water.name = "water", water.height_field = std::make_shared<support::Ripples>(0.02, 6), water.size = {2, 2};
    glass.scene.surfaces.push_back(water);
    Medium& m = glass.scene.media[1];
    m.priority = 1;
    Surface& ball = glass.addSphere({0, 0, -0.4}, 0.25, SurfaceEvent::Both);
    (void)ball;
    expectLikePhotons(glass, 0.05);
}

TEST(Glass, ALampAboveTheWaterLikePhotons) {
    GlassScene glass(32);
    Surface water;
    water.name = "water", water.height_field = std::make_shared<support::Ripples>(0.02, 6), water.size = {2, 2};
    water.outside = Outside::None;
    glass.scene.surfaces.push_back(water);
    Light& lamp = glass.scene.lights[0];
    lamp.type = LightType::Point, lamp.position = glm::dvec3(0.3, 0.2, 0.9), lamp.power = glm::dvec3(10);
    lamp.irradiance = glm::dvec3(10 / (4 * std::numbers::pi * 0.81));
    expectLikePhotons(glass, 0.05);
}

TEST(Glass, DispersionPartsColoursAndKeepsWhite) {
    GlassScene glass(24, {0.6, 0, -1});
    glass.scene.media[1].ior = RefractiveIndex::abbe(1.6, 20);
    glass.addSphere({0, 0, 0.2}, 0.5, SurfaceEvent::Refract);
    const BakeResult r = glass.bake(beamsMethod());
    ASSERT_EQ(r.field.channels().irradiance, 3);
    EXPECT_LT(r.report.power.imbalance(), 1e-9);
    EXPECT_NEAR(r.field.sum(0) / r.field.sum(2), 1, 0.03);
    double apart = 0, sum = 0;
    for (int x = -12; x < 12; ++x)
        for (int y = -12; y < 12; ++y) {
            apart += std::fabs(static_cast<double>(r.field.value({x, y, -8}, 0) - r.field.value({x, y, -8}, 2)));
            sum += static_cast<double>(r.field.value({x, y, -8}, 0));
        }
    EXPECT_GT(apart / sum, 0.05);
}

}  // namespace
}  // namespace photic
