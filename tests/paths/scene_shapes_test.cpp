// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/scene_shapes.h"

#include <gtest/gtest.h>

#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

Scene sceneWithABox() {
    Scene scene;
    scene.objects = {support::meshObject(support::boxMesh({-1, -1, -1}, {1, 1, 1})),
                     support::planeObject({0, 0, -2}, {0, 0, 1})};
    return scene;
}

TEST(SceneShapes, AreBuiltOnceWhereTheyAreTheSame) {
    const Scene scene = sceneWithABox();
    Scene lit = scene;  // another light, another grid, the same meshes
    lit.lights.emplace_back();
    const auto shapes = shapesOf(scene);
    EXPECT_EQ(shapesOf(lit), shapes);

    Scene lower = scene;
    std::get<Plane>(lower.objects[1].shape).point.z = -3;
    const auto moved = shapesOf(lower);
    EXPECT_NE(moved, shapes);
    EXPECT_NEAR(moved->caster.firstHit({3, 0, 0}, {0, 0, -1}).distance, 3, 1e-12);
    Scene passable = scene;
    passable.objects[0].role = Role::Movable;
    EXPECT_NE(shapesOf(passable), shapesOf(scene));
    Scene ball = scene;
    ball.surfaces.emplace_back();
    ball.surfaces.back().sphere = Sphere{{0, 0, 5}, 1};
    const auto small = shapesOf(ball);
    ball.surfaces.back().sphere->radius = 2;
    EXPECT_NE(shapesOf(ball), small);
}

TEST(SceneShapes, AreLetGoWithTheirLastHolder) {
    const Scene scene = sceneWithABox();
    std::weak_ptr<const SceneShapes> seen;
    {
        const HeldShapes held;
        seen = shapesOf(scene);
        EXPECT_FALSE(seen.expired());
        { const HeldShapes again; }
        EXPECT_EQ(shapesOf(scene), seen.lock());
    }
    EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace photic
