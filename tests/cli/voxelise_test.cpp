// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/cli/program.h"

namespace photic::test {
namespace {

constexpr const char* kScene = R"(photic = 1
[domain]
min = [-0.3, -0.3, -0.3]
max = [0.3, 0.3, 0.3]
voxel_size = 0.0118
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1
angular_diameter = 0
[[medium]]
name = "body"
index = "body.vdb"
)";

double absorbed(const Workplace& place, const std::string& method) {
    const Outcome bake = photic(
        place, {"bake", "scene.toml", "-o", "out.vdb", "--json", "--method", method, "--set", "photons.count=20000"});
    EXPECT_EQ(bake.code, 0) << bake.err;
    return bake.json()["power"]["absorbed_medium"].get<double>();
}

TEST(Voxelise, WhatItWritesIsBakedWithItsAbsorption) {
    const Workplace place;
    // A square rod and a round one of another colour in it. They hardly bend: a blurred side draws in light beside it.
    place.write(
        "body.toml",
        "voxel_size = 0.0125\n[[solid]]\nname = \"rod\"\nfile = \"rod.obj\"\nior = 1.000001\nabsorption = [2, 2, 2]\n"
        "[[solid]]\nname = \"core\"\nprofile = [[0, -0.25], [0.1, -0.25], [0.1, 0.25], [0, 0.25]]\nior = 1.000001\n"
        "absorption = [8, 8, 8]\n");
    place.write(
        "rod.obj",
        "v -0.2 -0.2 -0.25\nv 0.2 -0.2 -0.25\nv 0.2 0.2 -0.25\nv -0.2 0.2 -0.25\nv -0.2 -0.2 0.25\nv 0.2 -0.2 "
        "0.25\nv 0.2 0.2 0.25\nv -0.2 0.2 0.25\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    const Outcome made = photic(place, {"voxelise", "body.toml", "-o", "body.vdb"});
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_NE((made.out + made.err).find("n and absorption"), std::string::npos);
    place.write("scene.toml", std::string(kScene) + "absorption_volume = \"body.vdb\"\n");
    const double core = 3.14159265 * 0.01,
                 expected = core * (1 - std::exp(-8 * 0.5)) + (0.16 - core) * (1 - std::exp(-2 * 0.5));
    // Sides fall between voxels, and tubes go across them: at 34 voxels, a quarter of a voxel is 3 %.
    EXPECT_NEAR(absorbed(place, "wavefront"), expected, 0.06 * expected);
    EXPECT_NEAR(absorbed(place, "photons"), expected, 0.03 * expected);
    // Once more: the same bytes.
    const std::string bytes = place.read("body.vdb");
    EXPECT_EQ(photic(place, {"voxelise", "body.toml", "-o", "body.vdb"}).code, 0);
    EXPECT_EQ(place.read("body.vdb"), bytes);
}

TEST(Voxelise, SaysWhatSmoothingDoes) {
    const Workplace place;
    place.write("ball.csv", "radius, height\n0, -0.2\n0.2, -0.2 # a can\n0.2, 0.2\n0, 0.2\n");
    const Outcome made = photic(
        place, {"voxelise", "ball.csv", "--voxel-size", "0.02", "--ior", "1.4", "--smooth", "1", "-o", "body.vdb"});
    EXPECT_EQ(made.code, 0) << made.err;
    EXPECT_NE((made.out + made.err).find("n changes by"), std::string::npos) << made.out << made.err;
    EXPECT_NE((made.out + made.err).find("2.56 voxels"), std::string::npos);
}

TEST(Voxelise, RefusesWhatHasNoInside) {
    const Workplace place;
    place.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.write("bad.csv", "0.1, 0\n-0.1, 1\n");
    place.write("words.csv", "0.1, 0\n0.1, up\n");
    place.write("empty.toml", "voxel_size = 0.1\n");
    place.write("typo.toml", "voxel_size = 0.1\n[[solid]]\nprofil = [[0, 0], [1, 0], [0, 1]]\nior = 1.5\n");
    const auto refused = [&](const std::vector<std::string>& more, int code, const std::string& word) {
        std::vector<std::string> arguments{"voxelise", "-o", "out.vdb"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
        EXPECT_FALSE(place.has("out.vdb"));
    };
    refused({"open.obj", "--voxel-size", "0.1"}, 3, "open");
    refused({"bad.csv", "--voxel-size", "0.1"}, 3, "radius is 0 or more");
    refused({"words.csv", "--voxel-size", "0.1"}, 3, "words.csv:2");
    refused({"empty.toml"}, 3, "[[solid]]");
    refused({"typo.toml"}, 3, "profile");
    refused({"bad.csv"}, 3, "radius");
    refused({"open.obj", "--voxel-size", "0.1", "--absorption", "1,2"}, 2, "red,green,blue");
    refused({"missing.ply", "--voxel-size", "0.1"}, 3, "missing.ply");
}

}  // namespace
}  // namespace photic::test
