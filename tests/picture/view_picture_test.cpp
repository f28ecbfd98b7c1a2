// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "bake/optics/snell.h"
#include "bake/picture/view_scene.h"
#include "bake/report/error.h"
#include "tests/picture/volumes.h"

namespace photic {
namespace {

constexpr double kDepth = 1.25;

class FlatWater final : public HeightField {
public:
    SurfacePoint at(glm::dvec2 uv) const override { return {{uv.x, uv.y, 0}, {0, 0, 1}}; }
    double minZ() const override { return 0; }
    double maxZ() const override { return 0; }
    double featureSize() const override { return std::numeric_limits<double>::infinity(); }
};

Scene tank(bool water) {
    Scene scene;
    scene.domain.min = {-1, -1, -1.5};
    scene.domain.max = {1, 1, 0.25};
    scene.domain.voxel_size = 0.125;
    scene.objects.push_back({"floor", "", Plane{{0, 0, -kDepth}, {0, 0, 1}}, Role::Receiver});
    if (water) {
        Surface surface;
        surface.height_field = std::make_shared<FlatWater>();
        scene.surfaces.push_back(surface);
    }
    return scene;
}

LightVolume lit(double irradiance) {
    return test::makeVolume(test::cubicFrame(0.125, {-10, -10, -14}, {9, 9, 3}), 1, [=](const glm::ivec3&) {
        return std::vector<double>{irradiance, 0, 0, -irradiance};
    });
}

ViewSettings camera(const glm::dvec3& eye, const glm::dvec3& target) {
    ViewSettings view;
    view.eye = eye;
    view.target = target;
    view.width = view.height = 1;
    view.field_of_view_deg = 0.5;
    view.samples = 1;
    view.ambient = 0;
    view.albedo = glm::dvec3(0.5);
    view.look = ViewLook::Natural;
    return view;
}

/// What the baked light alone adds to the middle of a view: sky and tint of the picture cancel.
glm::dvec3 bakedRadiance(const Scene& scene, const ViewSettings& view) {
    const Image with = viewPicture(scene, lit(100), view), without = viewPicture(scene, lit(0), view);
    return {with.at(0, 0, 0) - without.at(0, 0, 0), with.at(0, 0, 1) - without.at(0, 0, 1),
            with.at(0, 0, 2) - without.at(0, 0, 2)};
}

TEST(ViewPicture, AReceiverInAirShowsAlbedoTimesIrradiance) {
    const glm::dvec3 radiance = bakedRadiance(tank(false), camera({0.1, 0.2, 3}, {0.1, 0.2, 0}));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], 0.5 / std::numbers::pi * 100, 1e-4);
}

TEST(ViewPicture, RadianceFromTheWaterIsScaledByIndexFresnelAndAbsorption) {
    Scene scene = tank(true);
    scene.medium.absorption = {0.35, 0.07, 0.02};
    for (const double tilt : {0.0, 0.4, 0.8}) {
        // Aim so that the ray meets the surface at the origin, tilt radians from the vertical.
        const glm::dvec3 d(std::sin(tilt), 0, -std::cos(tilt));
        const glm::dvec3 radiance = bakedRadiance(scene, camera(-4.0 * d, glm::dvec3(0)));
        const Interface split = interfaceAt(d, {0, 0, 1}, 1.0, 1.333);
        const double path = kDepth / -split.refracted.z;
        for (int c = 0; c < 3; ++c) {
            const double expected = 0.5 / std::numbers::pi * 100 * split.transmittance / (1.333 * 1.333) *
                                    std::exp(-scene.medium.absorption[c] * path);
            EXPECT_NEAR(radiance[c], expected, 2e-4 * expected) << tilt;
        }
    }
}

TEST(ViewPicture, SingleScatteringMatchesItsIntegral) {
    Scene scene = tank(true);
    scene.medium.scattering = glm::dvec3(0.4);
    scene.medium.anisotropy = 0;
    ViewSettings view = camera({0, 0, 3}, {0, 0, 0});
    view.albedo = glm::dvec3(0);
    view.march_steps = 2000;
    // Isotropic: E / (4 pi) (1 - exp(-sigma d)), seen through the surface.
    const double through = interfaceAt({0, 0, -1}, {0, 0, 1}, 1.0, 1.333).transmittance / (1.333 * 1.333);
    const double expected = 100 / (4 * std::numbers::pi) * -std::expm1(-0.4 * kDepth) * through;
    EXPECT_NEAR(bakedRadiance(scene, view).x, expected, 2e-3 * expected);
    view.shaft_scattering = 0;
    EXPECT_NEAR(bakedRadiance(scene, view).x, 0, 1e-6);
}

