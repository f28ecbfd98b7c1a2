// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photons.h"
#include "bake/report/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "bake/threads/parallel_for.h"
#include "tests/methods/photon_scenes.h"
#include "tests/support/closed_forms.h"
#include "tests/support/wave_light.h"

namespace photic {
namespace {

using test_scenes::boxFrame;
using test_scenes::CosineField;
using test_scenes::meshObject;
using test_scenes::planeObject;
using test_scenes::rectangle;
using test_scenes::waterScene;

std::shared_ptr<const NeededVoxels> everything(const GridFrame& frame) {
    return std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
}

BakeResult bake(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, std::int64_t count, int shifts = 16,
                PhotonSampling sampling = PhotonSampling::Quasi) {
    Monitor monitor;
    return bakePhotons(scene, std::move(needed), {sampling, count, shifts, 7}, monitor);
}

/// Mean of a channel over a layer of voxels that are at least `rim` away from the sides.
double layerMean(const LightField& field, int k, int channel, int rim = 0) {
    double sum = 0;
    int n = 0;
    for (int i = field.frame().min.x + rim; i <= field.frame().max.x - rim; ++i)
        for (int j = field.frame().min.y + rim; j <= field.frame().max.y - rim; ++j, ++n)
            sum += double(field.value({i, j, k}, channel));
    return sum / n;
}

truth::PlaneWater plane(double zenith, double extinction = 0) { return {1, std::cos(zenith), 1, 1.333, extinction}; }

TEST(Photons, PlaneWaterHasTheClosedForm) {
    Scene scene = waterScene(0.6);
    scene.medium.absorption = glm::dvec3(0.3), scene.medium.scattering = glm::dvec3(0.1);
    const GridFrame frame = boxFrame({-0.5, -0.5, -1}, {20, 20, 20}, glm::dvec3(0.05));
    const BakeResult r = bake(scene, everything(frame), 400000);
    const truth::PlaneWater water = plane(0.6, 0.4);
    for (int k = 0; k < 20; ++k) {
        const double bottom = 1 - 0.05 * k, top = bottom - 0.05;
        const double exact = water.meanFluence(top, bottom);
        EXPECT_NEAR(layerMean(r.field, k, 0) / exact, 1, 2e-4) << k;
        EXPECT_NEAR(-layerMean(r.field, k, 3) / water.meanHorizontal(top, bottom), 1, 2e-4) << k;
        EXPECT_NEAR(layerMean(r.field, k, 1) / exact, 0.8 * std::sin(0.6) / 1.333, 2e-4);
        EXPECT_NEAR(layerMean(r.field, k, 2) / exact, 0.6 * std::sin(0.6) / 1.333, 2e-4);
    }
    EXPECT_LT(r.report.power.imbalance(), 1e-12);
    EXPECT_LT(r.report.path.imbalance(), 1e-7);
    EXPECT_NEAR(r.report.power.absorbed_medium / r.report.power.scattered, 3, 1e-9);
    EXPECT_GT(r.report.power.escaped, 0);
    EXPECT_EQ(r.report.active_voxels, 8000);
}

TEST(Photons, ColouredLightFadesByChannel) {
    Scene scene = waterScene(0.3);
    scene.lights[0].irradiance = {3, 2, 1};
    scene.medium.absorption = {0.8, 0.2, 0.0};
    const GridFrame frame = boxFrame({-0.4, -0.4, -0.8}, {8, 8, 8}, glm::dvec3(0.1));
    const BakeResult r = bake(scene, everything(frame), 200000);
    ASSERT_EQ(r.field.channels().irradiance, 3);
    for (int k = 0; k < 8; ++k) {
        const double bottom = 0.8 - 0.1 * k, top = bottom - 0.1;
        double mean = 0;
        for (int c = 0; c < 3; ++c) {
            const double exact = (3 - c) * plane(0.3, scene.medium.absorption[c]).meanFluence(top, bottom);
            EXPECT_NEAR(layerMean(r.field, k, c) / exact, 1, 3e-4) << k << " channel " << c;
            mean += exact / 3;
        }
        EXPECT_NEAR(-layerMean(r.field, k, 5) / mean, plane(0.3).cosBelow(), 3e-4);
    }
    EXPECT_LT(r.report.power.imbalance(), 1e-12);
    EXPECT_LT(r.report.path.imbalance(), 1e-7);
    EXPECT_EQ(r.report.power.scattered, 0);
}

TEST(Photons, OnlyWhatIsAskedForIsComputed) {
    Scene scene = waterScene(0.3);
    scene.bake.grids.direction = false;
    const GridFrame frame = boxFrame({-0.4, -0.4, -0.8}, {8, 8, 8}, glm::dvec3(0.1));
    const BakeResult r = bake(scene, everything(frame), 20000);
    EXPECT_EQ(r.field.channels().count(), 1);
    EXPECT_NEAR(layerMean(r.field, 4, 0) / plane(0.3).meanFluence(0, 1), 1, 2e-3);
}

// A wave of water against its closed form: scores of voxels must be those of Student's t with shifts - 1 degrees
// of freedom.
struct WaveCase {
    static constexpr double kAmplitude = 0.03, kWavenumber = 2 * std::numbers::pi / 0.5;
    static constexpr int kSize = 24, kHeight = 16;
    Scene scene = waterScene(0, std::make_shared<CosineField>(kAmplitude, kWavenumber));
    GridFrame frame = boxFrame({-0.3, -0.1, -0.9}, {kSize, 4, kHeight}, {0.025, 0.05, 0.05});
    truth::VoxelMeans exact = truth::WaveLight(truth::cosineProfile(kAmplitude, kWavenumber), 1.333, -1, 1, 4000)
                                  .voxelMeans(-0.3, 0.025, kSize, -0.9, 0.05, kHeight);
};

/// Scores of all voxels with at least 25 paths, over `runs` seeds: tracks are shared by many voxels, so one run's
/// chi^2 says little.
struct Scores {
    double chi2 = 0, bias = 0;  ///< chi^2 / n, brought to 1 for `shifts` repetitions; relative error of all light
    double beyond3 = 0, beyond6 = 0;
};

Scores scoresOf(const WaveCase& wave, PhotonSampling sampling, int runs, int shifts, std::int64_t paths_a_shift) {
    Scores s;
    double n = 0, exact_sum = 0;
    for (int seed = 0; seed < runs; ++seed) {
        Monitor monitor;
        const BakeResult r =
            bakePhotons(wave.scene, everything(wave.frame), {sampling, shifts * paths_a_shift, shifts, seed}, monitor);
        EXPECT_LT(r.report.path.imbalance(), 1e-6);
        for (int i = 0; i < WaveCase::kSize; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < WaveCase::kHeight; ++k) {
                    const double exact = wave.exact.fluence[wave.exact.index(i, k)],
                                 found = double(r.field.value({i, j, k}, 0));
                    s.bias += found - exact, exact_sum += exact;
                    if (r.path_count->value({i, j, k}, 0) < 25) continue;
                    const double z = (found - exact) / double(r.standard_error->value({i, j, k}, 0));
                    s.chi2 += z * z, ++n, s.beyond3 += std::fabs(z) > 3, s.beyond6 += std::fabs(z) > 6;
                }
    }
    EXPECT_GT(n, 1300.0 * runs);
    s.chi2 *= (shifts - 3.0) / (shifts - 1.0) / n, s.bias /= exact_sum, s.beyond3 /= n, s.beyond6 /= n;
    return s;
}

TEST(Photons, StandardErrorsAreCalibrated) {
    const WaveCase wave;
    const Scores random = scoresOf(wave, PhotonSampling::Random, 24, 64, 400);
    EXPECT_NEAR(random.chi2, 1, 0.08);
    EXPECT_LT(random.beyond3, 0.008);
    EXPECT_EQ(random.beyond6, 0);
    EXPECT_NEAR(random.bias, 0, 2e-3);
    const Scores quasi = scoresOf(wave, PhotonSampling::Quasi, 48, 64, 400);
    EXPECT_NEAR(quasi.chi2, 1, 0.12);
    EXPECT_LT(quasi.beyond3, 0.008);
    EXPECT_EQ(quasi.beyond6, 0);
    EXPECT_NEAR(quasi.bias, 0, 1e-4);
}

TEST(Photons, QuasiRandomPointsConvergeFaster) {
    const WaveCase wave;
    const auto rmse = [&](PhotonSampling sampling, std::int64_t count) {
        double sum = 0;
        for (int seed = 0; seed < 4; ++seed) {
            Monitor monitor;
            const BakeResult r = bakePhotons(wave.scene, everything(wave.frame), {sampling, count, 16, seed}, monitor);
            for (int i = 0; i < WaveCase::kSize; ++i)
                for (int j = 0; j < 4; ++j)
                    for (int k = 0; k < WaveCase::kHeight - 1; ++k)
                        sum += std::pow(
                            double(r.field.value({i, j, k}, 0)) - wave.exact.fluence[wave.exact.index(i, k)], 2);
        }
        return std::sqrt(sum);
    };
    const std::int64_t low = 16 * 500, high = 16 * 16000;
    const double random_high = rmse(PhotonSampling::Random, high), quasi_high = rmse(PhotonSampling::Quasi, high);
    const double random = std::log(random_high / rmse(PhotonSampling::Random, low)) / std::log(32.0);
    const double quasi = std::log(quasi_high / rmse(PhotonSampling::Quasi, low)) / std::log(32.0);
    EXPECT_NEAR(random, -0.5, 0.05);
    EXPECT_LT(quasi, -0.68);
    EXPECT_LT(quasi_high, 0.3 * random_high);
}

bool sameBits(const LightField& a, const LightField& b) {
    if (a.leafCount() != b.leafCount()) return false;
    for (int s = 0; s < a.leafCount(); ++s) {
        if (a.state(s) != b.state(s)) return false;
        if (a.state(s) == LeafState::Dense &&
            std::memcmp(a.dense(s), b.dense(s), sizeof(float) * 512 * static_cast<std::size_t>(a.channels().count())) !=
                0)
            return false;
    }
    return true;
}

TEST(Photons, ThreadsChangeNothing) {
    WaveCase wave;
    wave.scene.lights[0].angular_diameter_deg = 2;
    wave.scene.objects = {planeObject({0, 0, -0.7}, {0, 0, 1}),
                          meshObject(rectangle({-0.1, -0.1, -0.4}, {0.2, 0, 0}, {0, 0.2, 0}), Role::Blocker)};
    const int before = threadCount();
    setThreadCount(1);
    const BakeResult one = bake(wave.scene, everything(wave.frame), 60000, 17);
    for (const int threads : {2, 3}) {
        setThreadCount(threads);
        const BakeResult many = bake(wave.scene, everything(wave.frame), 60000, 17);
        EXPECT_TRUE(sameBits(one.field, many.field)) << threads;
        EXPECT_TRUE(sameBits(*one.standard_error, *many.standard_error)) << threads;
        EXPECT_TRUE(sameBits(*one.path_count, *many.path_count)) << threads;
        EXPECT_EQ(one.report.power.received, many.report.power.received);
        EXPECT_EQ(one.report.path.expected, many.report.path.expected);
    }
    setThreadCount(before);
}

TEST(Photons, BlockersAboveTheWaterCastShadows) {
    Scene scene = waterScene(0);
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.5}, {10, 10, 5}, glm::dvec3(0.1));
    // A roof over x < 0 and, to be ignored, a movable one over everything.
    scene.objects = {meshObject(rectangle({-5, -5, 1}, {5, 0, 0}, {0, 10, 0}), Role::Blocker),
                     meshObject(rectangle({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}), Role::Movable)};
    const BakeResult r = bake(scene, everything(frame), 100000);
    const double lit = plane(0).horizontal(0);
    for (int i = 0; i < 10; ++i)
        EXPECT_NEAR(double(r.field.value({i, 4, 2}, 0)), i < 5 ? 0 : lit, i < 5 ? 0 : 0.02 * lit) << i;
    EXPECT_NEAR(r.report.power.absorbed_surface / r.report.power.emitted, 0.5, 1e-3);
    EXPECT_LT(r.report.power.imbalance(), 1e-12);
}

