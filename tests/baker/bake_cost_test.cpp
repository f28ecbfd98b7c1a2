// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_cost.h"

#include <gtest/gtest.h>

#include "bake/baker/bake_scene.h"
#include "bake/field/scene_grid.h"
#include "tests/baker/pool_scene.h"

namespace photic {
namespace {

using test::poolScene;
using test::Record;
using test::sceneFor;

BakeCost costOf(const Scene& scene) {
    return bakeCost(scene, chooseMethod(scene.bake.method, scene), sceneFrame(scene), nullptr, {});
}

// A bar is drawn from these: what a method reports must be what its row announced, in that order.
TEST(BakeCost, ProgressKeepsToTheStagesThatWereAnnounced) {
    for (const Method& method : methodCatalogue()) {
        Scene scene = sceneFor(method, "[medium]\nscattering = [0.1, 0.2, 0.3]\n");
        scene.bake.method = method.name;
        scene.bake.prefilter = true;
        Record monitor;
        std::vector<Stage> expected;
        BakeChoices choices;
        choices.expect = [&](const std::vector<Stage>& stages) { expected = stages; };
        bakeScene(scene, monitor, choices);
        ASSERT_FALSE(expected.empty());
        std::size_t at = 0;
        double fraction = 0;
        bool own = false;
        for (const Record::Step& step : monitor.steps) {
            std::size_t stage = 0;
            while (stage < expected.size() && expected[stage].name != step.stage) ++stage;
            ASSERT_LT(stage, expected.size()) << method.name << " reports '" << step.stage << "'";
            EXPECT_GE(stage, at) << method.name << " goes back to '" << step.stage << "'";
            EXPECT_TRUE(stage != at || step.fraction >= fraction - 1e-12)
                << method.name << " takes back what was done of '" << step.stage << "'";
            EXPECT_LE(step.fraction, 1 + 1e-12) << method.name << ", " << step.stage;
            at = stage, fraction = step.fraction;
            own = own || (stage > 1 && stage + 3 < expected.size());
        }
        EXPECT_TRUE(own) << method.name << " says nothing while it works";
    }
}

TEST(BakeCost, GrowsWithTheWork) {
    for (const Method& method : methodCatalogue()) {
        Scene coarse = sceneFor(method), fine = sceneFor(method, {}, 1.0 / 64);
        coarse.bake.method = fine.bake.method = method.name;
        const BakeCost a = costOf(coarse), b = costOf(fine);
        EXPECT_GT(b.seconds(), a.seconds()) << method.name;
        EXPECT_GT(b.memory_bytes, a.memory_bytes) << method.name;
        EXPECT_EQ(b.needed_voxels, 64 * a.needed_voxels);
        for (const Stage& stage : b.stages) EXPECT_GE(stage.seconds, 0) << method.name << ", " << stage.name;
    }
}

TEST(BakeCost, NamesTheSettingThatCostsMost) {
    Scene scene = poolScene();
    EXPECT_EQ(costOf(scene).dearest, "");
    scene.lights.front().angular_diameter_deg = 0.53;
    scene.bake.method_options["beams"] = {{"disc", {std::string("sample"), "test"}}};
    const std::string dearest = costOf(scene).dearest;
    EXPECT_NE(dearest.find("32 directions"), std::string::npos) << dearest;
    const auto light = [](const BakeCost& cost) {
        double seconds = 0;
        for (const Stage& stage : cost.stages) seconds += stage.name == "light" ? stage.seconds : 0;
        return seconds;
    };
    EXPECT_GT(light(costOf(scene)), 20 * light(costOf(poolScene())));
}

}  // namespace
}  // namespace photic
