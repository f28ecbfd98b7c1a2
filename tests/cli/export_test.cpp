// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

TEST(Export, WritesEveryFormatAndSaysWhat) {
    const Workplace place;
    PoolText pool;
    pool.extra = "[medium]\nscattering = 0.05\nabsorption = [0.35, 0.07, 0.02]\nanisotropy = 0.8\n";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    for (const auto& [name, files] :
         std::map<std::string, Strings>{{"a.nvdb", {"a.nvdb"}},
                                        {"b.ktx2", {"b.ktx2", "b_rgb.ktx2"}},
                                        {"c.dds", {"c.dds", "c_rgb.dds", "c.dds.json"}},
                                        {"d.vf", {"d.vf", "d_flux.vf", "d_rgb.vf", "d.vf.json"}},
                                        {"e.exr", {"e.exr", "e_rgb.exr", "e.exr.json"}}}) {
        const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", name, "--json"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const auto document = outcome.json();
        EXPECT_EQ(schemaBreaches(document, "export.md"), Strings{});
        const auto& frame = document["frames"][0];
        ASSERT_EQ(frame["files"].size(), files.size());
        std::uintmax_t bytes = 0;
        for (std::size_t i = 0; i < files.size(); ++i) {
            EXPECT_EQ(frame["files"][i]["path"], files[i]);
            EXPECT_EQ(frame["files"][i]["bytes"], std::filesystem::file_size(place / files[i]));
            bytes += std::filesystem::file_size(place / files[i]);
        }
        EXPECT_EQ(frame["bytes"], bytes);
        EXPECT_GT(frame["voxels"], 0);
        EXPECT_EQ(frame["cut_values"], 0);
        EXPECT_NE(outcome.err.find(name), std::string::npos);
    }
    for (const char* sidecar : {"c.dds.json", "d.vf.json"}) {
        const auto json = nlohmann::json::parse(place.read(sidecar));
        EXPECT_EQ(schemaBreaches(json, "runtime.md"), Strings{}) << sidecar;
        EXPECT_EQ(json["absorption"], (nlohmann::json{0.35, 0.07, 0.02}));
        EXPECT_EQ(json["scattering"], 0.05);
        EXPECT_EQ(json["anisotropy"], 0.8);
        EXPECT_FALSE(json.contains("period"));
    }
    const Outcome full = photic(place, {"export", "pool.vdb", "-o", "f.nvdb", "--precision", "float", "--json"});
    EXPECT_EQ(full.json()["precision"], "float");
    EXPECT_GT(std::filesystem::file_size(place / "f.nvdb"), std::filesystem::file_size(place / "a.nvdb") / 2);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "z.nvdb", "--codec", "zip"}).code, 0);
    EXPECT_LT(std::filesystem::file_size(place / "z.nvdb"), std::filesystem::file_size(place / "a.nvdb"));
}

TEST(Export, WritesAScenesIndexForGames) {
    const Workplace place;
    place.write("lens.toml", R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 1]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1000
[[medium]]
name = "lens"
index = { kind = "luneburg", radius = 0.8 }
absorption = [0.1, 0.2, 0.3]
emission = 5
)");
    const Outcome outcome = photic(place, {"export", "lens.toml", "-o", "lens.ivol", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto document = outcome.json();
    EXPECT_EQ(schemaBreaches(document, "export.md"), Strings{});
    EXPECT_EQ(document["format"], "ivol");
    EXPECT_EQ(document["frames"][0]["size"], (nlohmann::json{41, 41, 41}));
    // Header, object, spline, attenuation, emission.
    EXPECT_EQ(place.read("lens.ivol").size(), 288U + 41 * 41 * 41 * 4 + 12 + 2 * (41 * 41 * 41 * 8) + 8);
    EXPECT_NE(outcome.err.find("no faces"), std::string::npos) << outcome.err;
    ASSERT_EQ(photic(place, {"export", "lens.toml", "-o", "fine.ivol", "--voxel-size", "0.025"}).code, 0);
    EXPECT_GT(place.read("fine.ivol").size(), 4 * place.read("lens.ivol").size());
    for (const Strings& wrong :
         {Strings{"lens.toml", "-o", "b.ivol", "--budget", "4"}, Strings{"lens.vdb", "-o", "b.ivol"},
          Strings{"lens.toml", "lens.toml", "-o", "b.ivol"}}) {
        Strings all{"export"};
        all.insert(all.end(), wrong.begin(), wrong.end());
        EXPECT_EQ(photic(place, all).code, 2) << wrong.back();
    }
    place.write("pool.toml", PoolText().text());
    const Outcome none = photic(place, {"export", "pool.toml", "-o", "b.ivol"});
    EXPECT_EQ(none.code, 3);
    EXPECT_NE(none.err.find("no body of glass"), std::string::npos) << none.err;
    EXPECT_FALSE(place.has("b.ivol"));
}

// Bodies of one index: as they are, or as samples; and one whose index varies, within its own faces.
TEST(Export, BodiesOfGlassHaveSharpFaces) {
    const Workplace place;
    const std::string scene = R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 1]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0, 0, -1]
