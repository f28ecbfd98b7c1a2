// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "bake/image/image.h"
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

TEST(Frames, OfASunThatTurnsAreBakedWhereItHasTurned) {
    const Workplace place;
    const auto scene = [](const std::string& last) {
        std::string text = PoolText{}.text();
        const std::string still = "direction = " + PoolText{}.sun_direction;
        const std::size_t at = text.find(still);
        EXPECT_NE(at, std::string::npos);
        return text.replace(at, still.size(),
                            "keyframes = [{ frame = 1, direction = [0.433, 0.25, -0.866] }, { frame = 2, direction = "
                            "[0.2, 0.25, -0.866] }, { frame = 3, direction = " +
                                last + " }]");
    };
    const Strings command{"bake", "pool.toml", "--frames", "1-4", "--json"};
    place.write("pool.toml", scene("[0, 0, -1]"));
    const Outcome first = photic(place, command);
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_EQ(kept(first), (std::vector<bool>{false, false, false, false}));
    EXPECT_EQ(kept(photic(place, command)), (std::vector<bool>{true, true, true, true}));
    // Another end: what comes before is as it was.
    place.write("pool.toml", scene("[0, 0.1, -1]"));
    EXPECT_EQ(kept(photic(place, {"bake", "pool.toml", "--frames", "1-2", "--json"})), (std::vector<bool>{true, true}));
    EXPECT_EQ(kept(photic(place, {"bake", "pool.toml", "--frames", "3-4", "--json"})),
              (std::vector<bool>{false, false}));
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

/// A pool with a step that is a file of its own in each frame, of which number 2 is missing.
void makeGap(const Workplace& place) {
    PoolText pool;
    pool.extra = "[[object]]\nname = \"step\"\nfile = \"step.####.obj\"\n";
    place.write("pool.toml", pool.text());
    for (const char* frame : {"0001", "0003"})
        place.write(std::string("step.") + frame + ".obj", "v 0 0 -0.6\nv 0.3 0 -0.6\nv 0 0.3 -0.6\nf 1 2 3\n");
}

TEST(Frames, OneWithoutItsFilesIsNamedAndTheOthersAreBaked) {
    const Workplace place;
    makeGap(place);
    const Outcome outcome = photic(
        place, {"bake", "pool.toml", "--frames", "1-3", "--json", "--report", "report.json", "-o", "p.####.vdb"});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_TRUE(place.has("p.0001.vdb") && place.has("p.0003.vdb"));
    EXPECT_FALSE(place.has("p.0002.vdb"));
    for (const char* word : {"step.0002.obj", "frame 2 failed"})
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    const auto reports = outcome.json();
    ASSERT_EQ(reports.size(), 3u);
    for (const auto& report : reports) EXPECT_EQ(schemaBreaches(report, "report.md"), Strings{});
    EXPECT_EQ(reports[1]["error"]["code"], 3);
    EXPECT_FALSE(reports[0].contains("error") || reports[2].contains("error"));
    EXPECT_EQ(nlohmann::json::parse(place.read("report.json")), reports);
}

TEST(Frames, DryRunLooksAtTheInputsOfEach) {
    const Workplace place;
    makeGap(place);
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--frames", "1-3", "--dry-run"});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_NE(outcome.err.find("step.0002.obj"), std::string::npos) << outcome.err;
    EXPECT_EQ(place.names(), (Strings{"pool.toml", "step.0001.obj", "step.0003.obj"}));
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--frames", "3", "--dry-run"}).code, 0);
}

TEST(Frames, AFailureIsReportedToo) {
    const Workplace place;
    makeGap(place);
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--json", "--report", "out/report.json"});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_EQ(schemaBreaches(outcome.json(), "report.md"), Strings{});
    EXPECT_EQ(outcome.json()["error"]["code"], 3);
    EXPECT_EQ(nlohmann::json::parse(place.read("out/report.json")), outcome.json());
    EXPECT_FALSE(place.has("pool.vdb"));
}

TEST(Frames, EqualOnesAreWarnedOf) {
    const Workplace place;
    PoolText pool;
    place.write("pool.toml", pool.text());
    EXPECT_NE(photic(place, {"bake", "pool.toml", "--frames", "1-2"}).err.find("changes from frame 1 to 2"),
              std::string::npos);
    pool.surface = "animate = \"deep_water\"\n" + pool.surface;
    place.write("pool.toml", pool.text());
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-2"}).err.find("changes from frame"),
              std::string::npos);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1"}).err.find("changes from frame"), std::string::npos);
}