TEST(ViewPicture, ACutawayLooksStraightThroughTheSurface) {
    Scene scene = tank(true);
    scene.medium.absorption = {0.35, 0.07, 0.02};
    const double tilt = 0.4;
    const glm::dvec3 d(std::sin(tilt), 0, -std::cos(tilt));
    ViewSettings view = camera(-4.0 * d, glm::dvec3(0));
    view.look = ViewLook::Cutaway;
    const glm::dvec3 radiance = bakedRadiance(scene, view);
    const double transmittance = interfaceAt(d, {0, 0, 1}, 1.0, 1.333).transmittance;
    for (int c = 0; c < 3; ++c) {
        const double expected = 0.5 / std::numbers::pi * 100 * transmittance *
                                std::exp(-scene.medium.absorption[c] * kDepth / std::cos(tilt));
        EXPECT_NEAR(radiance[c], expected, 2e-4 * expected);
    }
    // Through an open side there is no surface at all; a natural look shows a wall there.
    view.eye = {-5, 0, 0};
    view.target = {0, 0, -1.25};
    EXPECT_GT(bakedRadiance(scene, view).x, 1);
    view.look = ViewLook::Natural;
    EXPECT_EQ(bakedRadiance(scene, view).x, 0);
}

TEST(ViewPicture, ShowsNothingBesideTheDomain) {
    const Image beside = viewPicture(tank(true), lit(100), camera({5, 0, 3}, {5, 0, 0}));
    EXPECT_EQ(beside.at(0, 0, 3), 0.0F);
    EXPECT_EQ(viewPicture(tank(true), lit(100), camera({0, 0, 3}, {0, 0, 0})).at(0, 0, 3), 1.0F);
}

TEST(ViewPicture, WallsAreSeenFromTheirLitSideOnly) {
    Scene scene = tank(false);
    scene.objects.push_back({"east", "", Plane{{0.9, 0, 0}, {-1, 0, 0}}, Role::Receiver});
    ViewScene view(scene);
    // From the east the wall is not there: the ray goes on to the floor; from the west it is met.
    const glm::dvec3 down_west = glm::normalize(glm::dvec3(-1, 0, -1)), east = {1, 0, 0};
    const ViewInterval room = view.clip({1.5, 0, 0}, down_west);
    ASSERT_TRUE(room);
    EXPECT_NEAR(room.enter, 0.6 * std::sqrt(2.0), 1e-12);
    EXPECT_EQ(view.receiver({1.5, 0, 0}, down_west, room.exit, room).object, 0);
    const ViewInterval other = view.clip({-3, 0, -0.5}, east);
    EXPECT_EQ(view.receiver({-3, 0, -0.5}, east, other.exit, other).object, 1);
    EXPECT_NEAR(other.exit, 3.9, 1e-12);
}

TEST(ViewPicture, DefaultCameraSeesTheWholeDomainFromItsOpenSide) {
    Scene scene = tank(true);
    scene.objects.push_back({"east", "", Plane{{1, 0, 0}, {-1, 0, 0}}, Role::Receiver});
    const ViewSettings view = defaultView(scene);
    EXPECT_LT(view.eye.x, -1);
    EXPECT_GT(view.eye.z, 1);
    const glm::dvec3 forward = glm::normalize(view.target - view.eye);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1))), up = glm::cross(right, forward);
    const double half = std::tan(view.field_of_view_deg * std::numbers::pi / 360);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 0.25 : -1.5) - view.eye;
        EXPECT_LT(std::fabs(glm::dot(p, up) / glm::dot(p, forward)), half);
        EXPECT_LT(std::fabs(glm::dot(p, right) / glm::dot(p, forward)), half * view.width / view.height);
    }
}

TEST(ViewPicture, RefusesACameraWithoutADirection) {
    EXPECT_THROW(viewPicture(tank(true), lit(1), camera({0, 0, 1}, {0, 0, 1})), Error);
}

}  // namespace
}  // namespace photic
