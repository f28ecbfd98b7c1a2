// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/path_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bake/optics/snell.h"
#include "bake/paths/row_trace.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using support::WaterScene;

RowTraceSetup setupOf(const WaterScene& water, Branch branch, const LightEnd& light_end) {
    RowTraceSetup setup;
    const Surface& surface = water.scene.surfaces[0];
    setup.light_direction = setup.sun_middle = water.scene.lights[0].direction;
    setup.refract = branch == Branch::Refracted;
    setup.traces_other_branch = surface.event == SurfaceEvent::Both;
    setup.ior_from = surface.ior_above, setup.ior_to = surface.ior_below;
    setup.index_from_world = water.frame.indexFromWorld(), setup.grid_origin = water.frame.origin_world;
    for (const Object& object : water.scene.objects) {
        const Plane& plane = std::get<Plane>(object.shape);
        const int axis = mainAxis(water.frame.indexNormal(plane.normal));
        if (object.blocks())
            setup.planes.push_back({plane.normal, glm::dot(plane.normal, plane.point), axis, object.receives(),
                                    light_end.behindPlane(axis), light_end.longestBehindPlane(axis)});
    }
    return setup;
}

class RowsAndPaths : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(RowsAndPaths, AgreeToRounding) {
    for (const SurfaceEvent event : {SurfaceEvent::Refract, SurfaceEvent::Reflect, SurfaceEvent::Both})
        for (const Branch branch : {Branch::Refracted, Branch::Reflected}) {
            if (event == SurfaceEvent::Refract && branch == Branch::Reflected) continue;
            if (event == SurfaceEvent::Reflect && branch == Branch::Refracted) continue;
            WaterScene water(std::make_shared<support::Ripples>(0.02, 6), {0.3, 0.2, -1});
            water.scene.surfaces[0].event = event;
            water.scene.objects = {support::planeObject({0, 0, -1.5}, {0.2, 0, 1}),
                                   support::planeObject({0.8, 0, 0}, {-1, 0, 0.1}),
                                   support::planeObject({0, 0, -1.55}, {0.2, 0.1, 1}, Role::Blocker),
                                   support::planeObject({0, 0, 0.9}, {0, 0.1, -1}, Role::Movable)};
            const double behind_walls = branch == Branch::Refracted ? 5 : 0;
            const OpticalScene optics(water.scene, water.frame, {}, behind_walls);
            const Emission emission(water.scene, 0, lightSamples(water.scene.lights[0], 1).front());
            const PathTracer tracer(optics, emission, {{0, branch}});
            SurfaceRow points;
            water.scene.surfaces[0].height_field->row({-0.9, 0.13}, 0.011, 160, points);
            RayRow rays;
            rowTracer(GetParam())(setupOf(water, branch, optics.lightEnd()), points, rays);
            int compared = 0;
            for (std::size_t i = 0; i < 160; ++i) {
                if (rays.per_layer[i] <= 0) continue;
                const Path path = tracer.trace({{-0.9 + 0.011 * static_cast<double>(i), 0.13, 0}, glm::dvec3(0)}, {});
                ASSERT_EQ(path.outcome, PathOutcome::Lit) << i;
                EXPECT_LT(glm::length(path.position - glm::dvec3(rays.x[i], rays.y[i], rays.z[i])), 1e-12);
                EXPECT_LT(glm::length(path.direction - glm::dvec3(rays.dx[i], rays.dy[i], rays.dz[i])), 1e-12);
                EXPECT_NEAR(path.fraction.y, rays.fraction[i], 1e-12);
                EXPECT_NEAR(path.untraced, rays.untraced[i], 1e-12);
                if (std::isfinite(path.hit_distance)) {
                    EXPECT_NEAR(path.hit_distance / rays.hit_distance[i], 1, 1e-11);
                    const glm::dvec3 end = path.position + path.end_distance * path.direction;
                    EXPECT_NEAR(water.frame.indexFromWorld(end).z, rays.w_end[i], 1e-7) << i;
                } else {
                    EXPECT_TRUE(std::isinf(rays.hit_distance[i]));
                }
                ++compared;
            }
            EXPECT_GT(compared, 100);
        }
}

INSTANTIATE_TEST_SUITE_P(Sets, RowsAndPaths, ::testing::ValuesIn(instructionSets()),
                         [](const auto& set) { return name(set.param); });

