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

INSTANTIATE_TEST_SUITE_P(Methods, FlatWater, ::testing::ValuesIn(methodNames()),
                         [](const auto& row) { return row.param; });

}  // namespace
}  // namespace photic
