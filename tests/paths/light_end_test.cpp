// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/light_end.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace photic {
namespace {

// Cubic voxels of 0.1 m whose faces lie at (i - 0.5) * 0.1.
GridFrame tenths() {
    GridFrame frame;
    frame.setWorldFromIndex(glm::dmat3(0.1));
    frame.min = {0, 0, 0}, frame.max = {31, 31, 31};
    return frame;
}

Object object(const glm::dvec3& low, const glm::dvec3& high, Role role = Role::Receiver) {
    TriangleMesh mesh;
    for (unsigned c = 0; c < 8; ++c)
        mesh.positions.push_back({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
    for (const auto& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}})
        mesh.triangles.push_back({q[0], q[1], q[2]}), mesh.triangles.push_back({q[0], q[2], q[3]});
    Object out;
    out.shape = std::make_shared<const TriangleMesh>(std::move(mesh)), out.role = role;
    return out;
}

// Where light from `origin` along `direction` ends.
glm::dvec3 endOf(const Scene& scene, const GridFrame& frame, const glm::dvec3& origin, const glm::dvec3& direction) {
    const RayCaster caster(scene);
    return origin +
           LightEnd(scene, frame, caster).distance(origin, direction, caster.firstHit(origin, direction)) * direction;
}

TEST(LightEnd, CoversTwoLayersBehindTheHitVoxel) {
    const GridFrame frame = tenths();
    Scene scene;
    scene.objects.push_back({"floor", "", Plane{}, Role::Receiver});
    const RayCaster caster(scene);
    const LightEnd light_end(scene, frame, caster);
    RayHit hit;
    hit.target = {Target::Kind::Object, 0}, hit.normal = {0, 0, 1};
    const auto endHeight = [&](const glm::dvec3& direction, double height) {
        hit.distance = (2.0 - height) / -direction.z;
        return 2.0 + light_end.distance({1, 1, 2.0}, direction, hit) * direction.z;
    };
    for (const glm::dvec3& d :
         {glm::dvec3(0, 0, -1), glm::normalize(glm::dvec3(0.9, 0.3, -1)), glm::normalize(glm::dvec3(2, 0, -1))}) {
        EXPECT_NEAR(endHeight(d, 1.01), 0.75, 1e-6) << "inside the voxel that reaches from 0.95 to 1.05";
        EXPECT_NEAR(endHeight(d, 0.95), 0.75, 1e-6)
            << "on its lower side, which belongs to the voxel that the light comes from";
        EXPECT_NEAR(endHeight(d, 0.95 - 1e-12), 0.75, 1e-6);
        EXPECT_NEAR(endHeight(d, 0.95 + 1e-12), 0.75, 1e-6);
        EXPECT_GT(endHeight(d, 1.01), 0.75) << "not into the next layer";
    }
    // Grazing light stops after kMaxOvershootVoxels of its own.
    EXPECT_NEAR(light_end.distance({1, 1, 2}, glm::normalize(glm::dvec3(1, 0, -1e-3)), hit) - hit.distance, 1.6, 1e-3);
    EXPECT_TRUE(std::isinf(light_end.distance({1, 1, 2}, {0, 0, -1}, RayHit{})));
}

TEST(LightEnd, BlockersEndLightWhereTheyAre) {
    Scene scene;
    scene.objects.push_back(object({0.5, 0.5, 0.4}, {1.5, 1.5, 1.01}, Role::Blocker));
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 1.01, 1e-9);
}

TEST(LightEnd, LightDoesNotShineThroughAFlank) {
    // A steep leg that enters the side of a thick body and leaves it below, before two layers across are crossed.
    Scene scene;
    scene.objects.push_back(object({0.5, 0.5, 1.0}, {1.5, 1.5, 2.0}));
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.1, 0, -1));
    EXPECT_NEAR(endOf(scene, tenths(), {0.45, 1, 2.1}, d).z, 1.0, 1e-6);
    // Thin parts are passed, two voxels along the leg and no more.
    scene.objects[0] = object({0.5, 0.5, 0.5}, {1.5, 1.5, 1.02});
    scene.objects[0] = object({0.5, 0.5, 1.0}, {1.5, 1.5, 1.02});
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 0.82, 1e-6);
}