TEST(Photons, TracksGoOnTwoLayersPastAReceiver) {
    const GridFrame frame = boxFrame({-0.5, -0.5, -1}, {10, 10, 10}, glm::dvec3(0.1));
    const double zenith = 0.5;
    // On a border between voxels, and inside one.
    for (const double floor : {-0.5, -0.47}) {
        Scene scene = waterScene(zenith);
        scene.objects = {planeObject({0, 0, floor}, {0, 0, 1})};
        const BakeResult r = bake(scene, everything(frame), 200000);
        const double lit = plane(zenith).meanFluence(0, 0.1);
        for (int k = 0; k < 10; ++k)
            EXPECT_NEAR(layerMean(r.field, k, 0), k < 3 ? 0 : lit, k < 3 ? 0 : 5e-4 * lit) << k << " floor " << floor;
        EXPECT_NEAR(r.report.power.received + r.report.power.escaped + r.report.power.culled + r.report.power.reflected,
                    r.report.power.emitted, 1e-9);
        EXPECT_GT(r.report.power.received, 0.5 * r.report.power.emitted);
        EXPECT_LT(r.report.path.imbalance(), 1e-7);
    }
}

TEST(Photons, WallsAreOvershotAcrossTheirNormal) {
    // Light that grazes a wall: without layers counted across the wall the look-up at it would stay dark.
    Scene scene = waterScene(0.6);
    scene.lights[0].direction = {std::sin(0.6), 0, -std::cos(0.6)};
    scene.objects = {planeObject({0.2, 0, 0}, {-1, 0, 0})};
    const GridFrame frame = boxFrame({-0.5, -0.5, -1}, {20, 10, 10}, {0.05, 0.1, 0.1});
    const BakeResult r = bake(scene, everything(frame), 200000);
    const double lit = plane(0.6).meanFluence(0, 1);
    // The air above the wall is open only because light from x > 0.2 never comes this way.
    for (const int i : {13, 14, 15}) EXPECT_NEAR(double(r.field.value({i, 5, 3}, 0)), lit, 0.03 * lit) << i;
    EXPECT_EQ(r.field.value({16, 5, 3}, 0), 0) << "more than two layers behind the wall";
    EXPECT_NEAR(double(r.field.value({4, 5, 3}, 0)), lit, 0.03 * lit);
}

