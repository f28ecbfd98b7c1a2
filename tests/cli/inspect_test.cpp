// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

double lawValue(const nlohmann::json& document, const std::string& name) {
    for (const auto& law : document["laws"]) {
        if (law["name"] == name) return law["value"].get<double>();
    }
    return -1;
}

TEST(Inspect, SaysWhatAVolumeHoldsAsDocumented) {
    const Workplace place;
    PoolText pool;
    pool.surface = "flat = true";
    pool.sun_direction = "[0, 0, -1]";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const Outcome outcome = photic(place, {"inspect", "pool.vdb", "--json", "--strict"});
    ASSERT_EQ(outcome.code, 0) << outcome.out;
    const auto document = outcome.json();
    EXPECT_EQ(schemaBreaches(document, "inspect.md"), Strings{});
    EXPECT_TRUE(document["holds"].get<bool>());
    EXPECT_EQ(document["metadata"]["method"], "beams");
    EXPECT_EQ(document["metadata"]["up_axis"], "Z");
    EXPECT_EQ(document["metadata"]["paths"], "caustic");
    EXPECT_EQ(document["metadata"]["frame"], "0");
    EXPECT_GE(lawValue(document, "path ledger closes in the file"), 0);
    EXPECT_LT(lawValue(document, "path ledger closes in the file"), 1e-3);

    // Flat water, sun at the zenith: 1000 W/m2 x (1 - ((n - 1)/(n + 1))^2) through each square metre of every layer.
    const double transmitted = 1000 * (1 - std::pow(0.333 / 2.333, 2));
    int in_water = 0;
    for (const auto& layer : document["layer_power"]) {
        const double z = layer["z"].get<double>();
        if (z < -0.95 || z > -0.05) continue;
        EXPECT_NEAR(layer["power"].get<double>(), transmitted * 4, 1e-3 * transmitted * 4) << z;
        ++in_water;
    }
    EXPECT_GE(in_water, 13);
    for (const auto& grid : document["grids"]) {
        if (grid["name"] == "irradiance") {
            EXPECT_NEAR(grid["max"].get<double>(), transmitted, 1e-3 * transmitted);
        }
        if (grid["name"] == "direction") {
            EXPECT_NEAR(grid["mean"].get<double>(), 1, 1e-3);
        }
    }
    const Outcome text = photic(place, {"inspect", "pool.vdb"});
    EXPECT_EQ(text.code, 0);
    for (const char* word : {"irradiance", "scene_hash", "holds: power ledger closes", "downward power"})
        EXPECT_NE(text.out.find(word), std::string::npos) << text.out;
}

TEST(Inspect, APrefilteredVolumeIsNotHeldToTheSumOfItsVoxels) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--prefilter"}).code, 0);
    const auto document = photic(place, {"inspect", "pool.vdb", "--json"}).json();
    EXPECT_FALSE(document["ledger"]["path_in_file_checked"].get<bool>());
    EXPECT_EQ(lawValue(document, "path ledger closes in the file"), -1);
    EXPECT_EQ(document["metadata"]["prefilter"], "true");
}

TEST(Inspect, StdoutThatCannotBeWrittenIsAnError) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    // Standard output is a file here: the limit stops it after 10 bytes.
    EXPECT_EQ(photic(place, {"inspect", "pool.vdb", "--json"}, 10).code, 4);
}

}  // namespace
}  // namespace photic::test
