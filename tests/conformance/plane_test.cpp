// SPDX-License-Identifier: Apache-2.0
// Flat water: every method is exact there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/conformance/bake_scene.h"
#include "tests/support/closed_forms.h"

namespace photic {
namespace {

class FlatWater : public ::testing::TestWithParam<std::string> {};

std::string flatPool(double absorption, const char* direction) {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.5]
max = [0.5, 0.5, 0.25]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = {}
irradiance = 800
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
outside = "flat"
flat = true
[medium]
absorption = {}
)",
                       direction, absorption);
}

TEST_P(FlatWater, FollowsFresnelAndBeerLambert) {
    for (const double absorption : {0.0, 1.5}) {
        const Baked baked = bakeText(flatPool(absorption, "[0.3, -0.4, -0.8]"), GetParam());
        const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, -0.4, -0.8));
        const truth::PlaneWater water{800, -d.z, 1, 1.333, absorption};
        const glm::dvec3 w(d.x / 1.333, d.y / 1.333, -water.cosBelow());
        const double tolerance = GetParam() == "photons" ? 0.05 : 2e-5;  // photons: noise of a voxel
        const GridFrame& f = baked.field().frame();
        double sum = 0, truth_sum = 0;
        for (int k = f.min.z; k < 0; ++k) {
            const double top = -(k + 1) * 0.0625, expected = water.meanFluence(top, top + 0.0625);
            for (int j = f.min.y; j <= f.max.y; ++j) {
                for (int i = f.min.x; i <= f.max.x; ++i) {
                    const double e = baked.irradiance(i, j, k);
                    ASSERT_NEAR(e, expected, tolerance * expected)
                        << i << " " << j << " " << k << " absorption " << absorption;
                    ASSERT_LT(glm::length(baked.flux(i, j, k) - expected * w), 1.5 * tolerance * expected);
                    sum += e, truth_sum += expected;
                }
            }
        }
        EXPECT_NEAR(sum / truth_sum, 1, GetParam() == "photons" ? 5e-4 : 1e-5);
        for (int k = 0; k <= f.max.z; ++k) EXPECT_EQ(baked.irradiance(0, 0, k), 0) << "light above the water";
    }
}

// Light that leaves the water so low that its tubes lie along the water: they start everywhere on it, not at its rim.
TEST(LowLightOverFlatWater, IsWhereItIsReflected) {
    for (const std::string method : {"beams", "photons"})
        for (const double degrees : {30.0, 60.0, 70.0, 80.0}) {
            const double zenith = degrees * M_PI / 180;
            const glm::dvec3 d(0.6 * std::sin(zenith), -0.8 * std::sin(zenith), -std::cos(zenith));
            const Baked baked = bakeText(fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.25]
max = [0.5, 0.5, 0.5]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = [{:.17g}, {:.17g}, {:.17g}]
irradiance = 800
angular_diameter = 0
[[surface]]
name = "water"
size = [4.0, 4.0]
outside = "flat"
flat = true
event = "reflect"
)",
                                                     d.x, d.y, d.z),
                                         method);
            const double entering = truth::PlaneWater{800, -d.z, 1, 1.333, 0}.horizontal(0),
                         expected = 800 + entering / d.z;
            const double tolerance = method == "photons" ? 0.06 : 2e-4;
            const GridFrame& f = baked.field().frame();
            double sum = 0;
            for (int k = 1; k <= f.max.z; ++k)
                for (int j = f.min.y; j <= f.max.y; ++j)
                    for (int i = f.min.x; i <= f.max.x; ++i) {
                        ASSERT_NEAR(baked.irradiance(i, j, k), expected, tolerance * expected)
                            << method << " " << degrees << ": " << i << " " << j << " " << k;
                        sum += baked.irradiance(i, j, k) / expected;
                    }
            EXPECT_NEAR(sum / (f.size().x * f.size().y * f.max.z), 1, method == "photons" ? 1e-3 : 1e-5)
                << method << " " << degrees;
        }
}

INSTANTIATE_TEST_SUITE_P(Methods, FlatWater, ::testing::ValuesIn(methodNames()),
                         [](const auto& row) { return row.param; });

}  // namespace
}  // namespace photic
