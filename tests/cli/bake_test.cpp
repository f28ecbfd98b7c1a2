// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

TEST(Bake, WritesBesideTheUserAndSaysSoOnStderr) {
    const Workplace place;
    std::filesystem::create_directory(place / "scenes");
    place.write("scenes/pool.toml", PoolText{}.text());
    const Outcome outcome = photic(place, {"bake", "scenes/pool.toml"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(place.names(), (Strings{"pool.vdb", "scenes"}));
    for (const char* word : {"pool.vdb", "power ledger", "path ledger", "write", "MB"})
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    EXPECT_EQ(photic(place, {"inspect", "pool.vdb", "--strict"}).code, 0);
}

TEST(Bake, ReportsAsDocumented) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome outcome =
        photic(place, {"bake", "pool.toml", "-o", "a.vdb", "--json", "--report", "report.json", "--threads", "1"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto report = outcome.json();
    EXPECT_EQ(schemaBreaches(report, "report.md"), Strings{});
    EXPECT_EQ(nlohmann::json::parse(place.read("report.json")), report);
    EXPECT_EQ(report["output"], "a.vdb");
    EXPECT_EQ(report["threads"], 1);
    EXPECT_EQ(report["grid"]["size"], (nlohmann::json{32, 32, 22}));
    EXPECT_EQ(report["needed_voxels"], 32 * 32 * 22);
    EXPECT_EQ(report["file_bytes"], std::filesystem::file_size(place / "a.vdb"));
    EXPECT_NEAR(report["reference_irradiance"].get<double>(), 1000, 1e-9);
    EXPECT_LT(report["power"]["imbalance"].get<double>(), 1e-6);
    EXPECT_GT(report["power"]["emitted"].get<double>(), 0);
    EXPECT_GT(report["active_voxels"].get<int>(), 1000);
}

TEST(Bake, SchemaCheckerFindsWhatIsWrong) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    auto estimate = photic(place, {"bake", "pool.toml", "--dry-run", "--json"}).json();
    ASSERT_EQ(schemaBreaches(estimate, "estimate.md"), Strings{});
    estimate["surprise"] = 1;
    estimate["voxels"] = "many";
    estimate.erase("fits");
    estimate["grid"]["size"][1] = 0.5;
    EXPECT_EQ(schemaBreaches(estimate, "estimate.md").size(), 4U);
}

TEST(Bake, DryRunBakesNothing) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--dry-run", "--json", "--where", "receivers"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto estimate = outcome.json();
    EXPECT_EQ(schemaBreaches(estimate, "estimate.md"), Strings{});
    EXPECT_EQ(estimate["voxels"], 32 * 32 * 22);
    // The floor's band: two voxels on either side, of 22 layers.
    EXPECT_LE(estimate["needed_voxels"].get<int>(), 32 * 32 * 6);
    EXPECT_GE(estimate["needed_voxels"].get<int>(), 32 * 32 * 4);
    EXPECT_TRUE(estimate["fits"].get<bool>());
    EXPECT_NE(outcome.err.find("estimate"), std::string::npos);
    EXPECT_EQ(place.names(), Strings{"pool.toml"});

    // What will not fit is told, not tried.
    const Outcome huge =
        photic(place, {"bake", "pool.toml", "--dry-run", "--json", "--resolution", "6000", "--max-memory", "2GB"});
    EXPECT_EQ(huge.code, 0) << huge.err;
    EXPECT_FALSE(huge.json()["fits"].get<bool>());
}

TEST(Bake, ProgressIsJsonLinesAsDocumented) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--progress=json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    const auto events = outcome.events();
    ASSERT_GE(events.size(), 3U);
    double overall = 0;
    for (std::size_t i = 0; i + 1 < events.size(); ++i) {
        EXPECT_NE(events[i]["event"], "done");
        if (events[i]["event"] != "progress") continue;
        EXPECT_EQ(schemaBreaches(events[i], "progress.md", "`progress`"), Strings{});
        EXPECT_GE(events[i]["overall"].get<double>(), overall);
        overall = events[i]["overall"].get<double>();
    }
    EXPECT_EQ(overall, 1.0);
    const auto& done = events.back();
    EXPECT_EQ(schemaBreaches(done, "progress.md", "`done`"), Strings{});
    EXPECT_EQ(schemaBreaches(done["report"], "report.md"), Strings{});
    EXPECT_EQ(done["output"], "pool.vdb");
}

TEST(Bake, BarIsDrawnWhenAskedFor) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome bar = photic(place, {"bake", "pool.toml", "--progress", "bar"});
    EXPECT_EQ(bar.code, 0);
    EXPECT_NE(bar.err.find("100 %"), std::string::npos) << bar.err;
    // Not by itself when stderr is a file.
    EXPECT_EQ(photic(place, {"bake", "pool.toml"}).err.find('\r'), std::string::npos);
}

