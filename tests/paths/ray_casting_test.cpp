// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/ray_casting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

Object planeAt(const glm::dvec3& point, const glm::dvec3& normal, Role role = Role::Receiver) {
    Object o;
    o.name = "plane", o.shape = Plane{point, normal}, o.role = role;
    return o;
}

Object meshOf(TriangleMesh mesh, Role role = Role::Receiver) {
    Object o;
    o.name = "mesh", o.shape = std::make_shared<const TriangleMesh>(std::move(mesh)), o.role = role;
    return o;
}

Scene sceneOf(std::vector<Object> objects) {
    Scene scene;
    scene.objects = std::move(objects);
    return scene;
}

/// A bumpy sphere of 2 n^2 triangles about `centre`.
TriangleMesh bumpySphere(int n, const glm::dvec3& centre, double radius) {
    TriangleMesh mesh;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const double theta = M_PI * j / n, phi = 2 * M_PI * (i % n) / n,
                         r = radius * (1 + 0.2 * std::sin(5 * phi) * std::sin(4 * theta));
            mesh.positions.push_back(centre + r * glm::dvec3(std::sin(theta) * std::cos(phi),
                                                             std::sin(theta) * std::sin(phi), std::cos(theta)));
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i), b = a + 1,
                       c = a + static_cast<std::uint32_t>(n) + 1, d = c + 1;
            mesh.triangles.push_back({a, c, b}), mesh.triangles.push_back({b, c, d});
        }
    return mesh;
}

/// First hit by testing every triangle in double (Moeller and Trumbore 1997).
double bruteForce(const TriangleMesh& mesh, const glm::dvec3& o, const glm::dvec3& d, double from) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t[0]], e1 = mesh.positions[t[1]] - a, e2 = mesh.positions[t[2]] - a;
        const glm::dvec3 p = glm::cross(d, e2), s = o - a, q = glm::cross(s, e1);
        const double det = glm::dot(e1, p), u = glm::dot(s, p) / det, v = glm::dot(d, q) / det,
                     w = glm::dot(e2, q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && w > from) best = std::min(best, w);
    }
    return best;
}

struct Rays {
    std::mt19937_64 random{5};
    std::normal_distribution<double> normal;
    glm::dvec3 direction() { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); }
};

TEST(RayCasting, PlanesAreHitFromBothSides) {
    const RayCaster caster(sceneOf({planeAt({0, 0, -1}, {0, 0, 1}), planeAt({0, 0, -5}, {0, 0, 1}, Role::Blocker)}));
    EXPECT_TRUE(caster.planesOnly());
    EXPECT_FALSE(caster.empty());
    const RayHit down = caster.firstHit({3, 4, 1}, {0, 0, -1});
    EXPECT_EQ(down.target.index, 0);
    EXPECT_DOUBLE_EQ(down.distance, 2);
    EXPECT_EQ(down.normal, glm::dvec3(0, 0, 1));
    const RayHit up = caster.firstHit({3, 4, -3}, {0, 0, 1});
    EXPECT_EQ(up.target.index, 0);
    EXPECT_EQ(up.normal, glm::dvec3(0, 0, -1));
    EXPECT_EQ(caster.firstHit({0, 0, -3}, {0, 0, -1}).target.index, 1);
    EXPECT_FALSE(caster.firstHit({0, 0, 1}, {1, 0, 0}));
    EXPECT_FALSE(caster.firstHit({0, 0, 1}, {0, 0, -1}, 2.0)) << "a hit at the limit is ignored";
    EXPECT_TRUE(caster.firstHit({0, 0, 1}, {0, 0, -1}, 2.0000001));
    EXPECT_EQ(caster.firstHit({0.3, 0.7, -1}, {0, 0, -1}).target.index, 1)
        << "a ray does not hit the plane that it starts on";
}

