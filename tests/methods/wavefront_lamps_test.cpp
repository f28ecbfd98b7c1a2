// SPDX-License-Identifier: Apache-2.0
// Lamps among the media: in the grid, in a lens, in glass, among waves and in water.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "bake/methods/wavefront.h"
#include "bake/report/error.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

const std::string kBox = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32",
                  kCoarse = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 24",
                  kAll = "[bake]\npaths = \"all\"\n";

std::string point(const std::string& at) { return "type = \"point\"\npower = 1\nposition = " + at; }
std::string spot(const std::string& at, const std::string& towards, double angle) {
    return fmt::format("type = \"spot\"\npower = 1\nposition = {}\ndirection = {}\nangle = {}", at, towards, angle);
}
std::string even(double n) { return fmt::format("{{ kind = \"linear\", n0 = {}, slope = [0, 0, 0] }}", n); }
std::string ball(const std::string& inside, const std::string& at, double radius) {
    return fmt::format("[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nposition = {}\nradius = {}\ninside = \"{}\"\n",
                       at, radius, inside);
}

/// @param given_up  share of the light that may be: of what runs round and round between faces, and turns at rims
void expectClosed(const Bake& b, const std::string& what, double given_up = 2e-3) {
    EXPECT_LT(b.report().power.imbalance(), 1e-9) << what;
    EXPECT_LT(b.report().path.imbalance(), 3e-5) << what;
    EXPECT_LT(b.report().power.dropped, given_up * b.report().power.emitted) << what;
}

/// Mean relative difference from strength / distance^2 of voxels whose distance lies between two, all of them lit.
double awayFromInverseSquare(const Bake& b, const glm::dvec3& lamp, double strength, double from, double to) {
    const GridFrame& frame = b.field().frame();
    double difference = 0, sum = 0;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const double r = glm::distance(frame.worldFromIndex(glm::dvec3(i, j, k)), lamp);
                if (r < from || r > to) continue;
                const double truth = strength / (r * r);
                difference += std::fabs(b.fluence({i, j, k}) - truth), sum += truth;
            }
    return difference / sum;
}

TEST(WavefrontLamps, InAnEvenMediumItIsTheInverseSquare) {
    // Anywhere in a voxel, off the middle, in a corner of the grid.
    for (const char* at : {"[0.0041, -0.0113, 0.0077]", "[0, 0, 0]", "[-0.4, 0.37, 0.45]"}) {
        const Scene scene = sceneOf(kBox, point(at), medium(even(1.4)) + kAll);
        const Bake b = bake(scene);
        expectClosed(b, at);
        EXPECT_NEAR(b.report().power.emitted, 1, 1e-9) << at << ": all of its power is sent";
        const double apart = awayFromInverseSquare(b, *scene.lights[0].position, 1 / (4 * std::numbers::pi), 0.1, 0.45);
        fmt::print("  lamp at {}: {:.2f} % off\n", at, 100 * apart);
        EXPECT_LT(apart, 0.01) << at;
    }
}

TEST(WavefrontLamps, InAFishEyeItsLightIsThatOnASphere) {
    // Lengths times n are those of a three-sphere of radius n0 a / 2 [Luneburg 1944]; what goes out from a point there
    // is spread over its sphere of distances T: E = P n^2 / (4 pi (R sin(T / R))^2), in which sin(T / 2 R) = q.
    constexpr double kN0 = 1.5, kScale = 0.9;
    const glm::dvec3 lamp(0.21, -0.07, 0.13);
    double apart[2];
    for (int k = 0; k < 2; ++k) {
        const Bake b =
            bake(sceneOf("min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = " + std::to_string(24 << k),
                         point("[0.21, -0.07, 0.13]"),
                         medium(fmt::format("{{ kind = \"fish_eye\", n0 = {}, scale = {} }}", kN0, kScale))));
        expectClosed(b, "fish-eye");
        const GridFrame& frame = b.field().frame();
        double difference = 0, sum = 0;
        for (int z = frame.min.z; z <= frame.max.z; ++z)
            for (int y = frame.min.y; y <= frame.max.y; ++y)
                for (int x = frame.min.x; x <= frame.max.x; ++x) {
                    const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(x, y, z));
                    const double r = glm::distance(p, lamp), a2 = kScale * kScale, here = glm::dot(p, p);
                    if (r < 0.12 || here > 0.16) continue;
                    const double square = a2 * r * r / ((a2 + here) * (a2 + glm::dot(lamp, lamp))),
                                 n = kN0 / (1 + here / a2), radius = 0.5 * kN0 * kScale,
                                 truth = n * n / (16 * std::numbers::pi * radius * radius * square * (1 - square));
                    difference += std::fabs(b.fluence({x, y, z}) - truth), sum += truth;
                }
        apart[k] = difference / sum;
    }
    fmt::print("  lamp in a fish-eye: {:.2f} and {:.2f} % off with 24 and 48 voxels\n", 100 * apart[0], 100 * apart[1]);
    EXPECT_LT(apart[1], 5e-3);
    EXPECT_LT(apart[1], 0.6 * apart[0]);
}