TEST(Bake, WarnsOfReceiversWithoutAVoxelBehindThem) {
    const Workplace place;
    PoolText pool;
    pool.extra = "[[object]]\nname = \"wall\"\nplane = { point = [1, 0, 0], normal = [-1, 0, 0] }";
    place.write("pool.toml", pool.text());
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("warning: wall lies at the edge"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.json()["warnings"].size(), 1U);
    pool.extra.replace(pool.extra.find("[1, 0, 0]"), 9, "[0.9, 0, 0]");
    place.write("pool.toml", pool.text());
    const Outcome inside = photic(place, {"bake", "pool.toml", "--progress=json"});
    EXPECT_EQ(inside.err.find("warning\""), std::string::npos) << inside.err;
}

/// A mesh whose faces are turned over, or agree not with one another, is said while it is baked, and in the report.
TEST(Bake, WarnsOfFacesThatAreTurnedOver) {
    const Workplace place;
    const std::string corners = "v -2 -2 0\nv 2 -2 0\nv 2 2 0.1\nv -2 2 0\n";
    place.write("up.obj", corners + "f 1 2 3\nf 1 3 4\n");
    place.write("down.obj", corners + "f 3 2 1\nf 4 3 1\n");
    place.write("mixed.obj", corners + "f 1 2 3\nf 4 3 1\n");
    const auto warnings = [&](const std::string& mesh) -> nlohmann::json {
        PoolText pool;
        pool.surface = "";
        std::string text = pool.text();
        const std::string waves = "kind = \"height_field\"\nsize = [4.0, 4.0]";
        text.replace(text.find(waves), waves.size(), "kind = \"mesh\"\nfile = \"" + mesh + "\"");
        place.write("pool.toml", text);
        const Outcome outcome = photic(place, {"bake", "pool.toml", "--json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        for (const auto& warning : outcome.json()["warnings"])
            EXPECT_NE(outcome.err.find("warning: " + warning.get<std::string>()), std::string::npos) << outcome.err;
        return outcome.json()["warnings"];
    };
    EXPECT_EQ(warnings("up.obj").size(), 0U);
    const nlohmann::json down = warnings("down.obj"), mixed = warnings("mixed.obj");
    ASSERT_EQ(down.size(), 1U) << down;
    EXPECT_NE(down[0].get<std::string>().find("100 % of the light"), std::string::npos) << down;
    ASSERT_EQ(mixed.size(), 1U) << mixed;
    EXPECT_NE(mixed[0].get<std::string>().find("1 of 2 faces"), std::string::npos) << mixed;
}

/// Suns from opposite sides: what one direction a voxel loses is said where the bake says everything else; two lose
/// nothing.
TEST(Bake, WarnsOfOpposedSuns) {
    const Workplace place;
    PoolText pool;
    pool.sun_direction = "[0.7660444431189781, 0.0, -0.6427876096865394]";
    place.write("one.toml", pool.text());
    pool.extra =
        "[[light]]\ntype = \"sun\"\nirradiance = 1000.0\ndirection = [-0.7660444431189781, 0.0, -0.6427876096865394]";
    place.write("two.toml", pool.text());
    const Outcome one = photic(place, {"bake", "one.toml"}), two = photic(place, {"bake", "two.toml"}),
                  kept_one = photic(place, {"bake", "two.toml", "--lobes", "1"});
    ASSERT_EQ(one.code, 0) << one.err;
    ASSERT_EQ(two.code, 0) << two.err;
    EXPECT_EQ(one.err.find("a voxel keeps one"), std::string::npos) << one.err;
    EXPECT_EQ(two.err.find("far apart"), std::string::npos) << two.err;
    EXPECT_NE(kept_one.err.find("a voxel keeps one"), std::string::npos) << kept_one.err;
}

/// What an artist sees at the floor, whatever the voxels hold.
TEST(Bake, SaysHowFarLookUpsAreOff) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome said = photic(place, {"bake", "pool.toml", "--measure", "all", "--report", "report.json"});
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_NE(said.err.find("look-ups are off by"), std::string::npos) << said.err;
    const auto report = nlohmann::json::parse(place.read("report.json"));
    ASSERT_FALSE(report["receivers"].empty());
    const double error = report["receivers"][0]["relative_l1"];
    EXPECT_GT(error, 0.01);
    EXPECT_NE(report["advice"].get<std::string>().find("--voxel-size"), std::string::npos);
    EXPECT_NE(photic(place, {"inspect", "pool.vdb"}).out.find("look-ups are off by"), std::string::npos);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--measure", "no"}).err.find("look-ups"), std::string::npos);

    const std::string goal = fmt::format("{:.3f}", 0.4 * error);
    const Outcome chosen = photic(place, {"bake", "pool.toml", "--error", goal, "--report", "chosen.json"});
    ASSERT_EQ(chosen.code, 0) << chosen.err;
    const auto better = nlohmann::json::parse(place.read("chosen.json"));
    EXPECT_EQ(schemaBreaches(better, "report.md"), Strings{});
    EXPECT_LE(better["receivers"][0]["relative_l1"].get<double>(), 0.4 * error);
    const Outcome frames = photic(place, {"bake", "pool.toml", "--error", "5%", "--frames", "1-2"});
    EXPECT_EQ(frames.code, 2);
    EXPECT_NE(frames.err.find("--voxel-size"), std::string::npos) << frames.err;
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--error", "x"}).code, 2);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--error", "0%"}).code, 2);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--error", "5%", "--voxel-size", "0.1"}).code, 2);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--detail", "-1"}).code, 2);
}

