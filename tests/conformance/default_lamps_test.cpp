// SPDX-License-Identifier: Apache-2.0
// Lamps over water, and water that takes much of its light, every setting left as it is, against photons.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/conformance/against_photons.h"

namespace photic {
namespace {

std::string scene(const std::string& light, const std::string& water) {
    return fmt::format(R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 0]
voxel_size = 0.0625
[[light]]
{}
[[surface]]
name = "water"
size = [4, 4]
{}
[[object]]
name = "floor"
plane = {{ point = [0, 0, -0.9], normal = [0, 0, 1] }}
)",
                       light, water);
}

// Level water bends a lamp's rays apart, each by its own angle: two tubes would not do.
TEST(DefaultSettings, LampsOverLevelWaterAreThePhotons) {
    const std::string water = "flat = true\n";
    for (const std::string light :
         {"type = \"point\"\nposition = [0.2, 0.1, 0.3]\npower = 100\n",
          "type = \"spot\"\nposition = [0.2, 0.1, 0.6]\ndirection = [0.3, 0, -1]\nangle = 60\npower = 100\n"}) {
        const Compared c = againstPhotons(scene(light, water));
        EXPECT_LT(c.blocks, 0.005) << light;
        EXPECT_NEAR(c.total, 0, 2e-3) << light;
    }
}

// Where water slopes, light at its higher side has come a longer way through it.
TEST(DefaultSettings, MurkyWaterUnderASwellIsThePhotons) {
    const std::string sun = "type = \"sun\"\ndirection = [0.2, -0.3, -1]\nangular_diameter = 0\n";
    const std::string swell =
        "waves = [{ amplitude = 0.2, wavelength = 6, direction = 50, phase = 2.8 }]\n[medium]\n"
        "absorption = [0.7, 0.3, 0.5]\nscattering = 6.5\n";
    const Compared c = againstPhotons(scene(sun, swell));
    EXPECT_LT(c.blocks, 0.005);
    EXPECT_NEAR(c.total, 0, 2e-3);
}

}  // namespace
}  // namespace photic