TEST(Photons, ShearedGridHoldsTheSameLight) {
    Scene scene = waterScene(0.6);
    scene.surfaces[0].outside = Outside::None;
    scene.surfaces[0].size = {0.3, 0.3};
    scene.lights[0].angular_diameter_deg = 3;
    const GridFrame aligned = boxFrame({-1, -1, -0.8}, {40, 40, 16}, glm::dvec3(0.05));
    GridFrame sheared = aligned;
    const glm::dvec2 run = glm::dvec2(scene.lights[0].direction) / 1.333 / -plane(0.6).cosBelow();
    sheared.setWorldFromIndex(0.05 * glm::dmat3(1, 0, 0, 0, 1, 0, run.x, run.y, 1));
    sheared.origin_world += glm::dvec3(-0.8 * run, 0);
    const BakeResult a = bake(scene, everything(aligned), 100000), s = bake(scene, everything(sheared), 100000);
    EXPECT_NEAR(a.report.path.deposited, s.report.path.deposited, 1e-7 * a.report.path.deposited);
    for (int c = 1; c < 4; ++c)
        EXPECT_NEAR(a.field.sum(c), s.field.sum(c), 1e-6 * a.field.sum(0)) << "world axes, not the grid's";
    // Along the light the spot stands still.
    const double top = layerMean(s.field, 15, 0), bottom = layerMean(s.field, 0, 0);
    EXPECT_NEAR(top, bottom, 2e-3 * top);
    EXPECT_GT(double(s.field.value({20, 20, 0}, 0)), 0.9 * plane(0.6).meanFluence(0, 1));
    EXPECT_LT(s.report.power.imbalance(), 1e-12);
}