[[medium]]
name = "glass"
ior = 1.5
[[surface]]
name = "ball"
kind = "sphere"
position = [0.2, 0, 0]
radius = 0.5
inside = "glass"
)";
    place.write("ball.toml", scene);
    const Outcome sharp = photic(place, {"export", "ball.toml", "-o", "ball.ivol", "--json"});
    ASSERT_EQ(sharp.code, 0) << sharp.err;
    EXPECT_NE(sharp.err.find("ball: a ball, with sharp faces"), std::string::npos) << sharp.err;
    EXPECT_EQ(schemaBreaches(sharp.json(), "export.md"), Strings{});
    EXPECT_EQ(place.read("ball.ivol").size(), 32U + 320 + 80);
    const Outcome samples = photic(place, {"export", "ball.toml", "-o", "samples.ivol", "--bodies", "samples"});
    ASSERT_EQ(samples.code, 0) << samples.err;
    EXPECT_NE(samples.err.find("faces at"), std::string::npos) << samples.err;
    EXPECT_GT(place.read("samples.ivol").size(), 100000U);
    std::string graded = scene;
    graded.replace(graded.find("ior = 1.5"), 9, R"(index = { kind = "fish_eye", n0 = 1.6, scale = 3 })");
    place.write("graded.toml", graded);
    const Outcome filled = photic(place, {"export", "graded.toml", "-o", "graded.ivol"});
    ASSERT_EQ(filled.code, 0) << filled.err;
    EXPECT_NE(filled.err.find("a ball, with sharp faces, 30 x 30 x 30 nodes in it"), std::string::npos) << filled.err;
    EXPECT_EQ(photic(place, {"export", "ball.toml", "-o", "b.ivol", "--bodies", "soft"}).code, 2);
}

/// The values of an attribute in a layer of USD: what follows its `=`, a line each.
Strings attributes(const std::string& layer, const std::string& name) {
    Strings values;
    for (auto at = layer.find(name + " = "); at != std::string::npos; at = layer.find(name + " = ", at + 1)) {
        const auto begin = at + name.size() + 3;
        values.push_back(layer.substr(begin, layer.find('\n', begin) - begin));
    }
    return values;
}