TEST(Bake, AimsAtAnErrorWhereNothingSaysHowWideVoxelsAre) {
    const Workplace place;
    PoolText pool;
    pool.surface = "waves = [{ amplitude = 0.02, wavelength = 0.6, direction = 20.0, phase = 0.4 }]";
    std::string text = pool.text();
    const auto line = text.find("voxel_size");
    ASSERT_NE(line, std::string::npos);
    text.erase(line, text.find('\n', line) - line);
    place.write("pool.toml", text);
    const auto reached = [&](std::vector<std::string> more) {
        std::vector<std::string> words{"bake", "pool.toml", "--report", "report.json", "-o", "p.vdb", "--force"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome said = photic(place, words);
        EXPECT_EQ(said.code, 0) << said.err;
        return nlohmann::json::parse(place.read("report.json"));
    };
    const auto by_itself = reached({});
    EXPECT_EQ(schemaBreaches(by_itself, "report.md"), Strings{});
    EXPECT_LE(by_itself["receivers"][0]["relative_l1"].get<double>(), 0.02);
    EXPECT_NE(photic(place, {"bake", "pool.toml", "--dry-run"}).err.find("for an error of 2 %"), std::string::npos);
    // A size, a sequence and a bake that is not to be measured have the domain's voxels.
    EXPECT_GT(reached({"--resolution", "32"})["receivers"][0]["relative_l1"].get<double>(), 0.02);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--dry-run", "--measure", "no"}).err.find("for an error"),
              std::string::npos);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--dry-run", "--frames", "1-2"}).err.find("for an error"),
              std::string::npos);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--budget", "0"}).code, 2);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "--seconds", "nan"}).code, 2);
    const Outcome little = photic(place, {"bake", "pool.toml", "--budget", "0.05", "-o", "little.vdb"});
    EXPECT_EQ(little.code, 0);
    EXPECT_NE(little.err.find("is aimed at"), std::string::npos) << little.err;
}

TEST(Bake, ThreadsChangeNothing) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--threads", "1", "--f32", "-o", "one.vdb"}).code, 0);
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--threads", "3", "--f32", "-o", "three.vdb"}).code, 0);
    const Outcome compared = photic(place, {"compare", "one.vdb", "three.vdb", "--max-error", "0", "--json"});
    EXPECT_EQ(compared.code, 0) << compared.out;
    EXPECT_EQ(compared.json()["irradiance"]["worst"]["difference"], 0.0);
}

TEST(Bake, CommandLineReplacesTheScenesSettings) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const auto bake = [&](const Strings& options) {
        Strings arguments{"bake", "pool.toml", "--json"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json();
    };
    const auto plain = bake({});
    EXPECT_EQ(bake({"--voxel-size", "0.125"})["grid"]["size"], (nlohmann::json{16, 16, 11}));
    EXPECT_EQ(bake({"--resolution", "16"})["grid"]["size"][0], 16);
    EXPECT_EQ(bake({"--where", "receivers"})["settings"]["where"], "receivers");
    EXPECT_EQ(bake({"--quadrature", "2"})["settings"]["quadrature"], 2);
    EXPECT_EQ(bake({"--lobes", "1"})["settings"]["lobes"], 1);
    EXPECT_EQ(bake({"--tolerance", "0.5"})["settings"]["tolerance"], 0.5);
    EXPECT_EQ(bake({"--prefilter"})["settings"]["prefilter"], true);
    PoolText filtered;
    filtered.bake = "prefilter = true";
    place.write("pool.toml", filtered.text());
    EXPECT_EQ(bake({})["settings"]["prefilter"], true);
    EXPECT_EQ(bake({"--no-prefilter"})["settings"]["prefilter"], false);
    place.write("pool.toml", PoolText{}.text());
    EXPECT_EQ(bake({"--grids", "irradiance"})["settings"]["grids"], nlohmann::json{"irradiance"});
    EXPECT_GT(bake({"--f32"})["file_bytes"].get<double>(), 1.3 * plain["file_bytes"].get<double>());
    EXPECT_GT(bake({"--compression", "none"})["file_bytes"].get<double>(), 2 * plain["file_bytes"].get<double>());
    EXPECT_NE(bake({"--quadrature", "4"})["scene_hash"], plain["scene_hash"]);
    EXPECT_EQ(bake({})["scene_hash"], plain["scene_hash"]);
}