TEST(Photons, SparseNeedsGetTheSameValues) {
    const WaveCase wave;
    NeededVoxels band = NeededVoxels::none(wave.frame);
    for (int i = 0; i < WaveCase::kSize; ++i)
        for (int j = 0; j < 4; ++j) band.addColumn(i, j, 3 + i % 3, 6);
    band.finish();
    const auto sparse_needed = std::make_shared<const NeededVoxels>(band);
    const BakeResult full = bake(wave.scene, everything(wave.frame), 60000),
                     sparse = bake(wave.scene, sparse_needed, 60000);
    for (int i = 0; i < WaveCase::kSize; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < WaveCase::kHeight; ++k) {
                const bool needed = k >= 3 + i % 3 && k <= 6;
                const float expected = needed ? full.field.value({i, j, k}, 0) : 0;
                EXPECT_NEAR(sparse.field.value({i, j, k}, 0), expected, 1e-5 * expected) << i << ' ' << j << ' ' << k;
                EXPECT_EQ(sparse.path_count->value({i, j, k}, 0), needed ? full.path_count->value({i, j, k}, 0) : 0);
            }
    EXPECT_LT(sparse.report.path.imbalance(), 1e-6);
    EXPECT_LT(sparse.report.power.imbalance(), 1e-12);
    EXPECT_LT(sparse.report.path.expected, 0.4 * full.report.path.expected);
    EXPECT_GT(sparse.report.power.culled, 0);
}