// A sea that repeats after three frames.
TEST(Frames, ThatShowTheSameAreCopied) {
    const Workplace place;
    PoolText pool;
    pool.surface = "outside = \"periodic\"\nsea = { wind_speed = 2.0, fetch = 300.0, period = 0.125, resolution = 32 }";
    place.write("sea.toml", pool.text());
    const auto frames = [&](const Strings& more) {
        Strings command{"bake", "sea.toml", "--measure", "no", "--json"};
        command.insert(command.end(), more.begin(), more.end());
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json();
    };
    const auto reports = frames({"--frames", "1-7"});
    for (int frame = 1; frame <= 7; ++frame) {
        const auto& report = reports[static_cast<std::size_t>(frame - 1)];
        EXPECT_EQ(schemaBreaches(report, "report.md"), Strings{});
        EXPECT_EQ(report.contains("copied_from"), frame > 3) << frame;
    }
    EXPECT_EQ(reports[5]["copied_from"], "sea.0003.vdb");
    // Each is what it would be alone, to the last byte.
    for (const char* frame : {"0004", "0007"}) {
        const std::string name = std::string("sea.") + frame + ".vdb";
        frames({"--frames", std::to_string(std::atoi(frame)), "-o", "alone.####.vdb"});
        EXPECT_TRUE(place.read(name) == place.read(std::string("alone.") + frame + ".vdb")) << frame;
    }
    // A frame that is kept serves as well; one that was changed by somebody does not.
    std::filesystem::remove(place / "sea.0004.vdb");
    EXPECT_EQ(frames({"--frames", "1-4"})[3]["copied_from"], "sea.0001.vdb");
    EXPECT_FALSE(frames({"--frames", "1-4", "--force"})[3].contains("copied_from"));
}

TEST(Frames, CommentsAndLineEndsBakeNothingAgain) {
    const Workplace place;
    const std::string text = PoolText{}.text();
    place.write("pool.toml", text);
    const Strings command{"bake", "pool.toml", "--frames", "1", "--json"};
    ASSERT_EQ(kept(photic(place, command)), std::vector<bool>{false});
    std::string same = "# the same pool\r\n";
    for (const char c : text) same += c == '\n' ? "\r\n" : std::string(1, c);
    place.write("pool.toml", same);
    EXPECT_EQ(kept(photic(place, command)), std::vector<bool>{true});
}

TEST(Frames, AStandardErrorThatIsGoneIsBakedAgain) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Strings command{"bake",  "pool.toml",           "--frames",         "1",    "--json", "--method", "photons",
                          "--set", "photons.count=20000", "--standard-error", "e.vdb"};
    ASSERT_EQ(kept(photic(place, command)), std::vector<bool>{false});
    EXPECT_EQ(kept(photic(place, command)), std::vector<bool>{true});
    std::filesystem::remove(place / "e.0001.vdb");
    EXPECT_EQ(kept(photic(place, command)), std::vector<bool>{false});
    EXPECT_TRUE(place.has("e.0001.vdb"));
}

// Water of which one corner changes: what it does not light is taken from the frame before, and the files have the very
// bytes of frames that are baked alone.
TEST(Frames, TakeFromTheOneBeforeWhatACornerDoesNotLight) {
    const Workplace place;
    constexpr int kSize = 256;
    for (int frame = 1; frame <= 3; ++frame) {
        Image image{kSize, kSize, 1, std::vector<float>(kSize * kSize)};
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const double corner = std::hypot(x - 90, y - 170);
                const double z =
                    0.01 * std::sin(0.15 * x + 0.05 * y) +
                    (corner < 8 ? (0.001 + 0.0001 * frame) * std::pow(std::cos(0.19634954 * corner), 2) : 0.0);
                image.at(x, y, 0) = static_cast<float>(z);
            }
        writeExr((place / ("water.000" + std::to_string(frame) + ".exr")).string(), image);
    }
    PoolText pool;
    pool.voxel_size = 2.0 / 192;
    pool.surface = "file = \"water.####.exr\"";
    pool.bake = "where = \"receivers\"\n";
    place.write("pool.toml", pool.text());
    const Outcome together =
        photic(place, {"bake", "pool.toml", "--frames", "1-3", "--json", "--measure", "no", "-o", "all.vdb"});
    ASSERT_EQ(together.code, 0) << together.err;
    for (int frame = 1; frame <= 3; ++frame) {
        const std::string number = std::to_string(frame);
        ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", number, "--measure", "no", "-o", "one.vdb"}).code, 0);
        EXPECT_EQ(place.read("all.000" + number + ".vdb"), place.read("one.000" + number + ".vdb")) << frame;
        const std::string skipped = together.json()[static_cast<std::size_t>(frame - 1)]["skipped"].dump();
        EXPECT_EQ(skipped.find("as in the frame before") != std::string::npos, frame > 1) << skipped;
    }
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
