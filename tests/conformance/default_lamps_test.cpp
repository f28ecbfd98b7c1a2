// SPDX-License-Identifier: Apache-2.0
// Lamps over water, and water that takes much of its light, every setting left as it is, against photons.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tests/conformance/against_photons.h"
#include "tests/support/closed_forms.h"

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

// Of all that a lamp sends, what goes on through level water above it: between straight up and total reflection.
double shareThroughLevelWater(double ior) {
    constexpr int kRings = 100000;
    double share = 0;
    for (int i = 0; i < kRings; ++i) {
        // Close to total reflection it falls as a root does.
        const double left = (i + 0.5) / kRings, critical = std::asin(1 / ior), angle = critical * (1 - left * left);
        share +=
            0.5 * std::sin(angle) * truth::fresnelTransmittance(std::cos(angle), ior, 1) * critical * 2 * left / kRings;
    }
    return share;
}

// What comes through lies within a depth or so of a lamp, whose light may meet the water far within a voxel: all of it
// lay between corners that are totally reflected, and was lost.
TEST(DefaultSettings, LampsCloseUnderLevelWaterSendThroughWhatFresnelSays) {
    constexpr double kIndex = 1.333;
    const double through = shareThroughLevelWater(kIndex);
    for (const double depth : {1e-5, 1e-3, 2.5e-3, 0.02, 0.1})
        for (const std::string event : {"refract", "reflect", "both"}) {
            const std::string toml = fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.4]
max = [0.5, 0.5, 0.4]
voxel_size = 0.0333333333333
[[light]]
type = "point"
position = [0.011, 0.007, {}]
power = 1
[[surface]]
event = "{}"
ior_below = {}
size = [0.6, 0.6]
outside = "none"
flat = true
)",
                                                 -depth, event, kIndex);
            const PowerLedger power = bakeText(toml, "beams").result.report.power;
            SCOPED_TRACE(fmt::format("{} m under the water, event {}", depth, event));
            EXPECT_LT(power.imbalance(), 1e-9);
            if (event == "refract") {
                EXPECT_NEAR(power.escaped / through, 1, 0.01);
            } else if (event == "reflect") {
                EXPECT_NEAR(power.reflected / through, 1, 0.01) << "what is left out";
            } else {
                // All that meets the water goes on, up or down: what the patch covers of all around the lamp.
                const double half2 = 0.3 * 0.3, covered = std::asin(half2 / (half2 + depth * depth)) / std::numbers::pi;
                EXPECT_NEAR(power.emitted / covered, 1, 0.01);
                EXPECT_NEAR(power.escaped / power.emitted, 1, 1e-6);
            }
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
