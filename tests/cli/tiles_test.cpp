// SPDX-License-Identifier: Apache-2.0
// Volumes in parts: --tile, merge, and slabs within --max-memory.
#include <gtest/gtest.h>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

TEST(Tiles, AreNamedKeptAndMerged) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    for (const char* tile : {"2/3", "1/3", "3/3"}) {
        const Outcome baked = photic(place, {"bake", "pool.toml", "-o", "out/a.vdb", "--tile", tile, "--json"});
        ASSERT_EQ(baked.code, 0) << baked.err;
        EXPECT_EQ(schemaBreaches(baked.json(), "report.md"), Strings{});
        EXPECT_EQ(baked.json()["tile"], tile);
        EXPECT_EQ(baked.json()["up_to_date"], false);
    }
    ASSERT_TRUE(place.has("out/a.tile1of3.vdb") && place.has("out/a.tile2of3.vdb") && place.has("out/a.tile3of3.vdb"));

    // What is there is kept; what is gone, damaged, or of other settings is baked.
    const auto kept = [&](const Strings& more) {
        Strings command{"bake", "pool.toml", "-o", "out/a.vdb", "--tile", "2/3", "--json"};
        command.insert(command.end(), more.begin(), more.end());
        return photic(place, command).json()["up_to_date"].get<bool>();
    };
    EXPECT_TRUE(kept({}));
    EXPECT_FALSE(kept({"--force"}));
    place.write("out/a.tile2of3.vdb", "no volume");
    EXPECT_FALSE(kept({}));
    std::filesystem::copy_file(place / "out/a.tile1of3.vdb", place / "out/a.tile2of3.vdb",
                               std::filesystem::copy_options::overwrite_existing);
    EXPECT_FALSE(kept({}));
    EXPECT_TRUE(kept({}));

    const Outcome merged = photic(place, {"merge", "out/a.tile3of3.vdb", "out/a.tile1of3.vdb", "out/a.tile2of3.vdb",
                                          "-o", "out/a.vdb", "--json"});
    ASSERT_EQ(merged.code, 0) << merged.err;
    EXPECT_EQ(schemaBreaches(merged.json(), "merge.md"), Strings{});
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "b.vdb", "--voxel-size", "0.0625"}).code, 0);
    EXPECT_EQ(photic(place, {"compare", "out/a.vdb", "b.vdb", "--max-error", "0"}).code, 0);
    EXPECT_EQ(photic(place, {"inspect", "out/a.vdb", "--strict"}).code, 0);

    // A volume that was merged is the frame that --frames looks for.
    for (const char* tile : {"1/2", "2/2"})
        ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "7", "--tile", tile}).code, 0);
    ASSERT_EQ(photic(place, {"merge", "pool.0007.tile1of2.vdb", "pool.0007.tile2of2.vdb", "-o", "pool.0007.vdb"}).code,
              0);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--frames", "7", "--json"}).json()[0]["up_to_date"], true);
}

TEST(Tiles, ThatCannotBeAreRefused) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const auto refused = [&](const Strings& command, int code, const std::string& word) {
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    };
    for (const char* tile : {"0/3", "4/3", "1/0", "1", "1/3x", "-1/3", "1/1000000"})
        refused({"bake", "pool.toml", "--tile", tile}, 2, "--tile");
    refused({"bake", "pool.toml", "--tile", "1/90000"}, 2, "ask for fewer");
    refused({"bake", "pool.toml", "--tile", "1/2", "--error", "2%"}, 2, "--voxel-size");
    refused({"bake", "pool.toml", "--tile", "1/2", "--prefilter"}, 2, "--no-prefilter");
    EXPECT_EQ(place.names(), Strings{"pool.toml"});
    for (const char* tile : {"1/2", "2/2"}) ASSERT_EQ(photic(place, {"bake", "pool.toml", "--tile", tile}).code, 0);
    refused({"merge", "pool.tile1of2.vdb", "-o", "pool.vdb"}, 3, "1 of 2 tiles is missing: 2");
    refused({"merge", "pool.tile1of2.vdb", "none.vdb", "-o", "pool.vdb"}, 3, "none.vdb");
    refused({"merge", "pool.tile1of2.vdb", "pool.tile2of2.vdb", "-o", "pool.tile1of2.vdb"}, 2, "are one file");
    place.write("cut.vdb", place.read("pool.tile2of2.vdb").substr(0, 2000));
    refused({"merge", "pool.tile1of2.vdb", "cut.vdb", "-o", "pool.vdb"}, 3, "cut.vdb");
    EXPECT_FALSE(place.has("pool.vdb"));
}

TEST(Slabs, KeepABakeWithinItsMemory) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 160;
    place.write("pool.toml", pool.text());
    const auto estimate = [&](const Strings& more) {
        Strings command{"bake", "pool.toml", "--dry-run", "--json"};
        command.insert(command.end(), more.begin(), more.end());
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(schemaBreaches(outcome.json(), "estimate.md"), Strings{});
        return outcome.json();
    };
    const auto whole = estimate({});
    EXPECT_EQ(whole["slabs"], 1);
    const auto limit = std::to_string(whole["memory_bytes"].get<std::int64_t>() * 8 / 10);
    EXPECT_GT(estimate({"--max-memory", limit})["slabs"], 1);
    EXPECT_EQ(estimate({"--max-memory", "50MB"})["slabs"], 0);
    EXPECT_EQ(estimate({"--max-memory", "50MB"})["fits"], false);

    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "whole.vdb", "--measure", "no"}).code, 0);
    const Outcome baked = photic(place, {"bake", "pool.toml", "-o", "slabs.vdb", "--max-memory", limit, "--json"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    EXPECT_EQ(schemaBreaches(baked.json(), "report.md"), Strings{});
    EXPECT_GT(baked.json()["slabs"], 1);
    EXPECT_EQ(photic(place, {"compare", "slabs.vdb", "whole.vdb", "--max-error", "0"}).code, 0);
    EXPECT_EQ(place.names(), (Strings{"pool.toml", "slabs.vdb", "whole.vdb"}));
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "-o", "no.vdb", "--max-memory", "60MB"}).code, 4);
    EXPECT_FALSE(place.has("no.vdb"));
}

}  // namespace
}  // namespace photic::test
