// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/launch_domain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "bake/paths/emission.h"
#include "bake/paths/specular_event.h"

namespace photic {
namespace {

/// Two crossed waves, optionally displaced sideways.
class Waves final : public HeightField {
public:
    Waves(double amplitude, double displacement) : a_(amplitude), d_(displacement) {}
    SurfacePoint at(glm::dvec2 p) const override {
        const double x = p.x * k_, y = p.y * k_;
        const glm::dvec3 u(1 + d_ * k_ * std::cos(x), 0, a_ * k_ * std::cos(x)), v(0, 1, -a_ * k_ * std::sin(y));
        return {{p.x + d_ * std::sin(x), p.y, a_ * (std::sin(x) + std::cos(y))}, glm::cross(u, v)};
    }
    double minZ() const override { return -2 * a_; }
    double maxZ() const override { return 2 * a_; }
    double maxDisplacement() const override { return d_; }
    double featureSize() const override {
        return a_ == 0 ? std::numeric_limits<double>::infinity() : 2 * M_PI / k_ / 8;
    }

private:
    double a_, d_, k_ = 7;
};

struct Case {
    double zenith = 0.5, amplitude = 0.05, displacement = 0, disc = 0;
    SurfaceEvent event = SurfaceEvent::Refract;
    glm::dvec2 shear{0};
    double z_low = -1.5, z_high = 0.2;
};

struct Pool {
    Scene scene;
    GridFrame frame;
    explicit Pool(const Case& c) {
        Light sun;
        sun.direction = {0.6 * std::sin(c.zenith), -0.8 * std::sin(c.zenith), -std::cos(c.zenith)};
        sun.angular_diameter_deg = c.disc;
        Surface water;
        water.height_field = std::make_shared<Waves>(c.amplitude, c.displacement);
        water.size = {4, 4}, water.event = c.event;
        scene.lights = {sun}, scene.surfaces = {water};
        const double h = 0.1;
        frame.setWorldFromIndex({h, 0, 0, 0, h, 0, c.shear.x * h, c.shear.y * h, h});
        frame.origin_world = glm::dvec3(-1 + h / 2, -1 + h / 2, c.z_low + h / 2);
        frame.min = glm::ivec3(0), frame.max = {19, 19, static_cast<int>(std::lround((c.z_high - c.z_low) / h)) - 1};
    }
    LaunchDomain domain() const { return launchDomain(scene, scene.surfaces[0], scene.lights[0], frame); }
};

/// Rectangle of all (u, v) whose light gets into the grid, by trying many.
LaunchDomain byTrying(const Pool& s, double disc_deg) {
    LaunchDomain found;
    found.min = glm::dvec2(1e9), found.max = glm::dvec2(-1e9);
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int k = 0; k < 150000; ++k) {
        const glm::dvec2 uv = 7.0 * glm::dvec2(unit(random), unit(random));
        const glm::dvec3 wobble =
            std::tan(0.5 * disc_deg * M_PI / 180) * 0.57 * glm::dvec3(unit(random), unit(random), unit(random));
        const SurfacePoint p = s.scene.surfaces[0].height_field->at(uv);
        const Light& light = s.scene.lights[0];
        glm::dvec3 direction = glm::normalize(light.direction + wobble);
        if (light.position) {
            const std::vector<LightSample> samples = lightSamples(light, 1);
            direction = glm::normalize(p.position - *samples[static_cast<std::size_t>(k) % samples.size()].source);
            const double cosine = glm::dot(direction, light.direction);
            if (!((light.type == LightType::Rectangle ? cosine : light.spotFalloff(cosine)) > 0)) continue;
        }
        const glm::dvec3 normal = glm::normalize(p.normal);
        if (glm::dot(direction, normal) >= 0) continue;
        const SpecularEvent event = specularEvent(s.scene.surfaces[0], s.scene.surfaces[0].ior_above,
                                                  s.scene.surfaces[0].ior_below, direction, normal, normal);
        for (int b = 0; b < event.count; ++b) {
            double from, to;
            if (!s.frame.clip(p.position, event.branches[static_cast<std::size_t>(b)].direction, from, to)) continue;
            found.min = glm::min(found.min, uv), found.max = glm::max(found.max, uv);
        }
    }
    return found;
}

TEST(LaunchDomain, HoldsAllLightThatReachesTheGrid) {
    const std::vector<Case> cases{
        {},
        {.zenith = 0},
        {.zenith = 1.2},
        {.displacement = 0.06},
        {.disc = 8},
        {.event = SurfaceEvent::Reflect, .z_low = 0.3, .z_high = 1.1},
        {.event = SurfaceEvent::Both, .z_low = -1, .z_high = 0.5},
        {.shear = {0.22, -0.3}},
        {.shear = {-0.8, 0.8}},
        {.z_low = -1.5, .z_high = -1.2},
        {.zenith = 0.2, .amplitude = 0.12},
    };
    for (std::size_t k = 0; k < cases.size(); ++k) {
        const Pool setup(cases[k]);
        const LaunchDomain domain = setup.domain(), tried = byTrying(setup, cases[k].disc);
        EXPECT_LE(domain.min.x, tried.min.x) << k;
        EXPECT_LE(domain.min.y, tried.min.y) << k;
        EXPECT_GE(domain.max.x, tried.max.x) << k;
        EXPECT_GE(domain.max.y, tried.max.y) << k;
        // Bounds are taken apart for x and y, which reflection pays for most.
        const double generous = cases[k].event == SurfaceEvent::Refract ? 1.8 : 8;
        EXPECT_LT(domain.area(), generous * tried.area()) << k;
    }
}

struct LampCase {
    LightType type = LightType::Point;
    glm::dvec3 position{0.3, -0.2, 1.5}, direction{0, 0, -1};
    double angle = 30;
    SurfaceEvent event = SurfaceEvent::Refract;
    double amplitude = 0.05, displacement = 0, z_low = -1.5, z_high = 0.2;
};

TEST(LaunchDomain, HoldsAllLightOfALampAndLittleMore) {
    const std::vector<LampCase> cases{
        {},
        {.position = {4, 1, 3}},
        {.position = {0, 0, 40}},
        {.position = {0.9, 0.9, 0.15}},
        {.type = LightType::Spot, .position = {0.1, 0, 2}, .angle = 9},
        {.type = LightType::Spot, .position = {-3, 0, 2}, .direction = glm::normalize(glm::dvec3(3, 0, -2))},
        {.type = LightType::Spot, .displacement = 0.06},
        {.type = LightType::Spot, .angle = 20, .event = SurfaceEvent::Both, .z_low = -1, .z_high = 0.5},
        {.type = LightType::Rectangle},
        {.type = LightType::Rectangle, .position = {-2, 0, 1}, .direction = glm::normalize(glm::dvec3(1, 0, -0.2))},
    };
    for (std::size_t k = 0; k < cases.size(); ++k) {
        const LampCase& c = cases[k];
        Pool setup({.amplitude = c.amplitude,
                    .displacement = c.displacement,
                    .event = c.event,
                    .z_low = c.z_low,
                    .z_high = c.z_high});
        Light& lamp = setup.scene.lights[0];
        lamp = Light{};
        lamp.type = c.type, lamp.position = c.position, lamp.direction = c.direction;
        lamp.cone_angle_deg = c.angle, lamp.size = {0.4, 0.2};
        lamp.tangent = glm::normalize(glm::cross(c.direction, glm::dvec3(0, 1, 0.1)));
        const LaunchDomain domain = setup.domain(), tried = byTrying(setup, 0);
        EXPECT_LE(domain.min.x, tried.min.x) << k;
        EXPECT_LE(domain.min.y, tried.min.y) << k;
        EXPECT_GE(domain.max.x, tried.max.x) << k;
        EXPECT_GE(domain.max.y, tried.max.y) << k;
        // A narrow cone is met at any of the water's heights.
        EXPECT_LT(domain.area(), (c.event == SurfaceEvent::Refract ? 3.5 : 8) * tried.area()) << k;
    }
}

TEST(LaunchDomain, IsTightOverFlatWater) {
    const Pool setup({.zenith = 0.5, .amplitude = 0});
    const LaunchDomain domain = setup.domain();
    const double tangent = std::tan(std::asin(std::sin(0.5) / 1.333));
    EXPECT_NEAR(domain.min.x, -1 - 1.5 * 0.6 * tangent, 1e-6);
    EXPECT_NEAR(domain.max.x, 1, 1e-6);
    EXPECT_NEAR(domain.min.y, -1, 1e-6);
    EXPECT_NEAR(domain.max.y, 1 + 1.5 * 0.8 * tangent, 1e-6);
    EXPECT_TRUE(domain.complete);
}

TEST(LaunchDomain, StaysOnAPatchWithNothingOutside) {
    Pool setup({});
    setup.scene.surfaces[0].outside = Outside::None;
    setup.scene.surfaces[0].size = {0.5, 8}, setup.scene.surfaces[0].center = {0.2, 0, 0};
    const LaunchDomain domain = setup.domain();
    EXPECT_DOUBLE_EQ(domain.min.x, -0.05);
    EXPECT_DOUBLE_EQ(domain.max.x, 0.45);
    EXPECT_GT(domain.min.y, -4);
}

TEST(LaunchDomain, IsEmptyWhereNoLightGoes) {
    EXPECT_TRUE(Pool({.z_low = 0.5, .z_high = 1}).domain().empty()) << "refracted light never rises";
    EXPECT_TRUE(Pool({.event = SurfaceEvent::Reflect, .z_low = -2, .z_high = -1}).domain().empty());
    Pool mesh({});
    mesh.scene.surfaces[0].height_field = nullptr;
    mesh.scene.surfaces[0].mesh = std::make_shared<TriangleMesh>();
    EXPECT_TRUE(mesh.domain().empty());
}

TEST(SpecularEvent, SharesOutAllPower) {
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal;
    for (const SurfaceEvent kind : {SurfaceEvent::Refract, SurfaceEvent::Reflect, SurfaceEvent::Both})
        for (const bool mesh : {false, true}) {
            Surface surface;
            surface.event = kind;
            if (mesh)
                surface.mesh = std::make_shared<TriangleMesh>();
            else
                surface.height_field = std::make_shared<Waves>(0, 0);
            for (int k = 0; k < 2000; ++k) {
                const auto any = [&] {
                    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
                };
                glm::dvec3 face = any(), d = any();
                if (!mesh && face.z < 0) face = -face;
                if (!mesh && glm::dot(d, face) > 0) d = -d;
                const glm::dvec3 smooth = mesh ? glm::normalize(face + 0.3 * any()) : face;
                const bool from_above = glm::dot(d, face) < 0;
                const SpecularEvent e =
                    specularEvent(surface, from_above ? 1 : 1.333, from_above ? 1.333 : 1, d, smooth, face);
                double sum = e.untraced + e.dropped;
                for (int b = 0; b < e.count; ++b) {
                    const SpecularBranch& branch = e.branches[static_cast<std::size_t>(b)];
                    sum += branch.fraction.x;
                    const bool below = branch.crosses == from_above;
                    EXPECT_EQ(below, glm::dot(branch.direction, face) < 0);
                    EXPECT_TRUE(mesh || below == (branch.direction.z < 0));
                }
                ASSERT_NEAR(sum, 1, 1e-12);
            }
        }
}

TEST(SpecularRefusal, NamesOverlappingHeightFields) {
    Pool setup({});
    EXPECT_EQ(specularRefusal(setup.scene), "");
    setup.scene.surfaces.push_back(setup.scene.surfaces[0]);
    setup.scene.surfaces[0].name = "pool", setup.scene.surfaces[1].name = "glass";
    EXPECT_NE(specularRefusal(setup.scene).find("'pool' and 'glass'"), std::string::npos);
    for (Surface& s : setup.scene.surfaces) s.outside = Outside::None;
    EXPECT_NE(specularRefusal(setup.scene), "");
    setup.scene.surfaces[1].center.x = 4;
    EXPECT_EQ(specularRefusal(setup.scene), "");
    setup.scene.lights.clear();
    EXPECT_NE(specularRefusal(setup.scene), "");
}

}  // namespace
}  // namespace photic