TEST(Photons, ReflectedLightRises) {
    Scene scene = waterScene(1.0);
    scene.surfaces[0].event = SurfaceEvent::Reflect;
    scene.medium.absorption = glm::dvec3(5);  // below: no business of light in air
    const GridFrame frame = boxFrame({-0.5, -0.5, 0}, {10, 10, 10}, glm::dvec3(0.1));
    const BakeResult r = bake(scene, everything(frame), 100000);
    const double reflectance = 1 - truth::fresnelTransmittance(std::cos(1.0), 1, 1.333);
    for (int k = 0; k < 10; ++k) {
        EXPECT_NEAR(layerMean(r.field, k, 0), reflectance, 1e-3 * reflectance);
        EXPECT_NEAR(layerMean(r.field, k, 3) / reflectance, std::cos(1.0), 1e-3);
    }
    EXPECT_NEAR(r.report.power.reflected / r.report.power.emitted, 1 - reflectance, 1e-9);
    EXPECT_LT(r.report.power.imbalance(), 1e-12);
}

TEST(Photons, BothBranchesAreFollowed) {
    Scene scene = waterScene(1.0);
    scene.surfaces[0].event = SurfaceEvent::Both;
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.5}, {10, 10, 10}, glm::dvec3(0.1));
    const BakeResult r = bake(scene, everything(frame), 200000);
    const double transmittance = truth::fresnelTransmittance(std::cos(1.0), 1, 1.333);
    EXPECT_NEAR(layerMean(r.field, 2, 0), plane(1.0).meanFluence(0, 0.1), 2e-3);
    EXPECT_NEAR(layerMean(r.field, 7, 0), 1 - transmittance, 2e-3 * (1 - transmittance));
    EXPECT_EQ(r.report.power.reflected, 0);
    EXPECT_LT(r.report.power.imbalance(), 1e-12);
}

TEST(Photons, MeshWaterActsLikeAHeightField) {
    Scene field = waterScene(0.6), mesh = field;
    field.surfaces[0].outside = Outside::None, field.surfaces[0].size = {0.6, 0.6};
    mesh.surfaces[0].height_field = nullptr;
    mesh.surfaces[0].mesh = rectangle({-0.3, -0.3, 0}, {0.6, 0, 0}, {0, 0.6, 0});
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.5}, {10, 10, 5}, glm::dvec3(0.1));
    const BakeResult a = bake(field, everything(frame), 400000), b = bake(mesh, everything(frame), 400000);
    EXPECT_NEAR(a.report.power.emitted, b.report.power.emitted, 1e-9);
    EXPECT_NEAR(a.report.power.emitted, 0.36 * std::cos(0.6), 1e-9);
    EXPECT_NEAR(a.report.path.deposited, b.report.path.deposited, 2e-3 * a.report.path.deposited);
    for (int k = 0; k < 5; ++k)
        for (int i = 0; i < 10; ++i)
            EXPECT_NEAR(double(a.field.value({i, 5, k}, 0)), double(b.field.value({i, 5, k}, 0)), 0.015)
                << i << ' ' << k;
}

TEST(Photons, MeshesTakeLightFromEitherSideAndShadowThemselves) {
    Scene scene = waterScene(0);
    // Turned over: the normal looks down, so light comes from the side of ior_below = 1.333 and leaves into ior_above
    // = 1.
    scene.surfaces[0].height_field = nullptr;
    scene.surfaces[0].mesh = rectangle({-0.3, -0.3, 0}, {0, 0.6, 0}, {0.6, 0, 0});
    scene.surfaces[0].ior_above = 1.333, scene.surfaces[0].ior_below = 1.0;
    scene.medium.absorption = glm::dvec3(3);
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.5}, {10, 10, 5}, glm::dvec3(0.1));
    const BakeResult turned = bake(scene, everything(frame), 50000);
    EXPECT_EQ(turned.report.power.absorbed_medium, 0)
        << "the medium is on the side of ior_below, which the light came from";
    EXPECT_NEAR(turned.report.power.reflected / turned.report.power.emitted,
                1 - truth::fresnelTransmittance(1, 1, 1.333), 1e-9);

    // A second sheet right behind the first: the sun does not light it, and the first sheet's light goes on through it,
    // since both of its sides lie below the first.
    auto two = std::make_shared<TriangleMesh>(*rectangle({-0.3, -0.3, 0}, {0.6, 0, 0}, {0, 0.6, 0}));
    const auto lower = rectangle({-0.3, -0.3, -0.2}, {0.6, 0, 0}, {0, 0.6, 0});
    two->positions.insert(two->positions.end(), lower->positions.begin(), lower->positions.end());
    two->normals.insert(two->normals.end(), lower->normals.begin(), lower->normals.end());
    two->triangles.push_back({4, 5, 6}), two->triangles.push_back({4, 6, 7});
    scene.surfaces[0].mesh = two;
    scene.medium = {};
    const BakeResult stacked = bake(scene, everything(frame), 50000);
    EXPECT_NEAR(stacked.report.power.emitted, 0.36, 2e-4);
    const double lit = truth::fresnelTransmittance(1, 1.333, 1);
    EXPECT_NEAR(stacked.report.power.escaped / stacked.report.power.emitted, lit, 1e-9);
    EXPECT_LT(stacked.report.power.imbalance(), 1e-12);
    EXPECT_NEAR(layerMean(stacked.field, 4, 0), layerMean(stacked.field, 3, 0), 1e-6);
    EXPECT_NEAR(layerMean(stacked.field, 2, 0), layerMean(stacked.field, 3, 0), 1e-6);
}