TEST(WavefrontLamps, OnTheRimOfALuneburgLensItsLightComesOutParallel) {
    // A ray that leaves the rim at an angle to the axis comes out at R sin(angle), along the axis.
    constexpr double kRadius = 0.3;
    const Bake b = bake(sceneOf("min = [-0.4, -0.4, -0.4]\nmax = [0.4, 0.4, 0.4]\nresolution = 64",
                                point("[0, 0, 0.3]"), medium("{ kind = \"luneburg\", radius = 0.3 }")));
    expectClosed(b, "luneburg");
    const GridFrame& frame = b.field().frame();
    const double strength = 1 / (4 * std::numbers::pi), z = -0.36;
    const int k = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, z}).z));
    double difference = 0, sum = 0;
    for (int j = frame.min.y; j <= frame.max.y; ++j)
        for (int i = frame.min.x; i <= frame.max.x; ++i) {
            const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
            const double x = std::hypot(p.x, p.y);
            if (x > 0.8 * kRadius) continue;
            const double truth = strength / (kRadius * kRadius * std::sqrt(1 - x * x / (kRadius * kRadius)));
            difference += std::fabs(b.fluence({i, j, k}) - truth), sum += truth;
            const glm::dvec3 flux = b.field().flux({i, j, k});
            EXPECT_GT(-flux.z / glm::length(flux), 0.9985) << i << ", " << j;
        }
    fmt::print("  parallel light: {:.2f} % off\n", 100 * difference / sum);
    EXPECT_LT(difference / sum, 0.02);
}

TEST(WavefrontLamps, ShineAsPhotonsDo) {
    const std::string lens = medium("{ kind = \"luneburg\", radius = 0.4 }", "absorption = [0.3, 0.6, 1]"),
                      fish = medium("{ kind = \"fish_eye\", n0 = 1.6, scale = 1.2, radius = 0.4 }"),
                      glass = "[[medium]]\nname = \"glass\"\nior = 1.5\n",
                      core = medium("{ kind = \"selfoc\", n0 = 1.5, g = 1 }"),
                      salt =
                          "[[medium]]\nname = \"water\"\nindex = { kind = \"salt\", level = -0.1, thickness = 0.05 }\n",
                      waves =
                          "[[surface]]\nname = \"waves\"\nkind = \"height_field\"\nevent = \"both\"\n"
                          "waves = [{ amplitude = 0.03, wavelength = 0.6, direction = [1, 0.3] }]\n";
    struct Case {
        std::string what, light, media;
        double limit;
    };
    for (const Case& c :
         {Case{"a lamp off the middle of a lens", point("[0.11, -0.07, 0.13]"), lens, 0.02},
          Case{"a lamp in the very middle", point("[0, 0, 0]"), lens, 0.02},
          Case{"a spot in a fish-eye", spot("[0.2, 0.03, 0.1]", "[-1, 0.2, -0.3]", 50), fish, 0.03},
          Case{"a lamp beside the box, level with it", point("[0.9, 0.2, 0.48]"), lens, 0.03},
          Case{"a lamp in a ball of glass, in warm air", point("[0.1, 0.02, 0.03]"),
               medium("{ kind = \"hot_air\", ground = -0.5, height = 0.2, n = 1.0003, drop = 2e-4 }") + glass +
                   ball("glass", "[0, 0, 0]", 0.3),
               0.03},
          Case{"a lamp in a ball of Selfoc", point("[0.1, 0.02, 0.03]"), core + ball("lens", "[0, 0, 0]", 0.3), 0.04},
          Case{"a lamp close over waves", point("[0.1, 0.02, 0.1]"), waves + salt, 0.04},
          Case{"a lamp in the water", point("[0.1, 0.02, -0.2]"), waves + salt, 0.04},
          Case{"a spot in the water that shines up", spot("[0.1, 0.02, -0.3]", "[0.2, 0, 1]", 40), waves + salt,
               0.04}}) {
        const Scene scene = sceneOf(kCoarse, c.light, c.media + kAll);
        const Bake fronts = bake(scene), photons = bakeWith("photons", scene, paths(60000));
        expectClosed(fronts, c.what, 0.02);
        const Difference d = compare(photons, fronts);
        fmt::print("  {}: {:.2f} % apart, the photons' error {:.2f} %, all light {:.4f}\n", c.what, 100 * d.apart,
                   100 * d.error, d.total);
        EXPECT_LT(d.apart, d.error + c.limit) << c.what;
        EXPECT_NEAR(d.total, 1, 0.01) << c.what;
        EXPECT_LT(photons.report().power.imbalance(), 1e-9) << c.what;
    }
}