TEST(Export, UsdReferesToVolumesWithUnitsAndFrames) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    pool.extra = "[medium]\nabsorption = [0.35, 0.07, 0.02]\n";
    place.write("pool.toml", "frame_rate = 6.0\n" + pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-2"}).code, 0);
    const Outcome outcome = photic(place, {"export", "pool.0001.vdb", "pool.0002.vdb", "--scene", "pool.toml", "-o",
                                           "shot/2 pools.usda", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(schemaBreaches(outcome.json(), "export.md"), Strings{});
    const std::string layer = place.read("shot/2 pools.usda");
    EXPECT_TRUE(layer.starts_with("#usda 1.0\n(")) << layer;
    EXPECT_EQ(attributes(layer, "metersPerUnit"), Strings{"1"});
    EXPECT_EQ(attributes(layer, "upAxis"), Strings{"\"Z\""});
    EXPECT_EQ(attributes(layer, "timeCodesPerSecond"), Strings{"6"});
    EXPECT_EQ(attributes(layer, "startTimeCode"), Strings{"1"});
    EXPECT_EQ(attributes(layer, "endTimeCode"), Strings{"2"});
    EXPECT_EQ(attributes(layer, "double reference_irradiance"), Strings{"1000"});
    // A name that USD takes; every relation leads to a prim of the layer, every file is there.
    EXPECT_EQ(attributes(layer, "defaultPrim"), Strings{"\"_2_pools\""});
    for (const std::string grid : {"irradiance", "direction", "density"}) {
        EXPECT_EQ(attributes(layer, "rel field:" + grid), Strings{"</_2_pools/Grids/" + grid + ">"});
        EXPECT_NE(layer.find("def OpenVDBAsset \"" + grid + "\""), std::string::npos) << layer;
    }
    EXPECT_EQ(attributes(layer, "token fieldDataType"), (Strings{"\"float3\"", "\"float3\"", "\"float\""}));
    EXPECT_EQ(attributes(layer, "token vectorDataRoleHint"), (Strings{"\"Color\"", "\"Vector\"", "\"None\""}));
    for (const char* sample : {"1: @../pool.0001.vdb@,", "2: @../pool.0002.vdb@,"})
        EXPECT_NE(layer.find(sample), std::string::npos) << layer;
    // Brackets and quotes close.
    std::string open;
    bool quoted = false, asset = false;
    for (std::size_t i = 0; i < layer.size(); ++i) {
        const char c = layer[i];
        if (c == '\\')
            ++i;
        else if (c == '"')
            quoted = !quoted;
        else if (c == '@' && !quoted)
            asset = !asset;
        else if (quoted || asset)
            continue;
        else if (c == '(' || c == '{' || c == '[')
            open += c;
        else if (c == ')' || c == '}' || c == ']') {
            ASSERT_FALSE(open.empty()) << "at " << i;
            EXPECT_EQ(open.back(), c == ')' ? '(' : c == '}' ? '{' : '[') << "at " << i;
            open.pop_back();
        }
    }
    EXPECT_EQ(open, "");
    EXPECT_FALSE(quoted || asset);

    ASSERT_EQ(photic(place, {"export", "pool.0001.vdb", "-o", "one.usda"}).code, 0);
    EXPECT_EQ(attributes(place.read("one.usda"), "asset filePath"), (Strings(3, "@./pool.0001.vdb@")));
    const Outcome budget = photic(place, {"export", "pool.0001.vdb", "-o", "b.usda", "--budget", "4"});
    EXPECT_EQ(budget.code, 2);
    EXPECT_FALSE(place.has("b.usda"));
}

TEST(Export, HarmonicsAreThreeTextures) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", "pool.dds", "--l1", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(schemaBreaches(outcome.json(), "export.md"), Strings{});
    EXPECT_EQ(outcome.json()["format"], "l1");
    for (const char* file : {"pool_0.dds", "pool_1.dds", "pool_2.dds", "pool.dds.json"})
        EXPECT_TRUE(place.has(file)) << file;
    EXPECT_FALSE(place.has("pool.dds"));
    EXPECT_EQ(schemaBreaches(nlohmann::json::parse(place.read("pool.dds.json")), "runtime.md"), Strings{});
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "pool.nvdb", "--l1"}).code, 2);
}

TEST(Export, PeriodicLightSaysItsPeriod) {
    const Workplace place;
    PoolText pool;
    pool.surface =
        "waves = [{ amplitude = 0.03, wavelength = 1.0, direction = 0.0, phase = 0.4 }]\noutside = \"periodic\"";
    for (const bool whole_period_in_box : {false, true}) {
        std::string text = pool.text();
        if (whole_period_in_box) text.replace(text.find("size = [4.0, 4.0]"), 17, "size = [2.0, 1.0]");
        place.write("pool.toml", text);
        const Outcome bake = photic(place, {"bake", "pool.toml"});
        ASSERT_EQ(bake.code, 0) << bake.err;
        ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "a.dds"}).code, 0);
        const auto json = nlohmann::json::parse(place.read("a.dds.json"));
        EXPECT_EQ(schemaBreaches(json, "runtime.md"), Strings{});
        ASSERT_EQ(json.contains("period"), whole_period_in_box);
        if (whole_period_in_box) {
            EXPECT_EQ(json["period"], (nlohmann::json{2, 1, 0}));
        }
    }
}