TEST(Photons, TheSunsDiscBlursAShadowsEdge) {
    Scene scene = waterScene(0);
    scene.lights[0].angular_diameter_deg = 10;
    scene.objects = {meshObject(rectangle({-5, -5, 1}, {5, 0, 0}, {0, 10, 0}), Role::Blocker)};
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.1}, {40, 1, 1}, {0.025, 1, 0.1});
    const BakeResult r = bake(scene, everything(frame), 400000);
    const double lit = plane(0).horizontal(0), radius = std::tan(5 * std::numbers::pi / 180);
    EXPECT_EQ(r.field.value({14, 0, 0}, 0), 0);
    EXPECT_NEAR(double(r.field.value({26, 0, 0}, 0)), lit, 5e-3 * lit);
    // On the surface, at x = s radius, the visible part of a disc cut by a line: 1/2 + (asin s + s sqrt(1 - s^2)) / pi.
    for (int i = 17; i < 23; ++i) {
        double visible = 0;
        for (int q = 0; q < 100; ++q) {
            const double s = std::clamp((-0.5 + 0.025 * (i + (q + 0.5) / 100)) / radius, -1.0, 1.0);
            visible += (0.5 + (std::asin(s) + s * std::sqrt(1 - s * s)) / std::numbers::pi) / 100;
        }
        EXPECT_NEAR(double(r.field.value({i, 0, 0}, 0)) / lit, visible, 0.03) << i;
    }
}

TEST(Photons, SaysWhatItCannotDo) {
    const Method method = photonsMethod();
    Scene scene = waterScene(0.3);
    EXPECT_EQ(method.refusal(scene), "");
    scene.bake.paths = Paths::All;
    EXPECT_NE(method.refusal(scene).find("paths = \"all\""), std::string::npos);
    scene.bake.paths = Paths::Caustic, scene.bake.grids.caustic = true;
    try {
        chooseMethod("photons", scene);
        FAIL() << "a grid that the row does not name";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("caustic"), std::string::npos) << error.what();
    }
    scene.bake.grids.caustic = false, scene.surfaces.push_back(scene.surfaces[0]);
    EXPECT_NE(method.refusal(scene).find("overlap"), std::string::npos);
}

TEST(Photons, CanBeCancelled) {
    struct Impatient final : Monitor {
        bool cancelled() const override { return true; }
    } monitor;
    const GridFrame frame = boxFrame({-0.5, -0.5, -0.5}, {10, 10, 5}, glm::dvec3(0.1));
    try {
        bakePhotons(waterScene(0.3), everything(frame), {}, monitor);
        FAIL() << "did not stop";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Cancelled);
    }
}

TEST(Photons, LightThatMissesTheGridIsSkipped) {
    Scene scene = waterScene(0.3);
    const GridFrame above = boxFrame({-0.5, -0.5, 1}, {4, 4, 4}, glm::dvec3(0.1));
    const BakeResult r = bake(scene, everything(above), 10000);
    EXPECT_EQ(r.report.power.emitted, 0);
    EXPECT_EQ(r.field.sum(0), 0);
    EXPECT_EQ(r.report.skipped.size(), 1u);
}

}  // namespace
}  // namespace photic