TEST(RayCasting, MovablesAndEmptyMeshesNeverBlock) {
    EXPECT_TRUE(RayCaster(Scene{}).empty());
    const RayCaster caster(sceneOf(
        {planeAt({0, 0, -1}, {0, 0, 1}, Role::Movable), meshOf({}), meshOf(bumpySphere(8, {}, 1), Role::Movable)}));
    EXPECT_TRUE(caster.empty());
    EXPECT_FALSE(caster.firstHit({0, 0, 5}, {0, 0, -1}));
    TriangleMesh point;
    point.positions = {{1, 1, 1}};
    point.triangles = {{0, 0, 0}};
    EXPECT_FALSE(RayCaster(sceneOf({meshOf(point)})).firstHit({1, 1, 5}, {0, 0, -1}));
}

TEST(RayCasting, MeshesAgreeWithBruteForceAtAnyScale) {
    Rays rays;
    for (const double radius : {1e-6, 1.0, 1e9}) {
        const glm::dvec3 centre = radius * glm::dvec3(300, -200, 50);  // far from the world's origin for its size
        const TriangleMesh mesh = bumpySphere(24, centre, radius);
        const RayCaster caster(sceneOf({planeAt({0, 0, -1e15}, {0, 0, 1}), meshOf(mesh)}));
        EXPECT_FALSE(caster.planesOnly());
        int hits = 0, disagree = 0;
        for (int k = 0; k < 2000; ++k) {
            const glm::dvec3 origin = centre + radius * (k % 2 ? 3.0 : 0.2) * rays.direction();
            const glm::dvec3 target = centre + 0.9 * radius * rays.direction(),
                             direction = glm::normalize(target - origin);
            const double exact = bruteForce(mesh, origin, direction, 1e-5 * radius);
            const RayHit hit = caster.firstHit(origin, direction, 100 * radius);
            ASSERT_TRUE(hit || !std::isfinite(exact)) << "leaked through at scale " << radius;
            if (!std::isfinite(exact)) {
                ++disagree;
                continue;
            }
            ++hits;
            EXPECT_EQ(hit.target.index, 1);
            // Grazing hits at a silhouette may fall on either side of it in single precision.
            if (std::fabs(hit.distance - exact) > 1e-9 * radius) ++disagree;
            EXPECT_LE(glm::dot(hit.normal, direction), 0);
            EXPECT_NEAR(glm::length(hit.normal), 1, 1e-12);
        }
        EXPECT_GT(hits, 1500);
        EXPECT_LE(disagree, 4) << radius;
    }
}

TEST(RayCasting, FarOriginsKeepTheirDigits) {
    const TriangleMesh mesh = bumpySphere(24, {}, 1);
    const RayCaster caster(sceneOf({meshOf(mesh)}));
    Rays rays;
    for (int k = 0; k < 200; ++k) {
        const glm::dvec3 target = 0.5 * rays.direction(), direction = rays.direction(), near = target - 3.0 * direction;
        const RayHit close = caster.firstHit(near, direction), far = caster.firstHit(near - 1e6 * direction, direction);
        ASSERT_TRUE(close && far);
        EXPECT_NEAR(far.distance - 1e6, close.distance, 1e-8);
    }
}

TEST(RayCasting, RaysFromASurfaceDoNotHitIt) {
    const TriangleMesh mesh = bumpySphere(48, {7, 7, 7}, 2);
    const RayCaster caster(sceneOf({meshOf(mesh)}));
    Rays rays;
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]],
                         area = glm::cross(b - a, c - a);
        if (glm::length(area) < 1e-9) continue;
        const glm::dvec3 point = 0.3 * a + 0.3 * b + 0.4 * c,
                         out = glm::normalize(area) * (glm::dot(area, point - 7.0) > 0 ? 1.0 : -1.0);
        const RayHit hit = caster.firstHit(point, out);
        EXPECT_TRUE(!hit || hit.distance > 1e-3) << hit.distance;
    }
}

TEST(RayCasting, NoLeakBetweenTriangles) {
    // Straight at shared edges and vertices of a closed sphere.
    const TriangleMesh mesh = bumpySphere(16, {}, 1);
    const RayCaster caster(sceneOf({meshOf(mesh)}));
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 a = mesh.positions[t[static_cast<std::size_t>(k)]],
                             b = mesh.positions[t[static_cast<std::size_t>((k + 1) % 3)]];
            for (const glm::dvec3& target : {a, 0.5 * (a + b), 0.25 * a + 0.75 * b}) {
                const RayHit hit = caster.firstHit(glm::dvec3(0), glm::normalize(target));
                ASSERT_TRUE(hit) << "leaked";
                EXPECT_NEAR(hit.distance, glm::length(target), 1e-4);
            }
        }
}

