// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "bake/report/error.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using support::WaterScene;

/// The launch of light straight down through some water, triangle by triangle.
struct Rig {
    WaterScene water;
    OpticalScene optics;
    Emission emission;
    PathTracer tracer;
    Obstacles obstacles;
    explicit Rig(WaterScene scene)
        : water(std::move(scene)),
          optics(water.scene, water.frame),
          emission(water.scene, 0, lightSamples(water.scene.lights[0], 1).front()),
          tracer(optics, emission, {{0, Branch::Refracted}}),
          obstacles(tracer) {}
    TubeBuilder refined(const std::vector<std::array<glm::dvec2, 3>>& triangles, const RefineOptions& options) const {
        TubeBuilder builder(optics, emission, {});
        Refiner refiner(tracer, obstacles, builder, options);
        for (const auto& t : triangles) {
            Path p[3];
            for (std::size_t i = 0; i < 3; ++i) p[i] = tracer.trace({{t[i].x, t[i].y, 0}, {}}, {});
            refiner.add(p[0], p[1], p[2], {0, 0, 1});
        }
        builder.finish();
        return builder;
    }
};

const std::vector<std::array<glm::dvec2, 3>> kSquare = {{{{-0.8, -0.8}, {0.8, -0.8}, {0.8, 0.8}}},
                                                        {{{-0.8, -0.8}, {0.8, 0.8}, {-0.8, 0.8}}}};

/// Sum of the tubes' areas at their start, in index space; negative orientation counts against.
double startArea(TubeBuilder& builder) {
    double area = 0;
    for (const TubeSet& set : builder.sets())
        for (const TubeBlock& block : set.blocks)
            for (const auto& t : block.topology->triangles) {
                const CornerRay *a = &set.corners[block.first_corner + t.corner[0]],
                                *b = &set.corners[block.first_corner + t.corner[1]],
                                *c = &set.corners[block.first_corner + t.corner[2]];
                area += 0.5 * ((b->u - a->u) * (c->v - a->v) - (c->u - a->u) * (b->v - a->v));
            }
    return area;
}

/// Wants to stop once it has been asked often enough.
class Impatient final : public Monitor {
public:
    bool cancelled() const override { return ++asked_ > 3; }
    int asked() const { return asked_; }

private:
    mutable int asked_ = 0;
};

// A tolerance of nothing would divide for minutes.
TEST(Refiner, StopsInTheMiddleOfATriangle) {
    const Rig rig(WaterScene(std::make_shared<support::Ripples>(0.03, 5)));
    RefineOptions options;
    options.tolerance = 1e-9;
    Impatient monitor;
    options.monitor = &monitor;
    try {
        rig.refined(kSquare, options);
        FAIL() << "it went on to the end";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Cancelled);
    }
    EXPECT_EQ(monitor.asked(), 4);
}

TEST(Refiner, LeavesNoGapAndNoOverlap) {
    for (const double tolerance : {0.0, 0.25, 0.02}) {
        const Rig rig(WaterScene(std::make_shared<support::Ripples>(0.03, 5)));
        RefineOptions options;
        options.tolerance = tolerance;
        TubeBuilder builder = rig.refined(kSquare, options);
        EXPECT_NEAR(startArea(builder), 32 * 32, 1e-6);
        EXPECT_NEAR(builder.power().emitted, 1.6 * 1.6, 1e-9) << "the sun's cross-section, to the last corner";
        EXPECT_LT(builder.power().imbalance(), 1e-12);
        if (tolerance > 0) {
            EXPECT_GT(builder.tubes(), 100);
        }
    }
}

TEST(Refiner, ATriangleIsDividedAlikeWhateverComesBeforeIt) {
    const Rig rig(WaterScene(std::make_shared<support::Ripples>(0.03, 5)));
    RefineOptions options;
    TubeBuilder alone = rig.refined({kSquare[1]}, options);
    TubeBuilder first = rig.refined({kSquare[0]}, options);
    TubeBuilder both = rig.refined(kSquare, options), turned = rig.refined({kSquare[1], kSquare[0]}, options);
    EXPECT_EQ(both.tubes(), first.tubes() + alone.tubes());
    EXPECT_EQ(both.tubes(), turned.tubes());
}

TEST(Refiner, ThePowerOfAShadowIsThatOfItsArea) {
    std::mt19937 random(7);
    std::uniform_real_distribution<> place(-0.7, 0.2);
    for (int i = 0; i < 12; ++i) {
        const glm::dvec2 at(place(random), place(random));
        WaterScene scene;
        scene.scene.objects = {
            support::planeObject({0, 0, -1.5}, {0, 0, 1}),
            support::meshObject(support::boxMesh({at.x, at.y, 0.3}, {at.x + 0.43, at.y + 0.37, 0.4}))};
        TubeBuilder builder = Rig(scene).refined(kSquare, {});
        EXPECT_NEAR(builder.power().absorbed_surface / (0.43 * 0.37), 1, 0.015);
        EXPECT_LT(builder.power().imbalance(), 1e-12);
        EXPECT_LT(builder.tubes(), 12000);
    }
}

TEST(Refiner, FlatWaterOverAnEmptyPoolStaysTwoTubes) {
    WaterScene scene;
    scene.scene.objects = {support::planeObject({0, 0, -1.5}, {0, 0, 1})};
    EXPECT_EQ(Rig(scene).refined(kSquare, {}).tubes(), 2);
    scene.scene.objects = {support::meshObject(support::boxMesh({-5, -5, -2}, {5, 5, -1.5}))};
    EXPECT_EQ(Rig(scene).refined(kSquare, {}).tubes(), 2);
}

TEST(Refiner, TubesThatEndOnASlopeAreDividedDownToAVoxel) {
    WaterScene scene;
    scene.scene.objects = {support::planeObject({0, 0, -1}, glm::dvec3(0.7, 0, 1))};
    TubeBuilder builder = Rig(scene).refined(kSquare, {});
    const TubeSet& set = builder.sets()[4];
    for (const TubeBlock& block : set.blocks)
        for (const auto& t : block.topology->triangles)
            for (int i = 0; i < 3; ++i) {
                const CornerRay &a = set.corners[block.first_corner + t.corner[i]],
                                &b = set.corners[block.first_corner + t.corner[(i + 1) % 3]];
                const double width = std::max(std::fabs(a.u - b.u), std::fabs(a.v - b.v));
                EXPECT_TRUE(width <= 1.0001 || std::fabs(a.w_end - b.w_end) <= 1.0001);
            }
}

}  // namespace
}  // namespace photic
