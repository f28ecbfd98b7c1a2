// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/own_shadow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "bake/paths/height_field_hit.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using support::Ripples;
using support::WaterScene;

/// Waves whose crests are sharpened by sideways displacement.
class Choppy final : public HeightField {
public:
    SurfacePoint at(glm::dvec2 p) const override {
        const double x = p.x * k_, y = p.y * k_;
        const glm::dvec3 u(1 + d_ * k_ * std::cos(x), 0, -a_ * k_ * std::sin(x)), v(0, 1, -a_ * k_ * std::sin(y));
        return {{p.x + d_ * std::sin(x), p.y, a_ * (std::cos(x) + std::cos(y))}, glm::cross(u, v)};
    }
    double minZ() const override { return -2 * a_; }
    double maxZ() const override { return 2 * a_; }
    double maxDisplacement() const override { return std::fabs(d_); }
    double featureSize() const override { return 2 * 3.14159265358979 / k_ / 8; }

private:
    double a_ = 0.05, d_ = -0.04, k_ = 9;
};

struct Counted {
    int points = 0, shaded = 0, different = 0;
};

/// Compares with a walk along the whole way to the light, for points that the light can come to.
Counted comparedWithAWalk(const WaterScene& water, const OwnShadow& shadow) {
    const Surface& surface = water.scene.surfaces[0];
    const Light& light = water.scene.lights[0];
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    Counted out;
    while (out.points < 3000) {
        const SurfacePoint p = surface.height_field->at(1.5 * glm::dvec2(unit(random), unit(random)));
        const glm::dvec3 direction = light.position ? glm::normalize(p.position - *light.position) : light.direction;
        if (-glm::dot(direction, glm::normalize(p.normal)) < 1e-3) continue;
        ++out.points;
        const double reach = light.position ? glm::length(p.position - *light.position) : 1e9;
        const bool walked = std::isfinite(
            hitHeightField(surface, p.position, -direction, 1e-6 * surface.height_field->featureSize(), reach)
                .distance);
        out.shaded += walked, out.different += walked != shadow.covers(p.position, direction, reach);
    }
    return out;
}

TEST(OwnShadow, IsWhatAWalkToTheLightFinds) {
    WaterScene lamp(std::make_shared<Ripples>(0.08, 7));
    lamp.scene.lights[0].type = LightType::Point, lamp.scene.lights[0].position = glm::dvec3(3, 0.5, 0.5);
    WaterScene patch(std::make_shared<Ripples>(0.08, 7), {0.9, 0.3, -0.3});
    patch.scene.surfaces[0].outside = Outside::None;
    const WaterScene waters[] = {WaterScene(std::make_shared<Ripples>(0.08, 7), {0.9, 0.3, -0.3}),
                                 WaterScene(std::make_shared<Ripples>(0.08, 7), {-0.9, 0.2, -0.03}),
                                 WaterScene(std::make_shared<Choppy>(), {0.2, 0.95, -0.25}),
                                 WaterScene(std::make_shared<Choppy>(), {-0.95, 0.1, -0.25}),
                                 lamp,
                                 patch};
    for (const WaterScene& water : waters) {
        const std::optional<OwnShadow> shadow = OwnShadow::of(water.scene, water.scene.surfaces[0], water.frame);
        const auto which = &water - waters;
        ASSERT_TRUE(shadow) << which;
        const Counted counted = comparedWithAWalk(water, *shadow);
        EXPECT_GT(counted.shaded, counted.points / 50) << which;
        EXPECT_LT(counted.shaded, counted.points) << which;
        // A walk by long steps leaves out what a ray only just grazes.
        EXPECT_LE(counted.different, counted.points / 1000) << which;
    }
}

TEST(OwnShadow, IsNotLookedForWhereAllOfTheWaterFacesTheLight) {
    const auto of = [](const WaterScene& water) {
        return OwnShadow::of(water.scene, water.scene.surfaces[0], water.frame).has_value();
    };
    EXPECT_FALSE(of(WaterScene(glm::dvec3(0.99, 0, -0.1))));                                     // flat
    EXPECT_FALSE(of(WaterScene(std::make_shared<Ripples>(0.08, 7), glm::dvec3(0.3, 0.2, -1))));  // high
    EXPECT_TRUE(of(WaterScene(std::make_shared<Ripples>(0.08, 7), glm::dvec3(2.5, 0, -1))));
    // Its disc reaches lower than its centre.
    WaterScene wide(std::make_shared<Ripples>(0.02, 7), glm::dvec3(4.5, 0, -1));
    EXPECT_FALSE(of(wide));
    wide.scene.lights[0].angular_diameter_deg = 20;
    EXPECT_TRUE(of(wide));
}

}  // namespace
}  // namespace photic