TEST(LightEnd, LightDoesNotGoOnThroughASecondObject) {
    Scene scene;
    scene.objects.push_back(object({0.5, 0.5, 1.16}, {1.5, 1.5, 1.2}));
    scene.objects.push_back(object({0.5, 0.5, 0.2}, {1.5, 1.5, 1.1}));
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 1.1, 1e-6) << "below a thin plate";
    TriangleMesh sheet;
    sheet.positions = {{0.5, 0.5, 1.16}, {2.5, 0.5, 1.16}, {0.5, 2.5, 1.16}}, sheet.triangles = {{0, 1, 2}};
    scene.objects[0].shape = std::make_shared<const TriangleMesh>(std::move(sheet));
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 1.1, 1e-6) << "below a sheet";
}

// In the corner where a wall stands on a floor light goes on inside of both, as it does where they are one mesh.
TEST(LightEnd, BodiesThatTouchOrOverlapAreOneSolid) {
    const glm::dvec3 from{0.8, 1, 2}, slanting = glm::normalize(glm::dvec3(0.3, 0, -1));
    const auto one = object({0, 0, 0.2}, {3, 3, 1.02});
    Scene alone;
    alone.objects = {one};
    const glm::dvec3 expected = endOf(alone, tenths(), from, slanting);
    ASSERT_NEAR(expected.z, 0.75, 1e-6);
    for (const double wall_bottom : {0.5, 1.02}) {
        // The leg meets the floor at x = 1.094, and goes on below the wall, from 1.12 on.
        Scene scene;
        scene.objects = {one, object({1.12, 0, wall_bottom}, {3, 3, 2.5})};
        EXPECT_NEAR(glm::length(endOf(scene, tenths(), from, slanting) - expected), 0, 1e-6) << wall_bottom;
        scene.objects[1].role = Role::Blocker;
        EXPECT_NEAR(glm::length(endOf(scene, tenths(), from, slanting) - expected), 0, 1e-6) << wall_bottom;
    }
    // Into the wall first, close above the floor: two layers across the wall's face, through whatever the floor is.
    Scene scene;
    scene.objects = {object({1.02, 0, 1.02}, {3, 3, 2.5})};
    scene.objects.push_back(one);
    const glm::dvec3 steep = glm::normalize(glm::dvec3(0.5, 0, -1));
    EXPECT_NEAR(endOf(scene, tenths(), {0.54, 1, 2}, steep).x, 1.25, 1e-6) << "a body";
    scene.objects[0] = object({1.02, 0, 0.6}, {3, 3, 2.5});
    EXPECT_NEAR(endOf(scene, tenths(), {0.54, 1, 2}, steep).x, 1.25, 1e-6) << "that overlaps";
    for (const double up : {1.0, -1.0}) {
        scene.objects[1].shape = Plane{{0, 0, 1.02}, {0, 0, up}};
        EXPECT_NEAR(endOf(scene, tenths(), {0.54, 1, 2}, steep).x, 1.25, 1e-6) << "a plane";
    }
    // What ends in the open does, with a plane that faces either way somewhere below.
    scene.objects = {object({1.02, 0, 1.02}, {3, 3, 2.5})};
    for (const double up : {1.0, -1.0}) {
        scene.objects.resize(1);
        Object far;
        far.shape = Plane{{0, 0, 0.1}, {0, 0, up}};
        scene.objects.push_back(far);
        EXPECT_NEAR(endOf(scene, tenths(), {0.67, 1, 2}, steep).z, 1.02, 1e-6);
    }
}

TEST(LightEnd, LightBehindAPlaneEndsAtABlocker) {
    const auto plane = [](double z, Role role) {
        Object out;
        out.shape = Plane{{0, 0, z}, {0, 0, 1}}, out.role = role;
        return out;
    };
    Scene scene;
    scene.objects = {plane(1.02, Role::Receiver), plane(0.93, Role::Receiver)};
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 0.75, 1e-6) << "a second receiver is lit as well";
    scene.objects[1].role = Role::Blocker;
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 0.93, 1e-6);
    // The same where bodies stand, and those end it too.
    scene.objects.push_back(object({2.5, 2.5, 0.2}, {2.8, 2.8, 0.9}, Role::Blocker));
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 0.93, 1e-6);
    scene.objects[1].role = Role::Receiver;
    EXPECT_NEAR(endOf(scene, tenths(), {1, 1, 2}, {0, 0, -1}).z, 0.75, 1e-6);
    EXPECT_NEAR(endOf(scene, tenths(), {2.6, 2.6, 2}, {0, 0, -1}).z, 0.9, 1e-6);
    scene.objects[2].role = Role::Receiver;
    EXPECT_NEAR(endOf(scene, tenths(), {2.6, 2.6, 2}, {0, 0, -1}).z, 0.75, 1e-6) << "what is looked up is lit";
}

}  // namespace
}  // namespace photic
