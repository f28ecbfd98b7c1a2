// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/closed_bodies.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

Object bodyOf(TriangleMesh mesh, Role role = Role::Receiver) {
    Object object;
    object.name = "body", object.role = role;
    object.shape = std::make_shared<const TriangleMesh>(std::move(mesh));
    return object;
}

TEST(ClosedBodies, HoldWhatLiesWithinBoxesAndBalls) {
    Scene scene;
    scene.objects = {bodyOf(boxMesh({-1, -1, -1}, {0, 1, 1})), bodyOf(boxMesh({-0.2, -1, -1}, {1, 1, 0})),
                     bodyOf(sphereMesh({5, 0, 0}, 1, 16))};
    const ClosedBodies bodies(scene);
    const std::vector<glm::dvec3> within{{-0.99, 0, 0},        {-0.001, 0.5, 0.5}, {-0.1, 0, -0.5},
                                         {0.5, 0.999, -0.001}, {5, 0, 0},          {5.5, 0.3, -0.6}};
    for (const glm::dvec3& p : within) EXPECT_TRUE(bodies.hold(p)) << p.x << ' ' << p.y << ' ' << p.z;
    const std::vector<glm::dvec3> beside{{-1.001, 0, 0}, {0.001, 0.5, 0.5}, {0.5, 1.001, -0.5}, {0.5, 0, 0.001},
                                         {5.9, 0.9, 0},  {5, 0, 1.001},     {100, 0, 0}};
    for (const glm::dvec3& p : beside) EXPECT_FALSE(bodies.hold(p)) << p.x << ' ' << p.y << ' ' << p.z;
}

TEST(ClosedBodies, MayBeWoundEitherWayAndOpenOnesHoldNothing) {
    TriangleMesh inwards = boxMesh({-1, -1, -1}, {1, 1, 1});
    for (auto& triangle : inwards.triangles) std::swap(triangle[1], triangle[2]);
    TriangleMesh open = boxMesh({9, -1, -1}, {11, 1, 1});
    open.triangles.pop_back();
    Scene scene;
    scene.objects = {bodyOf(inwards), bodyOf(open), bodyOf(boxMesh({19, -1, -1}, {21, 1, 1}), Role::Movable)};
    const ClosedBodies bodies(scene);
    EXPECT_TRUE(bodies.hold({0.3, 0.2, 0.1}));
    EXPECT_FALSE(bodies.hold({0.3, 0.2, 1.1}));
    EXPECT_FALSE(bodies.hold({10, 0, 0}));
    EXPECT_FALSE(bodies.hold({20, 0, 0}));  // what is moved about stops no light
}

}  // namespace
}  // namespace photic
