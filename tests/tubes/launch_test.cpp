// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/launch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/vector_relational.hpp>
#include <set>
#include <utility>

#include "bake/scene/spline_field.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/histories.h"
#include "bake/tubes/lattice.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using support::WaterScene;

struct Launched {
    LaunchTotals totals;
    double power = 0;  // of all tubes [W]
    std::vector<double> starts;
};

Launched launched(const WaterScene& water, const LaunchOptions& options, bool mesh = false) {
    const OpticalScene optics(water.scene, water.frame);
    const Light& light = water.scene.lights[0];
    const Emission emission(water.scene, 0, lightSamples(light, 1).front());
    const PathTracer tracer(optics, emission, {{0, Branch::Refracted}});
    Launched out;
    const TubeSink sink = [&](const TubeSets& sets) {
        for (const TubeSet& set : sets) {
            for (const TubeConstants& tube : set.tubes) out.power += static_cast<double>(tube.power[0]);
            for (const CornerRay& corner : set.corners)
                out.starts.push_back(corner.u + 3 * corner.v + 7 * corner.w_end);
        }
    };
    Monitor monitor;
    Launch launch(tracer, options, sink, monitor);
    if (mesh)
        launch.mesh(out.totals);
    else
        launch.heightField(
            layLattice(tracer, launchDomain(water.scene, water.scene.surfaces[0], light, water.frame), options),
            out.totals);
    return out;
}

TEST(Launch, AdaptiveAndFixedMeshesCarryTheSamePower) {
    WaterScene water(std::make_shared<support::Ripples>(0.02, 6), {0.2, 0.1, -1});
    water.scene.objects = {support::planeObject({0, 0, -1.5}, {0, 0, 1}),
                           support::meshObject(support::sphereMesh(12, {0.2, 0.1, -0.9}, 0.25))};
    // All of the light goes through the box.
    water.scene.surfaces[0].outside = Outside::None, water.scene.surfaces[0].size = {0.9, 0.9};
    LaunchOptions fine;
    fine.cells = 400;
    const Launched adaptive = launched(water, {}), fixed = launched(water, fine);
    EXPECT_LT(adaptive.totals.power.imbalance(), 1e-12);
    EXPECT_LT(fixed.totals.power.imbalance(), 1e-12);
    EXPECT_NEAR(adaptive.totals.power.emitted / fixed.totals.power.emitted, 1, 2e-5);
    EXPECT_NEAR(adaptive.totals.power.received / fixed.totals.power.received, 1, 1e-3);
    EXPECT_LT(adaptive.totals.corner_rays, fixed.totals.corner_rays);
}

TEST(Launch, BothBranchesShareThePowerOfSteepWaterHoweverCoarselyItIsCut) {
    // Grazing light: cells that one branch would be content with, the other would not.
    WaterScene water(std::make_shared<support::Ripples>(0.1, 7), {0.93, -0.08, -0.36});
    water.scene.surfaces[0].event = SurfaceEvent::Both;
    const OpticalScene optics(water.scene, water.frame);
    const Light& light = water.scene.lights[0];
    const LaunchDomain domain = launchDomain(water.scene, water.scene.surfaces[0], light, water.frame);
    const TubeSink ignored = [](const TubeSets&) {};
    const std::vector<SpectralSample> white;
    for (const double tolerance : {1.0, 2.0}) {
        LaunchOptions options;
        options.refine.tolerance = tolerance;
        LaunchTotals totals;
        Monitor monitor;
        HistoryLauncher launcher(optics, white, options, {4, 1e-4}, ignored, monitor);
        launcher.launch(Emission(water.scene, 0, lightSamples(light, 1).front()), domain, totals);
        EXPECT_GT(totals.power.emitted, 0);
        EXPECT_LT(totals.power.imbalance(), 1e-9) << tolerance;
    }
}

/// Ripples that end at x = 0, where flat water a quarter of a voxel lower begins.
class SteppedWater final : public HeightField {
public:
    SurfacePoint at(glm::dvec2 p) const override {
        return p.x < 0 ? ripples_.at(p) : SurfacePoint{{p.x, p.y, -0.0325}, {0, 0, 1}};
    }
    double minZ() const override { return -0.04; }
    double maxZ() const override { return 0.04; }
    double featureSize() const override { return ripples_.featureSize(); }

private:
    support::Ripples ripples_{0.01, 20};
};

/// Each edge across the step spans it however often it is halved: what its tubes carry puts an end to that.
TEST(Launch, WaterThatEndsInAStepCostsFewTubes) {
    WaterScene smooth(std::make_shared<support::Ripples>(0.01, 20), {0.1, 0.2, -1});
    WaterScene stepped(std::make_shared<SteppedWater>(), {0.1, 0.2, -1});
    for (WaterScene* water : {&smooth, &stepped})
        water->scene.surfaces[0].outside = Outside::None, water->scene.surfaces[0].size = {0.9, 0.9};
    const Launched all_waves = launched(smooth, {}), half_flat = launched(stepped, {});
    EXPECT_LT(half_flat.totals.power.imbalance(), 1e-12);
    EXPECT_LT(half_flat.totals.corner_rays, 5 * all_waves.totals.corner_rays);
}