TEST(Export, SequencesBecomeOneFileAFrame) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-2"}).code, 0);
    const Outcome outcome = photic(place, {"export", "pool.0001.vdb", "pool.0002.vdb", "-o", "x.####.nvdb", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.json()["frames"][1]["files"][0]["path"], "x.0002.nvdb");
    ASSERT_EQ(photic(place, {"export", "pool.0001.vdb", "pool.0002.vdb", "-o", "x.####.ktx2"}).code, 0);
    EXPECT_EQ(std::filesystem::file_size(place / "x.0001.ktx2"), std::filesystem::file_size(place / "x.0002.ktx2"));
}

TEST(Export, PartsOfASequenceAreLaidOutAsTheWhole) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    // What a moving bump focuses differs from frame to frame in its extent: only the receivers' band is kept.
    pool.bake = "where = \"receivers\"\nband = 1\n";
    pool.sun_direction = "[0, 0, -1]";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-3"}).code, 0);
    const Strings all{"pool.0001.vdb", "pool.0002.vdb", "pool.0003.vdb"};
    for (const char* folder : {"whole", "part"}) std::filesystem::create_directory(place / folder);
    const auto exported = [&](Strings volumes, const std::string& output, const Strings& options) {
        Strings command{"export"};
        command.insert(command.end(), volumes.begin(), volumes.end());
        command.insert(command.end(), {"-o", output});
        command.insert(command.end(), options.begin(), options.end());
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
    };
    exported(all, "whole/a.####.ktx2", {});
    for (const std::string frame : {"0001", "0002", "0003"}) {
        exported({"pool." + frame + ".vdb"}, "part/a.####.ktx2", {"--sequence", all[0], all[1], all[2]});
        EXPECT_TRUE(place.read("part/a." + frame + ".ktx2") == place.read("whole/a." + frame + ".ktx2")) << frame;
    }
    // One plan of a budget too: that of the frame that must leave out the most.
    exported(all, "whole/a.####.nvdb", {"--budget", "0.3"});
    exported({all[1]}, "part/a.nvdb", {"--budget", "0.3", "--sequence", all[0], all[1], all[2]});
    EXPECT_TRUE(place.read("part/a.nvdb") == place.read("whole/a.0002.nvdb"));
}

TEST(Export, ABoxSaysWhatDenseFilesHold) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const auto sizeOf = [&](const std::string& box, const std::string& output) {
        const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", output, "--box=" + box, "--json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json()["frames"][0]["size"];
    };
    // Voxels of 1/16 m, centred at odd multiples of 1/32: 16 in a metre, whether there is light or not.
    EXPECT_EQ(sizeOf("-0.5,-0.5,-1,0.5,0.5,0", "a.ktx2"), (nlohmann::json{16, 16, 16}));
    EXPECT_EQ(sizeOf("-2,-1,-0.5,2,1,0", "a.exr"), (nlohmann::json{64, 32, 8}));
    const auto sidecar = nlohmann::json::parse(place.read("a.exr.json"));
    EXPECT_NEAR(sidecar["bounds_world"]["min"][0].get<double>(), -2, 1e-9);
    EXPECT_NEAR(sidecar["bounds_world"]["max"][2].get<double>(), 0, 1e-9);
    for (const char* box : {"1,2,3", "0,0,0,0,1,1", "1,0,0,0,1,1", "nan,0,0,1,1,1", "0,0,0,1,1,1,1", "0,0,0,1e-3,1,1",
                            "-1e300,0,0,1e300,1,1"}) {
        const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", "b.ktx2", std::string("--box=") + box});
        EXPECT_EQ(outcome.code, 2) << box << outcome.err;
        EXPECT_NE(outcome.err.find("--box"), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "b.nvdb", "--box=-1,-1,-1,1,1,1"}).code, 2);
    EXPECT_FALSE(place.has("b.ktx2"));
    EXPECT_FALSE(place.has("b.nvdb"));
}

