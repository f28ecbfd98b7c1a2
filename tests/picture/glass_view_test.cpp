// SPDX-License-Identifier: Apache-2.0
// Eye rays through glass and off mirrors, and receivers that are meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/picture/receiver_picture.h"
#include "bake/picture/view_picture.h"
#include "bake/scene/mesh_file.h"
#include "tests/picture/volumes.h"

namespace photic {
namespace {

/// A floor at z = -1 and a volume whose light on it grows with x: radiance tells where an eye ray lands.
Scene room() {
    Scene scene;
    scene.domain.min = {-2, -2, -1.25};
    scene.domain.max = {2, 2, 1};
    scene.domain.voxel_size = 0.125;
    scene.objects.push_back({"floor", "", Plane{{0, 0, -1}, {0, 0, 1}}, Role::Receiver});
    Medium air, glass;
    air.name = "air", glass.name = "glass", glass.ior = 1.5;
    scene.media = {air, glass};
    return scene;
}

LightVolume rampOfLight() {
    return test::makeVolume(test::cubicFrame(0.125, {-18, -18, -12}, {17, 17, 9}), 1, [](const glm::ivec3& voxel) {
        const double e = 100 + 40 * 0.125 * (voxel.x + 0.5);
        return std::vector<double>{e, 0, 0, -e};
    });
}

Surface body(TriangleMesh mesh, SurfaceEvent event) {
    Surface surface;
    surface.name = "body", surface.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
    surface.event = event, surface.closed = true, surface.smooth = false;
    surface.medium_above = 0, surface.medium_below = 1;
    return surface;
}

ViewSettings camera(const glm::dvec3& eye, const glm::dvec3& target, int pixels = 1) {
    ViewSettings view;
    view.eye = eye, view.target = target;
    view.width = view.height = pixels;
    view.field_of_view_deg = pixels == 1 ? 0.01 : 30;
    view.samples = 1, view.ambient = 0, view.albedo = glm::dvec3(0.5);
    return view;
}

/// Where on the floor a pixel of this radiance lies.
double landing(double radiance) { return (radiance * std::numbers::pi / 0.5 - 100) / 40; }

TEST(GlassView, ASlabShiftsWhatIsBehindItAndDimsItByItsFaces) {
    Scene scene = room();
    scene.surfaces = {body(boxMesh({-1.5, -1.5, -0.5}, {1.5, 1.5, -0.1}), SurfaceEvent::Both)};
    const double angle = 0.6, thickness = 0.4, inner = std::asin(std::sin(angle) / 1.5);
    const glm::dvec3 d(std::sin(angle), 0, -std::cos(angle));
    const double t = landing(viewPicture(room(), rampOfLight(), camera(-1.5 * d, glm::dvec3(0))).at(0, 0, 0));
    EXPECT_NEAR(t, std::tan(angle), 1e-3) << "without the slab";
    // Both faces, and light that goes to and fro between them: (1 - R) / (1 + R) all in all, a little displaced.
    const double rs = std::sin(angle - inner) / std::sin(angle + inner);
    const double rp = std::tan(angle - inner) / std::tan(angle + inner), r = 0.5 * (rs * rs + rp * rp);
    const double shift = thickness * (std::tan(angle) - std::tan(inner));
    double expected = 0;
    for (int k = 0; k < 3; ++k)
        expected += (1 - r) * (1 - r) * std::pow(r, 2 * k) *
                    (100 + 40 * (std::tan(angle) - shift + 2 * k * thickness * std::tan(inner)));
    const Image seen = viewPicture(scene, rampOfLight(), camera(-1.5 * d, glm::dvec3(0)));
    EXPECT_NEAR(seen.at(0, 0, 0) * std::numbers::pi / 0.5 / expected, 1, 2e-3);
}

TEST(GlassView, GlassOfIndexOneIsNotSeen) {
    Scene scene = room();
    scene.media[1].ior = 1.0;
    Surface ball = body(sphereMesh({0, 0, -0.4}, 0.5, 24), SurfaceEvent::Refract);
    ball.sphere = Sphere{{0, 0, -0.4}, 0.5};
    scene.surfaces = {ball};
    const Image with = viewPicture(scene, rampOfLight(), camera({0.3, -0.5, 3}, {0, 0, -0.5}, 24));
    const Image without = viewPicture(room(), rampOfLight(), camera({0.3, -0.5, 3}, {0, 0, -0.5}, 24));
    for (std::size_t i = 0; i < with.pixels.size(); ++i) ASSERT_NEAR(with.pixels[i], without.pixels[i], 1e-3f) << i;
}

TEST(GlassView, AMirrorShowsWhatStandsBeforeIt) {
    Scene scene = room();
    Surface mirror = body(boxMesh({0.5, -1.5, -0.9}, {0.6, 1.5, 0.9}), SurfaceEvent::Mirror);
    mirror.colour = {0.9, 0.8, 0.7};
    scene.surfaces = {mirror};
    // Down and to the right, back from x = 0.5, onto the floor.
    const glm::dvec3 d = glm::normalize(glm::dvec3(1, 0, -1));
    const glm::dvec3 eye = glm::dvec3(0.5, 0, -0.2) - 0.4 * d;
    const Image seen = viewPicture(scene, rampOfLight(), camera(eye, eye + d));
    const double expected = 0.5 / std::numbers::pi * (100 + 40 * (0.5 - 0.8));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen.at(0, 0, c) / (expected * mirror.colour[c]), 1, 1e-3);
}

TEST(GlassView, ASunOfItsOwnLightsWhatNothingShades) {
    Scene scene = room();
    Light sun;
    sun.direction = {0, 0, -1}, sun.irradiance = glm::dvec3(100);
    scene.lights = {sun};
    scene.surfaces = {body(boxMesh({-0.5, -0.5, 0}, {0.5, 0.5, 0.4}), SurfaceEvent::Both)};
    const LightVolume dark = test::makeVolume(test::cubicFrame(0.125, {-18, -18, -12}, {17, 17, 9}), 1,
                                              [](const glm::ivec3&) { return std::vector<double>(4, 0.0); });
    const auto at = [&](double x) { return viewPicture(scene, dark, camera({x, -3, -0.5}, {x, 0, -1})).at(0, 0, 0); };
    EXPECT_NEAR(at(1.2), 0.5 / std::numbers::pi * 100, 1e-3) << "in the sun";
    EXPECT_NEAR(at(0), 0, 1e-6) << "the volume, not the picture, knows what comes through glass";
}

TEST(MeshReceiver, AMapShowsItsLightFromAboveByItsOwnNormals) {
    Scene scene = room();
    // A ramp that rises with x by one in two.
    TriangleMesh ramp;
    ramp.positions = {{-1, -1, -1}, {1, -1, 0}, {1, 1, 0}, {-1, 1, -1}};
    ramp.triangles = {{0, 1, 2}, {0, 2, 3}};
    const glm::dvec3 n = glm::normalize(glm::dvec3(-0.5, 0, 1));
    ramp.normals.assign(4, n);
    scene.objects.push_back({"ramp", "", std::make_shared<const TriangleMesh>(ramp), Role::Receiver});
    EXPECT_EQ(receiverNames(scene), (std::vector<std::string>{"floor", "ramp"}));
    const Image map = receiverPicture(rampOfLight(), scene, "ramp", 16);
    ASSERT_EQ(map.width, 16);
    ASSERT_EQ(map.height, 16);
    for (int x = 0; x < 16; ++x) {
        const double at = -1 + (x + 0.5) / 8;
        EXPECT_NEAR(map.at(x, 7, 0), n.z * (100 + 40 * at), 0.05) << x;
    }
}

TEST(MeshReceiver, AViewShowsItAndItsShadowInTheSun) {
    Scene scene = room();
    scene.objects.push_back(
        {"box", "", std::make_shared<const TriangleMesh>(boxMesh({-0.5, -0.5, -1}, {0.5, 0.5, -0.5})), Role::Receiver});
    Light sun;
    sun.direction = glm::normalize(glm::dvec3(1, 0, -1)), sun.irradiance = glm::dvec3(100);
    scene.lights = {sun};
    const LightVolume dark = test::makeVolume(test::cubicFrame(0.125, {-18, -18, -12}, {17, 17, 9}), 1,
                                              [](const glm::ivec3&) { return std::vector<double>(4, 0.0); });
    const auto from_above = [&](double x) {
        return viewPicture(scene, dark, camera({x, 0.01, 5}, {x, 0, -1})).at(0, 0, 0);
    };
    const double lit = 0.5 / std::numbers::pi * 100 * std::sqrt(0.5);
    EXPECT_NEAR(from_above(0), lit, 1e-2) << "the box's top";
    EXPECT_NEAR(from_above(0.75), 0, 1e-6) << "its shadow, half a metre long";
    EXPECT_NEAR(from_above(1.25), lit, 1e-2) << "the floor beyond";
}

}  // namespace
}  // namespace photic