TEST(RayCasting, ObjectsAndSpecularMeshesAreToldApart) {
    Scene scene = sceneOf({planeAt({0, 0, -2}, {0, 0, 1})});
    scene.surfaces.resize(2);
    scene.surfaces[1].mesh = std::make_shared<const TriangleMesh>(bumpySphere(8, {}, 1));
    const RayCaster caster(scene);
    EXPECT_EQ(caster.firstHit({0, 0.01, 5}, {0, 0, -1}).target, (Target{Target::Kind::Surface, 1}));
    EXPECT_EQ(caster.firstHit({2, 0.01, 5}, {0, 0, -1}).target, (Target{Target::Kind::Object, 0}));
}

// A glass on a table: its foot's lower face and the table's are one, and rounding must not choose between them.
TEST(RayCasting, WhatStandsOnAPlaneEndsThere) {
    Scene scene = sceneOf({planeAt({0, 0, 0}, {0, 0, 1})});
    Surface foot;
    foot.mesh = std::make_shared<const TriangleMesh>(boxMesh({-1, -1, 0}, {1, 1, 0.5}));
    scene.surfaces = {foot};
    const RayCaster caster(scene);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-0.9, 0.9);
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 from(uniform(random), uniform(random), 0.4), to(uniform(random), uniform(random), 0);
        ASSERT_EQ(caster.firstHit(from, glm::normalize(to - from)).target.kind, Target::Kind::Object) << i;
    }
    EXPECT_EQ(caster.firstHit({0, 0, 1}, {0, 0, -1}).target.kind, Target::Kind::Surface) << "its top is its own";
}

TEST(RayCasting, AHitKnowsItsTriangle) {
    const TriangleMesh mesh = bumpySphere(24, {}, 1);
    const RayCaster caster(sceneOf({meshOf(mesh)}));
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(std::sin(i * 1.1), std::cos(i * 2.3), std::sin(i * 0.7 + 1)));
        const RayHit hit = caster.firstHit(3.0 * d, -d);
        ASSERT_TRUE(hit);
        const auto& t = mesh.triangles[hit.triangle];
        const double b = hit.barycentric.x, c = hit.barycentric.y;
        const glm::dvec3 p = (1 - b - c) * mesh.positions[t[0]] + b * mesh.positions[t[1]] + c * mesh.positions[t[2]];
        EXPECT_LT(glm::length(p - (3.0 - hit.distance) * d), 2e-6);
    }
}

TEST(RayCasting, ARayThatIsNotFiniteHitsNothing) {
    const RayCaster caster(sceneOf({meshOf(bumpySphere(8, {}, 1)), planeAt({0, 0, -2}, {0, 0, 1})}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(caster.firstHit({nan, 0, 5}, {0, 0, -1}));
    EXPECT_FALSE(caster.firstHit({0, 0, 5}, {0, nan, -1}));
    EXPECT_FALSE(caster.firstHit({0, 0, std::numeric_limits<double>::infinity()}, {0, 0, -1}));
}

// In single precision a ray that leaves its face at a sixth of a degree is still on it, farther than any offset.
TEST(RayCasting, ARayThatGrazesItsOwnFaceLeavesIt) {
    const glm::dvec3 right = glm::normalize(glm::dvec3(0.9, 0.3, -0.2)),
                     up = glm::normalize(glm::cross(glm::dvec3(0.1, 0.2, 1), right)), normal = glm::cross(right, up);
    TriangleMesh pane;
    for (const glm::dvec2& corner : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)})
        pane.positions.push_back(corner.x * right + corner.y * up);
    pane.triangles = {{0, 1, 2}, {0, 2, 3}};
    const RayCaster caster(sceneOf({meshOf(pane)}));
    int met = 0, missed = 0;
    for (int k = 0; k < 4000; ++k) {
        const double x = std::fmod(0.754877 * k, 1.0) - 0.5, y = std::fmod(0.569840 * k, 1.0) - 0.5, turn = 0.37 * k;
        const glm::dvec3 point = x * right + y * up;
        const glm::dvec3 way =
            glm::normalize(std::cos(turn) * right + std::sin(turn) * up + (k % 2 ? 0.0028 : -0.0028) * normal);
        met += caster.firstHit(point, way) ? 1 : 0;
        missed += std::fabs(caster.firstHit(point - 0.3 * way, way).distance - 0.3) < 1e-9 ? 0 : 1;
    }
    EXPECT_EQ(met, 0);
    EXPECT_EQ(missed, 0);
}