TEST(Export, BudgetsAreKeptAndTheirErrorIsSaid) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const auto budgetOf = [&](const Strings& arguments) {
        Strings all{"export", "pool.vdb", "--json"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Outcome outcome = photic(place, all);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        const auto document = outcome.json();
        EXPECT_EQ(schemaBreaches(document, "export.md"), Strings{});
        return document["frames"][0]["budget"];
    };
    const auto ample = budgetOf({"-o", "a.nvdb", "--budget", "100"});
    EXPECT_EQ(ample["factor"], 1);
    EXPECT_LT(ample["error"]["volume"]["relative_rmse"], 1e-3);
    EXPECT_EQ(ample["error"]["volume"]["light_kept"], 1.0);
    EXPECT_TRUE(ample["error"]["receivers"].empty());
    // Coarser voxels cost more the fewer they are.
    double last = ample["error"]["volume"]["relative_l1"];
    std::int64_t bytes = ample["game_bytes"];
    for (const char* name : {"b.nvdb", "b.ktx2"}) {
        const double budget = static_cast<double>(bytes) / 4 / (1 << 20);
        const auto tight = budgetOf({"-o", name, "--budget", std::to_string(budget)});
        EXPECT_GT(tight["factor"], 1);
        EXPECT_LE(tight["game_bytes"], bytes / 4);
        EXPECT_GT(tight["error"]["volume"]["relative_l1"], last);
    }
    // With its receivers known, a band keeps them sharp.
    const auto band = budgetOf({"-o", "c.nvdb", "--scene", "pool.toml", "--budget",
                                std::to_string(static_cast<double>(bytes) / 3 / (1 << 20))});
    EXPECT_EQ(band["factor"], 1);
    EXPECT_TRUE(band["band"].is_number());
    EXPECT_LT(band["error"]["receivers"][0]["relative_rmse"], 1e-3);
    EXPECT_LT(band["error"]["volume"]["light_kept"], 0.9);

    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "d.nvdb", "--budget", "0.00001"}).code, 3);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "d.nvdb", "--budget", "nan"}).code, 2);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "d.nvdb", "--budget", "-1"}).code, 2);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "d.nvdb", "--scene", "pool.toml"}).code, 2);
    EXPECT_FALSE(place.has("d.nvdb"));
}

TEST(Export, LightIsCompressedWhereThatIsAskedForOrBetter) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const auto budgetOf = [&](const Strings& arguments) {
        Strings all{"export", "pool.vdb", "-o", "a.nvdb", "--json"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Outcome outcome = photic(place, all);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(schemaBreaches(outcome.json(), "export.md"), Strings{});
        return outcome.json()["frames"][0]["budget"];
    };
    const auto halves = budgetOf({"--budget", "100"}), blocks = budgetOf({"--compress", "bc6h"});
    EXPECT_EQ(halves["compression"], "none");
    EXPECT_EQ(blocks["compression"], "bc6h");
    EXPECT_EQ(blocks["factor"], 1);
    EXPECT_LT(blocks["game_bytes"].get<double>(), 0.5 * halves["game_bytes"].get<double>());
    EXPECT_LT(blocks["error"]["volume"]["relative_l1"].get<double>(), 0.03);
    // With room for all, half floats are nearer; in a third of it, blocks are.
    const double mib = halves["game_bytes"].get<double>() / (1 << 20);
    EXPECT_EQ(budgetOf({"--compress", "auto", "--budget", std::to_string(1.1 * mib)})["compression"], "none");
    EXPECT_EQ(budgetOf({"--compress", "auto", "--budget", std::to_string(mib / 3)})["compression"], "bc6h");
    for (const Strings& wrong :
         {Strings{"-o", "b.nvdb", "--compress", "auto"}, Strings{"-o", "b.nvdb", "--compress", "jpg"},
          Strings{"-o", "b.ktx2", "--compress", "bc6h"}}) {
        Strings all{"export", "pool.vdb"};
        all.insert(all.end(), wrong.begin(), wrong.end());
        const Outcome outcome = photic(place, all);
        EXPECT_EQ(outcome.code, 2) << outcome.err;
        EXPECT_NE(outcome.err.find("--compress"), std::string::npos) << outcome.err;
    }
    EXPECT_FALSE(place.has("b.nvdb"));
}

