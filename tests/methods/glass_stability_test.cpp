// SPDX-License-Identifier: Apache-2.0
// Glass and mirrors in states that nobody means: no value that is not finite, ledgers that close, and an end.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bake/methods/beams.h"
#include "bake/methods/photons.h"
#include "tests/methods/glass_scene.h"

namespace photic {
namespace {

using test::GlassScene;
using test::option;

/// Bakes by tubes and by photons; both must stand what they are given.
BakeResult expectSound(const GlassScene& glass, double allowed = 1e-5) {
    const BakeResult photons = glass.bake(photonsMethod(), option("count", std::int64_t{20'000}));
    BakeResult tubes = glass.bake(beamsMethod());
    for (const BakeResult* result : {&photons, static_cast<const BakeResult*>(&tubes)}) {
        EXPECT_TRUE(std::isfinite(result->report.power.emitted));
        EXPECT_LT(result->report.power.imbalance(), allowed);
        EXPECT_LT(result->report.path.imbalance(), 1e-4);
        const GridFrame& f = result->field.frame();
        for (int x = f.min.x; x <= f.max.x; ++x)
            for (int y = f.min.y; y <= f.max.y; ++y)
                for (int z = f.min.z; z <= f.max.z; ++z) {
                    const double e = result->field.irradiance({x, y, z});
                    const glm::dvec3 flux = result->field.flux({x, y, z});
                    if (std::isfinite(e) && e >= 0 && glm::length(flux) <= 1.0001 * e + 1e-9) continue;
                    ADD_FAILURE() << "voxel " << x << " " << y << " " << z << " holds " << e;
                    return tubes;
                }
    }
    return tubes;
}

TriangleMesh ballMesh(int rings = 12) { return support::sphereMesh(rings, {0.05, -0.03, 0.1}, 0.4); }

TEST(GlassStability, GrazingLight) {
    for (const double degrees : {80.0, 89.0, 89.9, 89.999}) {
        const double angle = degrees * std::numbers::pi / 180;
        GlassScene glass(20, {std::sin(angle), 0, -std::cos(angle)});
        glass.add(support::boxMesh({-0.7, -0.7, -0.6}, {0.7, 0.7, -0.2}), SurfaceEvent::Both).smooth = false;
        SCOPED_TRACE(degrees);
        const BakeResult r = expectSound(glass);
        // The side that faces the light, and the top.
        const double exact = std::sin(angle) * 1.4 * 0.4 + std::cos(angle) * 1.4 * 1.4;
        EXPECT_NEAR(r.report.power.emitted / exact, 1, 1e-3);
    }
}

TEST(GlassStability, SurfacesThatCoincide) {
    for (const int higher : {0, 1}) {
        GlassScene glass(20, {0.2, 0.1, -1});
        Medium wine;
        wine.name = "wine", wine.ior = 1.34, wine.absorption = {1, 2, 3}, wine.priority = higher;
        glass.scene.media.push_back(wine);
        glass.add(support::boxMesh({-0.5, -0.5, -0.3}, {0.5, 0.5, 0.1}), SurfaceEvent::Both).smooth = false;
        Surface& above = glass.add(support::boxMesh({-0.5, -0.5, 0.1}, {0.5, 0.5, 0.4}), SurfaceEvent::Both);
        above.smooth = false, above.medium_below = 2, above.name = "wine";
        // The floor lies in the lower body's bottom.
        glass.scene.objects = {support::planeObject({0, 0, -0.3}, {0, 0, 1})};
        expectSound(glass);
    }
}

TEST(GlassStability, SliversAndTrianglesWithoutArea) {
    GlassScene glass(20, {0.2, 0.1, -1});
    TriangleMesh mesh = ballMesh();
    const auto first = mesh.triangles.front();
    mesh.triangles.push_back({first[0], first[0], first[1]});
    mesh.triangles.push_back({first[1], first[1], first[1]});
    const auto n = static_cast<std::uint32_t>(mesh.positions.size());
    for (const double x : {-0.3, 0.0, 0.3}) {
        mesh.positions.emplace_back(x, 1e-13 * x, 0.7), mesh.normals.emplace_back(0, 0, 1);
    }
    mesh.triangles.push_back({n, n + 1, n + 2});
    glass.add(std::move(mesh), SurfaceEvent::Both);
    expectSound(glass);
}

TEST(GlassStability, FlippedDuplicateAndOpenMeshes) {
    for (int kind = 0; kind < 3; ++kind) {
        GlassScene glass(20, {0.2, 0.1, -1});
        TriangleMesh mesh = ballMesh();
        bool closed = true;
        if (kind == 0) {  // wound inwards
            for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
            for (auto& normal : mesh.normals) normal = -normal;
        } else if (kind == 1) {  // each face there twice
            const auto faces = mesh.triangles;
            mesh.triangles.insert(mesh.triangles.end(), faces.begin(), faces.end());
        } else {  // with a hole in its side
            mesh.triangles.erase(mesh.triangles.begin() + 40, mesh.triangles.begin() + 90);
            closed = false;
        }
        SCOPED_TRACE(kind);
        glass.add(std::move(mesh), SurfaceEvent::Both).closed = closed;
        // Light that enters by a hole and is inside of nothing is lost from the books of photons alone.
        expectSound(glass);
    }
}

TEST(GlassStability, IndicesFromOneToFour) {
    for (const double ior : {1.0, 1.0 + 1e-9, 1.01, 2.4, 4.0, 0.75}) {
        GlassScene glass(20, {0.2, 0.1, -1});
        glass.scene.media[1].ior = ior;
        glass.addSphere({0.05, -0.03, 0.1}, 0.4, SurfaceEvent::Both);
        SCOPED_TRACE(ior);
        const BakeResult r = expectSound(glass);
        if (ior < 1.001 && ior >= 1) {
            // Light goes straight through: what is below is what the sun sends.
            EXPECT_NEAR(r.field.irradiance({0, 0, -8}), 1, 2e-3);
        }
    }
}

TEST(GlassStability, FarFromTheOrigin) {
    const glm::dvec3 sun(0.2, 0.1, -1);
    GlassScene near(20, sun);
    near.addSphere({0.05, -0.03, 0.1}, 0.4, SurfaceEvent::Both);
    const BakeResult here = expectSound(near);
    GlassScene far(20, sun);
    const glm::dvec3 away(1e6, -1e6, 1e6);
    far.addSphere(away + glm::dvec3(0.05, -0.03, 0.1), 0.4, SurfaceEvent::Both);
    far.frame.origin_world += away;
    far.scene.domain.min += away, far.scene.domain.max += away;
    const BakeResult there = expectSound(far);
    EXPECT_LT(test::relativeL1(there.field, here.field), 0.01);
    GlassScene mesh(20, sun);
    TriangleMesh ball = ballMesh(24);
    for (glm::dvec3& p : ball.positions) p += away;
    mesh.add(std::move(ball), SurfaceEvent::Both).center = away;
    mesh.frame.origin_world += away;
    mesh.scene.domain.min += away, mesh.scene.domain.max += away;
    EXPECT_LT(test::relativeL1(expectSound(mesh).field, here.field), 0.08);
}

TEST(GlassStability, VoxelsLargerThanTheObject) {
    for (const SurfaceEvent event : {SurfaceEvent::Both, SurfaceEvent::Mirror}) {
        GlassScene glass(4, {0.2, 0.1, -1});  // of half a metre
        glass.addSphere({0.05, -0.03, 0.1}, 0.04, event);
        const BakeResult r = expectSound(glass);
        EXPECT_NEAR(r.report.power.emitted / (std::numbers::pi * 0.0016), 1, 0.05);
    }
}

}  // namespace
}  // namespace photic