// Rays through faces that two bodies share, and through edges, along which they meet two triangles.
TEST(RayCasting, APointIsInsideOfABodyOrNot) {
    TriangleMesh sheet;
    sheet.positions = {{-5, -5, 3}, {5, -5, 3}, {0, 5, 3}}, sheet.triangles = {{0, 1, 2}};
    for (const double far : {0.0, 1e5}) {
        const glm::dvec3 at(far, -far, far);
        std::vector<Object> objects;
        for (int i = 0; i < 3; ++i)
            objects.push_back(meshOf(boxMesh(at + glm::dvec3(-1, -1, -i - 1), at + glm::dvec3(1, 1, -i))));
        TriangleMesh moved = sheet;
        for (glm::dvec3& p : moved.positions) p += at;
        objects.push_back(meshOf(moved));
        const Scene scene = sceneOf(std::move(objects));
        const RayCaster caster(scene);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> any(-1, 1);
        for (int i = 0; i < 300; ++i) {
            // Straight down, through the diagonals of the faces that the boxes share, or anywhere.
            const glm::dvec3 direction =
                i % 3 == 0 ? glm::dvec3(0, 0, -1) : glm::normalize(glm::dvec3(any(random), any(random), any(random)));
            const double x = any(random) * 0.99, y = i % 3 == 0 ? x : any(random) * 0.99;
            const glm::dvec3 within(x, y, -0.01 - 2.98 * std::fabs(any(random)));
            EXPECT_TRUE(caster.insideBody(at + within, direction)) << i;
            EXPECT_FALSE(caster.insideBody(at + glm::dvec3(x, y, 0.01 + 2 * std::fabs(x)), direction)) << i;
            EXPECT_FALSE(caster.insideBody(at + glm::dvec3(1.01, x, y), direction)) << i;
        }
        EXPECT_FALSE(caster.insideBody(at, glm::dvec3(std::nan(""), 0, 0)));
    }
}

TEST(RayCasting, ThreadsShareACaster) {
    const TriangleMesh mesh = bumpySphere(32, {}, 1);
    const RayCaster caster(sceneOf({meshOf(mesh)}));
    std::vector<double> serial(4000);
    const auto cast = [&](std::int64_t k) {
        const double phi = 0.001 * static_cast<double>(k);
        const glm::dvec3 origin(3 * std::cos(phi), 3 * std::sin(phi), 0.3 * std::sin(7 * phi));
        return caster.firstHit(origin, glm::normalize(-origin)).distance;
    };
    for (std::size_t k = 0; k < serial.size(); ++k) serial[k] = cast(static_cast<std::int64_t>(k));
    std::atomic<int> wrong{0};
    parallelFor(4000, [&](std::int64_t k) { wrong += cast(k) != serial[static_cast<std::size_t>(k)]; });
    EXPECT_EQ(wrong, 0);
}

TEST(RayCasting, BrokenMeshesAreRefused) {
    TriangleMesh broken = bumpySphere(4, {}, 1);
    broken.positions[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(RayCaster(sceneOf({meshOf(broken)})), Error);
    TriangleMesh dangling = bumpySphere(4, {}, 1);
    dangling.triangles[2][1] = 100000;
    EXPECT_THROW(RayCaster(sceneOf({meshOf(dangling)})), Error);
    TriangleMesh endless = bumpySphere(4, {}, 1e200);
    EXPECT_THROW(RayCaster(sceneOf({meshOf(endless)})), Error);
}

}  // namespace
}  // namespace photic