TEST(Bake, AMediumAddsDensity) {
    const Workplace place;
    PoolText pool;
    pool.surface = "flat = true";
    pool.extra = "[medium]\nabsorption = [0.35, 0.07, 0.02]";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const Outcome inspected = photic(place, {"inspect", "pool.vdb", "--json"});
    bool found = false;
    const auto document = inspected.json();
    for (const auto& grid : document["grids"]) {
        if (grid["name"] == "irradiance") {
            EXPECT_EQ(grid["channels"], 3);
        }
        if (grid["name"] != "density") continue;
        found = true;
        EXPECT_EQ(grid["max"], 1.0);
    }
    EXPECT_TRUE(found) << inspected.out;
}

TEST(Bake, StandardErrorOfPhotonsScoresThem) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 16;
    place.write("pool.toml", pool.text());
    const Outcome photons = photic(place, {"bake", "pool.toml", "-o", "b.vdb", "--method", "photons",
                                           "--standard-error", "se.vdb", "--f32", "--set", "photons.count=200000"});
    ASSERT_EQ(photons.code, 0) << photons.err;
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "a.vdb", "--method", "photons", "--f32", "--set",
                             "photons.count=200000", "--set", "photons.seed=77"})
                  .code,
              0);
    const Outcome compared =
        photic(place, {"compare", "a.vdb", "b.vdb", "--standard-error", "se.vdb", "--bias-allowance", "0", "--json"});
    ASSERT_EQ(compared.code, 0) << compared.err;
    const auto scores = compared.json()["standard_error"];
    EXPECT_GT(scores["voxels"].get<int>(), 1000);
    // Both have the same variance, so the difference has twice b's; b's own comes from a few shifts and paths
    // (Student's t and worse).
    EXPECT_GT(scores["chi2_per_voxel"].get<double>(), 1.6);
    EXPECT_LT(scores["chi2_per_voxel"].get<double>(), 5);
    EXPECT_EQ(scores["chi2_per_voxel"], scores["chi2_per_voxel_without_allowance"]);
    EXPECT_EQ(scores["chi2_per_voxel"], scores["chi2_per_voxel_in_quadrature"]);
    // Of two equally noisy bakes, what the one's noise does not explain is as large as that noise.
    const Outcome sharp = photic(place, {"compare", "a.vdb", "b.vdb", "--standard-error", "se.vdb", "--json",
                                         "--most-standard-error", "0.05", "--bias-allowance", "0.02"});
    ASSERT_EQ(sharp.code, 0) << sharp.err;
    const auto few = sharp.json()["standard_error"];
    EXPECT_LT(few["voxels"].get<int>(), scores["voxels"].get<int>());
    EXPECT_GT(few["voxels"].get<int>(), 100);
    EXPECT_GT(few["bias_in_quadrature"].get<double>(), 0.005);
    EXPECT_LT(few["bias_in_quadrature"].get<double>(), 0.08);
    EXPECT_LT(few["chi2_per_voxel_in_quadrature"], few["chi2_per_voxel_without_allowance"]);
    const Outcome same = photic(place, {"compare", "b.vdb", "b.vdb", "--standard-error", "se.vdb", "--json"});
    EXPECT_EQ(same.json()["standard_error"]["bias_in_quadrature"], 0.0);
    const Outcome alone = photic(place, {"compare", "a.vdb", "b.vdb", "--most-standard-error", "0.05"});
    EXPECT_EQ(alone.code, 2);
    EXPECT_NE(alone.err.find("--standard-error gives"), std::string::npos) << alone.err;
    // Beams know none.
    const Outcome refused =
        photic(place, {"bake", "pool.toml", "-o", "c.vdb", "--method", "beams", "--standard-error", "x.vdb"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_FALSE(place.has("x.vdb"));
}

}  // namespace
}  // namespace photic::test