TEST(PathTracer, WhatStandsBetweenIsTold) {
    WaterScene water;
    water.scene.objects = {support::meshObject(support::boxMesh({-0.2, -0.2, 0.5}, {0.2, 0.2, 0.7}))};
    Surface glass;
    glass.mesh = std::make_shared<const TriangleMesh>(support::boxMesh({0.4, -0.2, 0.5}, {0.7, 0.2, 0.7}));
    water.scene.surfaces.push_back(glass);
    const OpticalScene optics(water.scene, water.frame);
    const Emission emission(water.scene, 0, lightSamples(water.scene.lights[0], 1).front());
    const PathTracer tracer(optics, emission, {{0, Branch::Refracted}});
    const auto outcome = [&](double x) { return tracer.trace({{x, 0, 0}, {}}, {}).outcome; };
    EXPECT_EQ(outcome(0), PathOutcome::Blocked);
    EXPECT_EQ(outcome(0.3), PathOutcome::Lit);
    EXPECT_EQ(outcome(0.5), PathOutcome::Hidden) << "the glass has launched this light";
}

// Light straight through a pane of glass: in and out, by Snell's law and Fresnel's equations at both faces.
TEST(PathTracer, FollowsAHistoryThroughTwoFaces) {
    WaterScene air;
    Surface pane;
    pane.mesh = std::make_shared<const TriangleMesh>(support::boxMesh({-0.5, -0.5, -0.6}, {0.5, 0.5, -0.4}));
    // Flat faces: each vertex normal is that of no face, so the faces' own are taken where they disagree.
    const_cast<TriangleMesh&>(*pane.mesh).normals.assign(8, {0, 0, 0});
    pane.ior_above = 1, pane.ior_below = 1.5, pane.event = SurfaceEvent::Both;
    air.scene.surfaces = {pane};
    air.scene.medium.absorption = {2, 3, 4};
    const OpticalScene optics(air.scene, air.frame);
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, 0, -1));
    air.scene.lights[0].direction = sun;
    const Emission emission(air.scene, 0, lightSamples(air.scene.lights[0], 1).front());
    const PathTracer tracer(optics, emission, {{0, Branch::Refracted}, {0, Branch::Refracted}});
    const Path path = tracer.trace({{0.1, 0.05, -0.4}, {0, 0, 0}}, {0, 0, 1});
    ASSERT_EQ(path.outcome, PathOutcome::Lit);
    EXPECT_LT(glm::length(path.direction - sun), 1e-12) << "parallel to the light that came";
    const double cos_i = -sun.z, cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / 2.25), length = 0.2 / cos_t;
    const double t = fresnelTransmittance(cos_i, cos_t, 1, 1.5);
    EXPECT_NEAR(path.fraction.x, t, 1e-12) << "the way back is as clear";
    EXPECT_NEAR(path.arriving.y, t * std::exp(-3 * length), 1e-9);
    EXPECT_NEAR(path.position.x, 0.1 + 0.2 * std::sqrt(1 - cos_t * cos_t) / cos_t, 1e-6);
    EXPECT_EQ(path.medium, optics.sides(0).outside);
    // A third event has nothing to meet.
    const PathTracer third(optics, emission, {{0, Branch::Refracted}, {0, Branch::Refracted}, {0, Branch::Refracted}});
    EXPECT_EQ(third.trace({{0.1, 0.05, -0.4}, {0, 0, 0}}, {0, 0, 1}).outcome, PathOutcome::Dark);
}

TEST(CountLeg, SharesAllOfThePowerOut) {
    for (const double absorption : {0.0, 1e-9, 0.3, 1e6})
        for (const double length : {0.0, 1e-12, 2.0, std::numeric_limits<double>::infinity()}) {
            PowerLedger ledger;
            const OpticalMedium medium{{1.3}, glm::dvec3(absorption), {0, 0.1, 0}};
            const glm::dvec3 left = countLeg(medium, {1, 2, 3}, length, &PowerLedger::received, ledger);
            EXPECT_NEAR(ledger.absorbed_medium + ledger.scattered + ledger.received, 2, 1e-12);
            EXPECT_NEAR(channelMean(left), ledger.received, 1e-12);
        }
}

TEST(SpecularEvent, WhatATintedMirrorTurnsIntoItselfIsAllTold) {
    // Grazing light on a smoothed normal, whose reflection would go into the face.
    Surface mirror;
    mirror.event = SurfaceEvent::Mirror, mirror.colour = {0.9, 0.8, 0.4};
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.99, 0, -0.14)), face(0, 0, 1),
                     normal = glm::normalize(glm::dvec3(0.1, 0, 0.995));
    const SpecularEvent event = specularEvent(mirror, 1, 1, direction, normal, face);
    ASSERT_EQ(event.count, 0);
    EXPECT_NEAR(event.dropped, 0.7, 1e-12);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(event.dropped + event.absorbed[c] + event.untraced, 1, 1e-12) << c;
    const SpecularEvent plain = specularEvent(mirror, 1, 1, {0, 0, -1}, face, face);
    ASSERT_EQ(plain.count, 1);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(plain.branches[0].fraction[c] + plain.absorbed[c], 1, 1e-12) << c;
}

}  // namespace
}  // namespace photic
