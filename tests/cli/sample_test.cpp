// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

/// Calm water over a floor at -1 m, lit at 30 degrees from the zenith.
std::string calmPool(const std::string& absorption, const std::string& irradiance = "1000.0") {
    PoolText pool;
    pool.voxel_size = 0.0625;
    pool.sun_direction = "[0.5, 0, -0.8660254037844386]";
    pool.surface = "waves = [{ amplitude = 0.0, wavelength = 1.0, direction = 0.0, phase = 0.0 }]";
    pool.extra = "[medium]\nabsorption = " + absorption + "\n";
    std::string text = pool.text();
    const std::string white = "irradiance = 1000.0";
    if (const auto at = text.find(white); at != std::string::npos)
        text.replace(at, white.size(), "irradiance = " + irradiance);
    return text;
}

/// Snell, Fresnel and Beer: what is below calm water, [light_volume.md] and section 8's plane.
struct CalmWater {
    double sin_below = 0.5 / 1.333, cos_below = std::sqrt(1 - sin_below * sin_below), cos_above = std::sqrt(0.75);
    double transmitted() const {
        const double s = (cos_above - 1.333 * cos_below) / (cos_above + 1.333 * cos_below);
        const double p = (1.333 * cos_above - cos_below) / (1.333 * cos_above + cos_below);
        return 1 - (s * s + p * p) / 2;
    }
    /// On a level face at a depth [m].
    double level(double irradiance, double absorption, double depth) const {
        return irradiance * cos_above * transmitted() * std::exp(-absorption * depth / cos_below);
    }
};

/// The rows of a table by the names of its columns.
std::vector<std::map<std::string, std::string>> rowsOf(const std::string& csv) {
    std::vector<std::map<std::string, std::string>> rows;
    Strings names;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with('#')) continue;
        Strings fields(1);
        for (const char c : line) {
            if (c == ',') fields.emplace_back();
            if (c != ',') fields.back() += c;
        }
        if (names.empty()) {
            names = fields;
            continue;
        }
        EXPECT_EQ(fields.size(), names.size()) << line;
        auto& row = rows.emplace_back();
        for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = fields.at(i);
    }
    return rows;
}

TEST(Sample, CalmWaterIsFresnelBeerAndCosine) {
    const Workplace place;
    place.write("pool.toml", calmPool("0.3"));
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "pool.vdb", "--f32"}).code, 0);
    // A level face, one across the light, one that it only grazes, one from behind.
    place.write("points.csv", "0,0,-1,0,0,1\n0.3,-0.2,-0.7,-0.5,0,0.8660254\n0,0,-0.5,0,1,0\n0,0,-0.5,0,0,-2\n");
    const Outcome outcome = photic(place, {"sample", "pool.vdb", "points.csv", "-o", "light.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string csv = place.read("light.csv");
    for (const char* word : {"# photic", "in m", "Z up", "W/m2"}) EXPECT_NE(csv.find(word), std::string::npos) << csv;
    const auto rows = rowsOf(csv);
    ASSERT_EQ(rows.size(), 4u);
    const CalmWater water;
    const double depths[] = {1.0, 0.7, 0.5, 0.5};
    // cos of the angle between the light in the water and the face's normal
    const double cosines[] = {water.cos_below, 0.5 * water.sin_below + 0.8660254 * water.cos_below, 0, 0};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto number = [&](const char* name) { return std::stod(rows[i].at(name)); };
        EXPECT_EQ(rows[i].at("place"), "inside");
        const double across = water.level(1000, 0.3, depths[i]) / water.cos_below;
        // A look-up lies on the chords of the decay across a voxel: (0.3 * 0.0625)^2 / 8 too bright at most.
        EXPECT_NEAR(number("irradiance"), across, 3e-4 * across) << i;
        EXPECT_NEAR(number("face_irradiance"), across * cosines[i], 3e-4 * across) << i;
        EXPECT_NEAR(number("direction_x"), water.sin_below, 1e-4);
        EXPECT_NEAR(number("direction_y"), 0, 1e-4);
        EXPECT_NEAR(number("direction_z"), -water.cos_below, 1e-4);
        EXPECT_NEAR(number("flux_z"), -across * water.cos_below, 3e-4 * across);
    }
}

