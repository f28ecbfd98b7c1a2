// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bake/web/web_page.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

/// What a script hands to a function, with arguments of JSON.
json handed(const std::string& script) {
    const auto open = script.find('('), close = script.rfind(')');
    std::string arguments = "[";
    arguments.append(script, open + 1, close - open - 1).append("]");
    return json::parse(arguments);
}

TEST(Page, HoldsTheSceneAndOneFileAFrame) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    pool.extra =
        "[[object]]\nname = \"ball\"\nfile = \"ball.obj\"\nrole = \"movable\"\nalbedo = [0.1, 0.2, 0.3]\n"
        "[medium]\nscattering = 0.05\nabsorption = [0.35, 0.07, 0.02]\nanisotropy = 0.8\n";
    place.write("ball.obj", "v -.1 0 -.5\nv .1 0 -.5\nv 0 .1 -.5\nv 0 0 -.4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    place.write("pool.toml", "frame_rate = 6.0\n" + pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-2"}).code, 0);
    const Outcome outcome = photic(
        place, {"export", "pool.0001.vdb", "pool.0002.vdb", "--scene", "pool.toml", "--web", "new/page", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.json()["format"], "web");
    for (const char* file : {"index.html", "photic.js", "scene.js", "frame.0001.js", "frame.0002.js"})
        EXPECT_TRUE(place.has(std::string("new/page/") + file)) << file;
    EXPECT_EQ(place.read("new/page/index.html"), std::string(webPageHtml()));
    EXPECT_EQ(place.read("new/page/photic.js"), webPageScript());

    const json scene = handed(place.read("new/page/scene.js"))[0];
    EXPECT_EQ(scene["title"], "Pool");
    EXPECT_EQ(scene["frame_rate"], 6.0);
    EXPECT_EQ(scene["frames"],
              (json{{{"frame", 1}, {"file", "frame.0001.js"}}, {{"frame", 2}, {"file", "frame.0002.js"}}}));
    EXPECT_EQ(scene["medium"]["absorption"], (json{0.35, 0.07, 0.02}));
    EXPECT_NEAR(scene["medium"]["haze"].get<double>(), 0.05, 1e-12);
    EXPECT_EQ(scene["coloured"], true);
    EXPECT_EQ(scene["metadata"]["reference_irradiance"], 1000.0);
    ASSERT_EQ(scene["receivers"].size(), 2u);
    EXPECT_EQ(scene["receivers"][0]["name"], "floor");
    EXPECT_EQ(scene["receivers"][0]["plane"]["normal"], (json{0.0, 0.0, 1.0}));
    EXPECT_EQ(scene["receivers"][1]["albedo"], (json{0.1, 0.2, 0.3}));
    EXPECT_TRUE(scene["receivers"][1].contains("mesh"));
    // Frames share one box, whatever is lit in each, and have their own water.
    const json first = handed(place.read("new/page/frame.0001.js")),
               second = handed(place.read("new/page/frame.0002.js"));
    EXPECT_EQ(first[0], 1);
    EXPECT_EQ(second[0], 2);
    EXPECT_NE(first[1]["light"], second[1]["light"]);
    EXPECT_NE(first[1]["heights"], second[1]["heights"]);
    EXPECT_TRUE(first[1].contains("rgb"));
}

TEST(Page, PagesBesideEachOtherShareOneScript) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    for (const char* folder : {"pages/one", "pages/two/"})
        ASSERT_EQ(
            photic(place, {"export", "pool.vdb", "--scene", "pool.toml", "--web", folder, "--shared-script"}).code, 0);
    EXPECT_EQ(place.read("pages/photic.js"), webPageScript());
    for (const std::string folder : {"pages/one/", "pages/two/"}) {
        EXPECT_FALSE(place.has(folder + "photic.js"));
        EXPECT_NE(place.read(folder + "index.html").find("<script src=\"../photic.js\">"), std::string::npos);
    }
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "pool.nvdb", "--shared-script"}).code, 2);
}

TEST(Page, PlanesEndWhereTheyMeet) {
    const Workplace place;
    PoolText pool;
    // A wall that stands in the domain: what of the floor lies behind it is not seen, nor what of it lies below.
    pool.extra = "[[object]]\nname = \"wall\"\nplane = { point = [0.5, 0, 0], normal = [-1, 0, 0] }\n";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "--scene", "pool.toml", "--web", "page"}).code, 0);
    const json receivers = handed(place.read("page/scene.js"))[0]["receivers"];
    ASSERT_EQ(receivers.size(), 2u);
    for (const json& corner : receivers[0]["plane"]["corners"]) EXPECT_LE(corner[0], 0.5 + 1e-9);
    for (const json& corner : receivers[1]["plane"]["corners"]) EXPECT_GE(corner[2], -1.0 - 1e-9);
}

TEST(Page, MistakesAreRefusedAndLargePagesWarnedAbout) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 300;
    pool.bake = "where = \"receivers\"\nband = 1\n";
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const auto expectUsage = [&](const Strings& arguments, const char* word) {
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, 2) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
        EXPECT_FALSE(place.has("page/index.html"));
    };
    expectUsage({"export", "pool.vdb", "--web", "page"}, "--scene");
    expectUsage({"export", "pool.vdb", "--web", "page", "--scene", "pool.toml", "-o", "a.nvdb"}, "either --web or -o");
    expectUsage({"export", "pool.vdb"}, "-o");
    expectUsage({"export", "pool.vdb", "--web", "page", "--scene", "pool.toml", "--codec", "zip"}, "--codec");
    const Outcome large = photic(place, {"export", "pool.vdb", "--web", "page", "--scene", "pool.toml"});
    EXPECT_EQ(large.code, 0) << large.err;
    EXPECT_NE(large.err.find("256"), std::string::npos) << large.err;
    EXPECT_NE(large.err.find("--budget"), std::string::npos) << large.err;
    // What makes it smaller makes it fit.
    const Outcome less =
        photic(place, {"export", "pool.vdb", "--web", "less", "--scene", "pool.toml", "--budget", "1", "-q"});
    EXPECT_EQ(less.code, 0) << less.err;
    EXPECT_EQ(less.err.find("256"), std::string::npos) << less.err;
}

}  // namespace
}  // namespace photic::test