TEST(WavefrontLamps, GlassAroundALampTakesWhatItsFacesReflect) {
    // At the very centre of a ball all rays meet the face straight on; what is reflected comes back through the lamp.
    const double reflected = std::pow(0.5 / 2.5, 2), bare = 1 / (4 * std::numbers::pi);
    const glm::dvec3 centre(0.02, -0.01, 0.03);
    const auto sceneWith = [&](const std::string& event) {
        return sceneOf(kBox, point("[0.02, -0.01, 0.03]"),
                       medium("{ kind = \"luneburg\", center = [0.46, 0.46, 0.46], radius = 0.04 }") +
                           "[[medium]]\nname = \"glass\"\nior = 1.5\n" + ball("glass", "[0.02, -0.01, 0.03]", 0.2) +
                           event + kAll);
    };
    const Bake passed = bake(sceneWith("event = \"refract\"\n"));
    expectClosed(passed, "glass");
    EXPECT_LT(awayFromInverseSquare(passed, centre, (1 - reflected) * bare, 0.25, 0.4), 0.02);
    // What goes to and fro within: all of it comes out at last.
    const Bake both = bake(sceneWith("event = \"both\"\n"));
    expectClosed(both, "glass with its reflections");
    EXPECT_LT(awayFromInverseSquare(both, centre, bare, 0.25, 0.4), 0.02);
    EXPECT_LT(awayFromInverseSquare(both, centre, (1 + reflected) / (1 - reflected) * bare, 0.1, 0.17), 0.02);
}

// Along a face, on it, in it, on a surface, on an edge of the grid: nothing is lost, whatever it is.
TEST(WavefrontLamps, OddPlacesCloseTheirLedgers) {
    const std::string block = medium(
                          "{ kind = \"linear\", n0 = 1.5, slope = [0.3, 0, 0.2], min = [-0.25, -0.25, -0.25], "
                          "max = [0.25, 0.25, 0.25] }"),
                      glass = medium("{ kind = \"selfoc\", n0 = 1.5, g = 1 }") + ball("lens", "[0, 0, 0]", 0.25);
    for (const std::string& media : {block, glass})
        for (const std::string& light :
             {point("[0, 0, 0.25]"), point("[0.25, 0.25, 0.25]"), point("[0.5, 0.5, 0.5]"), point("[0, 0, 0.5]"),
              point("[0, 0, 0.515625]"), point("[0.25, 0, 2]"), spot("[0.25, 0, 0.4]", "[0, 0, -1]", 20),
              spot("[0, 0, 0.25]", "[1, 0, 0]", 170), spot("[0.1, 0, 0]", "[0, 0, -1]", 0.5),
              std::string("type = \"sun\"\ndirection = [1, 0, 0]\nirradiance = 1"),
              std::string("type = \"sun\"\ndirection = [1, 0, 1]\nirradiance = 1"),
              std::string("type = \"rectangle\"\ncenter = [0, 0, 0.25]\ndirection = [0, 0, -1]\nsize = [0.8, 0.1]\n"
                          "power = 1\nsamples = 9")}) {
            const Scene scene =
                sceneOf("min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 16", light, media + kAll);
            for (const char* method : {"wavefront", "photons"}) {
                const Bake b = bakeWith(method, scene, method[0] == 'p' ? paths(2000) : GivenOptions{});
                EXPECT_LT(b.report().power.imbalance(), 1e-9) << method << ": " << light;
                EXPECT_LT(b.report().path.imbalance(), 1e-4) << method << ": " << light;
                EXPECT_GT(b.report().power.emitted, 0) << method << ": " << light;
                for (int c = 0; c < 4; ++c) EXPECT_TRUE(std::isfinite(b.field().sum(c))) << method << ": " << light;
            }
        }
}

TEST(WavefrontLamps, SaysWhereALampMayStand) {
    const std::string water =
                          "[[surface]]\nname = \"waves\"\nkind = \"height_field\"\nflat = true\n"
                          "[[medium]]\nname = \"water\"\nindex = { kind = \"salt\", level = -0.2, thickness = 0.05 }\n",
                      pool = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.1]\nvoxel_size = 0.05";
    for (const auto& [light, remedy] :
         {std::pair{point("[0.1, 0, -3]"), "into the domain"}, std::pair{point("[6, 0, 0.03]"), "above z ="}})
        for (const char* method : {"wavefront", "photons"}) {
            try {
                bakeWith(method, sceneOf(pool, light, water + kAll), method[0] == 'p' ? paths(1000) : GivenOptions{});
                ADD_FAILURE() << method << ": " << light;
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ErrorCode::Input);
                EXPECT_NE(std::string(error.what()).find(remedy), std::string::npos) << error.what();
                EXPECT_EQ(error.where(), "s.toml:6:1");
            }
        }
    const Scene lens = sceneOf(kBox, point("[0, 0, 0.1]"), medium("{ kind = \"luneburg\", radius = 0.3 }"));
    try {
        bake(lens, with("preset", std::string("paper")));
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("no lamps among the media"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace photic