// Less than a band takes: the smooth parts of it at half the resolution, before all of it.
TEST(Export, TwoLevelsAreFarNearerThanOneForTheSameBytes) {
    const Workplace place;
    const std::string scene = PHOTIC_SOURCE_DIR "/examples/pool/pool.toml";
    ASSERT_EQ(photic(place, {"bake", scene, "--where", "receivers", "-o", "band.vdb", "--voxel-size", "0.0156"}).code,
              0);
    const auto budgetOf = [&](const char* levels, double mib) {
        const Outcome outcome = photic(place, {"export", "band.vdb", "-o", "band.nvdb", "--budget", std::to_string(mib),
                                               "--scene", scene, "--levels", levels, "--json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(schemaBreaches(outcome.json(), "export.md"), Strings{});
        return outcome.json()["frames"][0]["budget"];
    };
    const auto all = budgetOf("2", 100);
    EXPECT_EQ(all["coarse_bricks"], 0.0);
    // The narrowest band in one level, and two thirds of that.
    const auto narrow = budgetOf("1", 0.6 * all["game_bytes"].get<double>() / (1 << 20));
    EXPECT_EQ(narrow["factor"], 1);
    const double bytes = 0.66 * narrow["game_bytes"].get<double>(), mib = bytes / (1 << 20);
    const auto one = budgetOf("1", mib), two = budgetOf("2", mib);
    EXPECT_EQ(one["factor"], 2);
    EXPECT_EQ(two["factor"], 1);
    EXPECT_GT(two["coarse_bricks"], 0.05);
    EXPECT_LE(two["game_bytes"].get<double>(), bytes);
    for (std::size_t r = 0; r < 3; ++r) {
        EXPECT_LT(two["error"]["receivers"][r]["relative_l1"].get<double>(),
                  0.5 * one["error"]["receivers"][r]["relative_l1"].get<double>());
    }
}

TEST(Export, ThePoolsReceiverBandFitsSixteenMegabytes) {
    const Workplace place;
    const std::string scene = PHOTIC_SOURCE_DIR "/examples/pool/pool.toml";
    ASSERT_EQ(photic(place, {"bake", scene, "--where", "receivers", "-o", "band.vdb"}).code, 0);
    const Outcome outcome =
        photic(place, {"export", "band.vdb", "-o", "band.nvdb", "--budget", "16", "--scene", scene, "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto budget = outcome.json()["frames"][0]["budget"];
    EXPECT_LE(budget["game_bytes"], 16 << 20);
    EXPECT_EQ(budget["error"]["receivers"].size(), 3u);
    for (const auto& receiver : budget["error"]["receivers"]) EXPECT_LT(receiver["relative_rmse"], 0.01) << receiver;
}

TEST(Export, MistakesAreUsageErrors) {
    const Workplace place;
    for (const Strings& arguments :
         {Strings{"-o", "a.png"}, Strings{"-o", "a"}, Strings{"-o", "a.ktx2", "--precision", "half"},
          Strings{"-o", "a.exr", "--codec", "zip"}, Strings{"-o", "a.nvdb", "--precision", "double"},
          Strings{"-o", "a.nvdb", "--codec", "lz4"}, Strings{}}) {
        Strings all{"export", "pool.vdb"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Outcome outcome = photic(place, all);
        EXPECT_EQ(outcome.code, 2) << outcome.err;
        EXPECT_NE(outcome.err, "");
    }
    EXPECT_EQ(photic(place, {"export", "missing.vdb", "-o", "a.nvdb"}).code, 3);
    EXPECT_EQ(place.names(), Strings{});
}

TEST(Export, AFullDiskLeavesTheOldFile) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    for (const char* name : {"a.nvdb", "a.ktx2", "a.dds", "a.vf"}) {
        place.write(name, "old");
        const Strings before = place.names();
        const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", name}, 100000);
        EXPECT_EQ(outcome.code, 4) << name;
        EXPECT_NE(outcome.err.find("limit on file sizes"), std::string::npos) << outcome.err;
        EXPECT_EQ(place.read(name), "old");
        EXPECT_EQ(place.names(), before);
    }
}

}  // namespace
}  // namespace photic::test