// Whatever the waves are like, over whole ones a sun sends into them what it would send into flat water: what a crest
// takes more, the water behind it goes without.
TEST(Launch, SteepWavesTakeNoMoreLightThanTheSunSends) {
    const double k = 7, wave_x = 2 * M_PI / k, wave_y = wave_x / 1.3;
    for (const glm::dvec3& sun : {glm::dvec3(0.3, 0.2, -1), {1.5, 0.4, -1}, {3, -2, -1}, {-9, 3, -1}}) {
        const WaterScene water(std::make_shared<support::Ripples>(0.06, k), sun);
        const OpticalScene optics(water.scene, water.frame);
        const Emission emission(water.scene, 0, lightSamples(water.scene.lights[0], 1).front());
        const PathTracer tracer(optics, emission, {{0, Branch::Refracted}});
        const TubeSink ignored = [](const TubeSets&) {};
        const LaunchDomain whole{{-wave_x, -1.5 * wave_y}, {wave_x, 1.5 * wave_y}, true};
        LaunchTotals totals;
        Monitor monitor;
        Launch launch(tracer, {}, ignored, monitor);
        launch.heightField(layLattice(tracer, whole, {}), totals);
        const double sent = whole.area() * -water.scene.lights[0].direction.z;
        EXPECT_NEAR(totals.power.emitted / sent, 1, 2e-3) << sun.x;
        EXPECT_LT(totals.power.imbalance(), 1e-9);
    }
}

// A steeper corner widens what is launched; the corners of the tubes that were launched before stay the same bits.
TEST(Launch, MapsLatticeStaysWhereACornerOfItGetsSteeper) {
    const auto map = [](double steeper) {
        SplineFieldShape shape;
        shape.size = glm::dvec2(4);
        SampleGrid heights{128, 128, {}};
        for (int j = 0; j < 128; ++j)
            for (int i = 0; i < 128; ++i)
                heights.values.push_back(0.01 * std::sin(0.2 * i + 0.1 * j) +
                                         (i < 20 && j < 20 ? steeper * std::sin(0.5 * i) : 0.0));
        return makeSplineField(shape, heights);
    };
    std::vector<std::set<std::pair<double, double>>> corners;
    std::vector<double> areas;
    for (const double steeper : {0.0, 0.02, 0.05}) {
        WaterScene water(map(steeper), {0.2, 0.1, -1});
        water.scene.surfaces[0].size = {4, 4};
        const OpticalScene optics(water.scene, water.frame);
        const Light& light = water.scene.lights[0];
        const Emission emission(water.scene, 0, lightSamples(light, 1).front());
        const PathTracer tracer(optics, emission, {{0, Branch::Refracted}});
        const LaunchDomain domain = launchDomain(water.scene, water.scene.surfaces[0], light, water.frame);
        const Lattice lattice = layLattice(tracer, domain, {});
        const glm::dvec2 end = lattice.origin + lattice.step * glm::dvec2(lattice.columns, lattice.rows);
        EXPECT_TRUE(glm::all(glm::lessThanEqual(lattice.origin, domain.min)));
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(end, domain.max)));
        areas.push_back(domain.area());
        auto& here = corners.emplace_back();
        for (int j = 0; j <= lattice.rows; ++j)
            for (int i = 0; i <= lattice.columns; ++i) {
                const glm::dvec3 corner = lattice.param(i, j).position;
                here.insert({corner.x, corner.y});
                // As rows are sampled: from where they begin, step by step.
                EXPECT_EQ(lattice.param(0, j).position.x + lattice.step.x * i, corner.x);
            }
    }
    for (std::size_t k = 1; k < corners.size(); ++k) {
        EXPECT_GT(areas[k], 1.001 * areas[k - 1]);
        EXPECT_TRUE(std::includes(corners[k].begin(), corners[k].end(), corners[k - 1].begin(), corners[k - 1].end()));
        EXPECT_GT(corners[k].size(), corners[0].size());
    }
}

TEST(Launch, ThreadsChangeNothing) {
    WaterScene water(std::make_shared<support::Ripples>(0.02, 6), {0.2, 0.1, -1});
    water.scene.objects = {support::meshObject(support::sphereMesh(12, {0.2, 0.1, -0.9}, 0.25))};
    setThreadCount(1);
    const Launched one = launched(water, {});
    setThreadCount(3);
    const Launched three = launched(water, {});
    setThreadCount(0);
    EXPECT_EQ(one.starts, three.starts);
    EXPECT_EQ(one.totals.power.received, three.totals.power.received);
}

TEST(Launch, AFloorOfManyTrianglesIsLaidInWholeBlocks) {
    TriangleMesh floor;
    const int n = 100;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            floor.positions.push_back({0.05 * i - 2.5, 0.05 * j - 2.5, -1.5 + 0.004 * std::sin(0.3 * i + 0.2 * j)});
    floor.normals.assign(floor.positions.size(), {0, 0, 1});
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i), b = a + 1, c = a + n + 1, d = c + 1;
            floor.triangles.push_back({a, b, d}), floor.triangles.push_back({a, d, c});
        }
    WaterScene water(std::make_shared<support::Ripples>(0.01, 6)), plane = water;
    plane.scene.objects = {support::planeObject({0, 0, -1.5}, {0, 0, 1})};
    water.scene.objects = {support::meshObject(floor)};
    const Launched on_mesh = launched(water, {}), on_plane = launched(plane, {});
    EXPECT_NEAR(on_mesh.power / on_plane.power, 1, 1e-6);
    EXPECT_LT(static_cast<double>(on_mesh.totals.tubes), 1.3 * static_cast<double>(on_plane.totals.tubes));
}

TEST(Launch, MeshesEnterTriangleByTriangle) {
    WaterScene water;
    Surface& surface = water.scene.surfaces[0];
    surface.height_field = nullptr;
    surface.mesh = std::make_shared<const TriangleMesh>(support::boxMesh({-0.5, -0.5, -0.2}, {0.5, 0.5, 0}));
    const Launched out = launched(water, {}, true);
    EXPECT_NEAR(out.totals.power.emitted, 1, 1e-9) << "the faces below lie hidden";
    EXPECT_LT(out.totals.power.imbalance(), 1e-12);
}

}  // namespace
}  // namespace photic
