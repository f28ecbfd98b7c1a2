// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

std::vector<bool> kept(const Outcome& outcome) {
    std::vector<bool> flags;
    for (const auto& report : outcome.json()) flags.push_back(report["up_to_date"].get<bool>());
    return flags;
}

TEST(Frames, AreNumberedAndKeptUntilTheirInputsChange) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Strings command{"bake", "pool.toml", "--frames", "9-11", "--json"};
    const Outcome first = photic(place, command);
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_EQ(place.names(), (Strings{"pool.0009.vdb", "pool.0010.vdb", "pool.0011.vdb", "pool.toml"}));
    EXPECT_EQ(kept(first), (std::vector<bool>{false, false, false}));
    for (const auto& report : first.json()) EXPECT_EQ(schemaBreaches(report, "report.md"), Strings{});

    EXPECT_EQ(kept(photic(place, command)), (std::vector<bool>{true, true, true}));

    // A frame that is gone, or damaged, is baked again; its neighbours are kept.
    std::filesystem::remove(place / "pool.0010.vdb");
    place.write("pool.0011.vdb", "no volume");
    const Outcome repaired = photic(place, command);
    EXPECT_EQ(kept(repaired), (std::vector<bool>{true, false, false}));
    for (const auto& report : repaired.json()) EXPECT_EQ(schemaBreaches(report, "report.md"), Strings{});

    EXPECT_EQ(kept(photic(place, {"bake", "pool.toml", "--frames", "9-9", "--json", "--quadrature", "2"})),
              std::vector<bool>{false});
    EXPECT_EQ(kept(photic(place, {"bake", "pool.toml", "--frames", "10", "--json", "--force"})),
              std::vector<bool>{false});
    PoolText changed;
    changed.sun_direction = "[0.2, 0.25, -0.866]";
    place.write("pool.toml", changed.text());
    EXPECT_EQ(kept(photic(place, command)), (std::vector<bool>{false, false, false}));
}

TEST(Frames, PutTheirNumberWhereTheNameWantsIt) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "7", "-o", "f##_x.vdb"}).code, 0);
    EXPECT_TRUE(place.has("f07_x.vdb"));
}

TEST(Frames, SendAnEventEachAndOneAtTheEnd) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--frames", "1-2", "--progress=json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    int frames = 0;
    double overall = 0;
    for (const auto& event : outcome.events()) {
        if (event["event"] == "frame") {
            EXPECT_EQ(schemaBreaches(event, "progress.md", "`frame`"), Strings{});
            EXPECT_EQ(event["frame"], ++frames);
            EXPECT_NEAR(overall, frames / 2.0, 1e-9);
        } else if (event["event"] == "progress") {
            EXPECT_GE(event["overall"].get<double>(), overall);
            overall = event["overall"].get<double>();
        }
    }
    EXPECT_EQ(frames, 2);
    EXPECT_EQ(outcome.events().back()["outputs"], (nlohmann::json{"pool.0001.vdb", "pool.0002.vdb"}));
}

TEST(Frames, RangesThatAreNoneAreRefused) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    for (const char* range : {"3-1", "a", "1-", "1-2x", "1--2"}) {
        const Outcome outcome = photic(place, {"bake", "pool.toml", "--frames", range});
        EXPECT_EQ(outcome.code, 2) << range << outcome.err;
        EXPECT_EQ(place.names(), Strings{"pool.toml"});
    }
}

}  // namespace
}  // namespace photic::test