TEST(Sample, ColourHasAColumnAChannel) {
    const Workplace place;
    place.write("pool.toml", calmPool("[0.35, 0.07, 0.02]", "[1000, 900, 800]"));
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "pool.vdb", "--f32"}).code, 0);
    place.write("points.txt", "0 0 -1 0 0 1\n");
    const Outcome outcome = photic(place, {"sample", "pool.vdb", "points.txt"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto rows = rowsOf(outcome.out);
    ASSERT_EQ(rows.size(), 1u);
    const double sun[] = {1000, 900, 800}, absorption[] = {0.35, 0.07, 0.02};
    const char* names[] = {"face_irradiance_r", "face_irradiance_g", "face_irradiance_b"};
    for (int c = 0; c < 3; ++c) {
        const double truth = CalmWater{}.level(sun[c], absorption[c], 1.0);
        EXPECT_NEAR(std::stod(rows[0].at(names[c])), truth, 3e-4 * truth) << names[c];
    }
}

TEST(Sample, SaysWhereAVolumeIsSilent) {
    const Workplace place;
    PoolText pool;
    pool.bake = "where = \"receivers\"\n";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    // Twice in the band on the floor, beside the pool, far above it, and half over its rim.
    place.write("points.csv", "x,y,z\n0,0,-1\n0.5,0,-1\n9,0,-1\n0,0,9\n0.99,0,-1\n");
    const Outcome outcome = photic(place, {"sample", "pool.vdb", "points.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("2 of 5"), std::string::npos) << outcome.err;
    const auto rows = rowsOf(outcome.out);
    ASSERT_EQ(rows.size(), 5u);
    EXPECT_EQ(rows[0].at("place"), "inside");
    EXPECT_EQ(rows[4].at("place"), "edge");
    for (const std::size_t outside : {2u, 3u}) {
        EXPECT_EQ(rows[outside].at("place"), "outside");
        EXPECT_EQ(rows[outside].at("irradiance"), "") << "nothing is known there, and 0 would be a number";
    }
    const auto json = photic(place, {"sample", "pool.vdb", "points.csv", "--json", "-q"}).json();
    EXPECT_EQ(schemaBreaches(json, "sample.md"), Strings{});
    EXPECT_TRUE(json["frames"][0]["points"][2]["irradiance"].is_null());
    EXPECT_EQ(json["frames"][0]["points"][0]["place"], "inside");
}

TEST(Sample, FramesAreSampledOneAfterTheOther) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-3"}).code, 0);
    // Columns in any order, others carried along, units behind names, Windows' line ends.
    place.write("points.csv", "camera;z [m];y [m];x [m]\r\n# the target\r\nfront, left;-1;0.1;0.2\r\n\r\n");
    const Outcome listed =
        photic(place, {"sample", "pool.0001.vdb", "pool.0002.vdb", "pool.0003.vdb", "points.csv", "-o", "a.csv"});
    ASSERT_EQ(listed.code, 0) << listed.err;
    const Outcome counted = photic(place, {"sample", "pool.####.vdb", "points.csv", "--frames", "1-3", "-o", "b.csv"});
    ASSERT_EQ(counted.code, 0) << counted.err;
    EXPECT_EQ(place.read("a.csv"), place.read("b.csv"));
    const auto json = photic(place, {"sample", "pool.####.vdb", "points.csv", "--frames", "1-3", "--json"}).json();
    EXPECT_EQ(schemaBreaches(json, "sample.md"), Strings{});
    ASSERT_EQ(json["frames"].size(), 3u);
    std::string frames;
    for (const auto& frame : json["frames"]) {
        frames += std::to_string(frame["frame"].get<int>());
        EXPECT_EQ(frame["points"][0]["position"], (nlohmann::json{0.2, 0.1, -1.0}));
        EXPECT_EQ(frame["points"][0]["carried"]["camera"], "front, left");
    }
    EXPECT_EQ(frames, "123");
    EXPECT_NE(json["frames"][0]["points"][0]["irradiance"], json["frames"][2]["points"][0]["irradiance"]);
    EXPECT_NE(place.read("a.csv").find("\"front, left\""), std::string::npos);
}

TEST(Sample, MistakesInATableNameTheirLine) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const struct {
        const char *table, *line, *word;
    } mistakes[] = {{"0,0,-1\n0,0\n", "p.csv:2", "2 columns"},
                    {"0,0,-1\n0,0,deep\n", "p.csv:2", "'deep'"},
                    {"0,0,nan\n", "p.csv:1", "not finite"},
                    {"0,0,-1,0\n", "p.csv:1", "4 numbers"},
                    {"# one\n\n0,0,-1,0,0,0\n", "p.csv:3", "no direction"},
                    {"x,y,depth\n0,0,-1\n", "p.csv:1", "no column z"},
                    {"x,y,z,nx\n0,0,-1,1\n", "p.csv:1", "all three or none"},
                    {"x,y,z,x\n0,0,-1,1\n", "p.csv:1", "two columns"},
                    {"0,0,\"-1\"\n", "p.csv:1", "quotes"},
                    {"# nothing\n", "p.csv", "no points"}};
    for (const auto& mistake : mistakes) {
        place.write("p.csv", mistake.table);
        const Outcome outcome = photic(place, {"sample", "pool.vdb", "p.csv", "-o", "out.csv"});
        EXPECT_EQ(outcome.code, 3) << mistake.table;
        EXPECT_NE(outcome.err.find(mistake.line), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find(mistake.word), std::string::npos) << outcome.err;
        EXPECT_FALSE(place.has("out.csv"));
    }
}

TEST(Sample, MistakesOnTheCommandLineAreRefused) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    place.write("p.csv", "0,0,-1\n");
    const auto expectUsage = [&](const Strings& arguments, const char* word) {
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, 2) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    };
    expectUsage({"sample", "pool.vdb"}, "both are wanted");
    expectUsage({"sample", "pool.####.vdb", "p.csv"}, "--frames");
    expectUsage({"sample", "-", "pool.vdb", "p.csv"}, "may be -");
    expectUsage({"sample", "pool.vdb", "p.csv", "-o", "p.csv"}, "one file");
    // Nothing half-written: a frame that is missing leaves no table.
    const Outcome missing = photic(place, {"sample", "pool.vdb", "none.vdb", "p.csv", "-o", "out.csv"});
    EXPECT_EQ(missing.code, 3);
    EXPECT_FALSE(place.has("out.csv"));
}

TEST(Sample, AVolumeWithoutDirectionKnowsNoFaces) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--grids", "irradiance"}).code, 0);
    place.write("p.csv", "0,0,-1,0,0,1\n");
    const Outcome outcome = photic(place, {"sample", "pool.vdb", "p.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("--grids irradiance,direction"), std::string::npos) << outcome.err;
    const auto rows = rowsOf(outcome.out);
    EXPECT_GT(std::stod(rows.at(0).at("irradiance")), 0);
    EXPECT_EQ(rows[0].at("face_irradiance"), "");
    EXPECT_EQ(rows[0].at("flux_x"), "");
}

}  // namespace
}  // namespace photic::test
