// SPDX-License-Identifier: Apache-2.0
// Lamps over water, and water that takes much of its light, every setting left as it is, against photons.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/conformance/against_photons.h"

namespace photic {
namespace {

std::string scene(const std::string& light, const std::string& water) {
    return fmt::format(R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 0.5]
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

// A pool's own lamps: what leaves the water, and what its surface sends back down, total reflection included. Wide
// lattices of grazing light leave photons few for the box, hence the blocks' noise.
TEST(DefaultSettings, LampsUnderWaterAreThePhotons) {
    const std::string waves =
        "event = \"both\"\nwaves = [{ amplitude = 0.02, wavelength = 0.9, direction = 20 }, { amplitude = 0.015, "
        "wavelength = 0.5, direction = 110, phase = 1.2 }]\n";
    const std::string point = "type = \"point\"\nposition = [0.2, 0.1, -0.5]\npower = [100, 80, 60]\n";
    expectAlike(scene(point, waves), 0.03, 0.003);
    const std::string murky = "[medium]\nabsorption = [2, 0.5, 0.2]\nscattering = 0.3\n";
    expectAlike(scene(point, waves + murky), 0.03, 0.003);
    const std::string spot =
        "type = \"spot\"\nposition = [0.2, 0.1, -0.8]\ndirection = [0.2, 0, 1]\nangle = 50\npower = 100\n";
    expectAlike(scene(spot, "event = \"both\"\nflat = true\n"), 0.01, 0.003);
}

// Over the lamp, from where it seems to stand: at three quarters of its depth.
TEST(DefaultSettings, ALampUnderLevelWaterSeemsNearer) {
    constexpr double kDepth = 0.4, kIndex = 1.333, kPower = 100, kHigh = 0.5 + 0.0125;
    const std::string toml = fmt::format(R"(photic = 1
[domain]
min = [-0.1, -0.1, 0.4]
max = [0.1, 0.1, 0.6]
voxel_size = 0.025
[[light]]
type = "point"
position = [0, 0, {}]
power = {}
[[surface]]
size = [4, 4]
flat = true
)",
                                         -kDepth, kPower);
    const Baked baked = bakeText(toml, "beams");
    const double root = (kIndex - 1) / (kIndex + 1), through = 1 - root * root;
    const double seems = kHigh + kDepth / kIndex;
    const double exact = kPower / (4 * M_PI) * through / (kIndex * kIndex * seems * seems);
    const auto at = baked.field().frame().indexFromWorld({0.0125, 0.0125, kHigh});
    EXPECT_NEAR(baked.irradiance(int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))) / exact, 1,
                0.005);
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
