// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace photic {
namespace {

/// Small triangles all over a cube of 10 m about `centre`.
TriangleMesh confetti(int count, const glm::dvec3& centre, double size, std::mt19937& random) {
    std::uniform_real_distribution<> place(-5, 5), side(-size, size);
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 p = centre + glm::dvec3(place(random), place(random), place(random));
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(p + glm::dvec3(side(random), side(random), side(random)));
        const auto first = static_cast<std::uint32_t>(3 * i);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

Scene sceneOf(TriangleMesh mesh, Role role = Role::Receiver) {
    Scene scene;
    scene.objects.push_back({"mesh", "", std::make_shared<const TriangleMesh>(std::move(mesh)), role});
    return scene;
}

/// A cube about `centre`, turned about z.
ConvexRegion turnedCube(const glm::dvec3& centre, double half, double angle) {
    const glm::dvec3 u(std::cos(angle), std::sin(angle), 0), v(-std::sin(angle), std::cos(angle), 0), w(0, 0, 1);
    std::vector<glm::dvec3> points;
    ConvexRegion region;
    for (int c = 0; c < 8; ++c)
        points.push_back(centre +
                         half * ((c & 1 ? 1.0 : -1.0) * u + (c & 2 ? 1.0 : -1.0) * v + (c & 4 ? 1.0 : -1.0) * w));
    for (const glm::dvec3& p : points) region.include(p);
    for (const glm::dvec3& n : {u, -u, v, -v, w, -w}) region.addSide(n, points);
    return region;
}

TEST(TriangleTree, FindsWhatATestOfEveryTriangleFinds) {
    std::mt19937 random(3);
    for (const double far : {0.0, 1e6}) {
        const glm::dvec3 centre(far, -far, 0.5 * far);
        const Scene scene = sceneOf(confetti(3000, centre, 0.1, random));
        const TriangleMesh& mesh = *std::get<1>(scene.objects[0].shape);
        const TriangleTree tree(scene);
        std::uniform_real_distribution<> place(-5, 5);
        int found = 0;
        for (int i = 0; i < 500; ++i) {
            const ConvexRegion region =
                turnedCube(centre + glm::dvec3(place(random), place(random), place(random)), 0.2, place(random));
            bool expected = false;
            double towards = 0, away = 0;
            for (const auto& t : mesh.triangles) {
                bool touches = false;
                const std::array<glm::dvec3, 3> c = {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
                const double area = areaInside(region, c, {0, 0, -1}, touches);
                (glm::cross(c[1] - c[0], c[2] - c[0]).z > 0 ? towards : away) += area;
                expected = expected || touches;
            }
            EXPECT_EQ(tree.reaches(region), expected);
            EXPECT_NEAR(tree.shownArea(region, {0, 0, -1}), std::max(towards, away), 1e-9);
            found += expected;
        }
        EXPECT_GT(found, 50);
        EXPECT_LT(found, 450);
    }
}

TEST(TriangleTree, AFloorOfManyTrianglesShowsTheWholeOfARegion) {
    TriangleMesh floor;
    const int n = 60;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            floor.positions.push_back({0.1 * i - 3, 0.1 * j - 3, 0.02 * std::sin(i * 0.7 + j)});
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i), b = a + 1, c = a + n + 1, d = c + 1;
            floor.triangles.push_back({a, b, d}), floor.triangles.push_back({a, d, c});
        }
    const TriangleTree whole(sceneOf(floor));
    const ConvexRegion region = turnedCube({0.3, 0.2, 0}, 0.5, 0.4);
    EXPECT_NEAR(whole.shownArea(region, {0, 0, -1}), 1, 1e-9);
    floor.triangles.erase(floor.triangles.begin() + 2 * (33 * n + 33));
    EXPECT_NEAR(TriangleTree(sceneOf(floor)).shownArea(region, {0, 0, -1}), 0.995, 1e-6) << "a gap shows";
}

TEST(TriangleTree, MovablesAreNotThere) {
    std::mt19937 random(1);
    EXPECT_TRUE(TriangleTree(sceneOf(confetti(10, {0, 0, 0}, 1, random), Role::Movable)).empty());
    EXPECT_FALSE(TriangleTree(Scene{}).reaches(turnedCube({0, 0, 0}, 1, 0)));
}

TEST(TriangleTree, HoldsManyTrianglesAtOnePoint) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles.assign(5000, {0, 1, 2});
    const TriangleTree tree(sceneOf(mesh));
    EXPECT_TRUE(tree.reaches(turnedCube({0.2, 0.2, 0}, 0.1, 0)));
    EXPECT_FALSE(tree.reaches(turnedCube({2.2, 0.2, 0}, 0.1, 0)));
}

}  // namespace
}  // namespace photic
