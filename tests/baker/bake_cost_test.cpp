// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <memory>

#include "bake/baker/bake_scene.h"
#include "bake/baker/machine_speed.h"
#include "bake/field/scene_grid.h"
#include "bake/threads/parallel_for.h"
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

/// The pool below a sheet of ripples of so many cells a side, a quarter of a metre each.
Scene sheetOver(int cells) {
    Scene scene = poolScene();
    auto sheet = std::make_shared<TriangleMesh>();
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const glm::dvec2 at = 0.25 * (glm::dvec2(i, j) - 0.5 * cells);
            sheet->positions.emplace_back(at, 0.02 * std::sin(3 * at.x + at.y));
            sheet->normals.emplace_back(0, 0, 1);
        }
    const auto vertex = [cells](int i, int j) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            sheet->triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
            sheet->triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    scene.surfaces.front().height_field.reset(), scene.surfaces.front().mesh = sheet;
    return scene;
}

TEST(BakeCost, NamesAMeshThatReachesFarBeyondTheDomain) {
    const BakeCost wide = costOf(sheetOver(160)), near = costOf(sheetOver(6));
    EXPECT_NE(wide.dearest.find("'water'"), std::string::npos) << wide.dearest;
    EXPECT_NE(wide.dearest.find("passes the domain"), std::string::npos) << wide.dearest;
    EXPECT_EQ(near.dearest, "");
    EXPECT_GT(wide.seconds(), 5 * near.seconds());
}

// Whether memory suffices is asked before each bake: where the most that it can take does, nothing is launched for it.
TEST(BakeCost, TakesNoMoreMemoryThanTheMostThatIsKnownBeforehand) {
    for (const Method& method : methodCatalogue()) {
        Scene scene = sceneFor(method);
        scene.bake.method = method.name;
        const std::int64_t most = mostMemory(scene, method, sceneFrame(scene)), memory = costOf(scene).memory_bytes;
        EXPECT_GE(most, memory) << method.name;
        EXPECT_LT(most, memory + 200'000'000) << method.name;
    }
}

double processorSeconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor's seconds of a bake, the lesser of two, over those that its estimate promises for one thread.
double takenOverPromised(const Scene& scene) {
    Record monitor;
    BakeChoices choices;
    choices.measure = Measure::Nothing;
    const Method& method = chooseMethod(scene.bake.method, scene);
    const BakeCost cost = bakeCost(scene, method, sceneFrame(scene), nullptr, choices);
    double promised = 0;  // all but the file
    for (const Stage& stage : cost.stages)
        if (stage.name != "scene" && stage.name != "write")
            promised += stage.seconds * (stage.name == "needed" ? 1 : threadCount());
    double least = 1e9;
    for (int i = 0; i < 2; ++i) {
        const double start = processorSeconds();
        bakeScene(scene, monitor, choices);
        least = std::min(least, processorSeconds() - start);
    }
    return least / promised;
}

// Whatever the machine, and beside other work: estimates are of the processor's time. They are within a factor of two
// on the examples (docs/accuracy.md); small bakes spend more beside their light.
TEST(BakeCost, BakesTakeAboutAsLongAsTheyPromise) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer makes some work dearer than other work";
#endif
    constexpr double kWithin = 3;
    const std::string box = "[[object]]\nname = \"box\"\nbox = { min = [-0.2, -0.2, -0.6], max = [0.2, 0.2, -0.3] }\n";
    const std::string ball =
        "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nposition = [0, 0, -0.25]\nradius = 0.15\nior_below = 1.5\n";
    const std::string slanting = "[[light]]\ntype = \"sun\"\ndirection = [0.8, 0.1, -0.4]\nirradiance = 500.0\n";
    // Settings that take most of the time are part of what is promised.
    Scene both = poolScene({}, 1.0 / 96), four = poolScene({}, 1.0 / 96), strongest = test::lensScene(1.0 / 48);
    both.surfaces.front().event = SurfaceEvent::Both, four.bake.quadrature = 4;
    strongest.bake.method_options["wavefront"] = {{"arrivals", {std::string("strongest"), "test"}}};
    for (const auto& [name, scene] :
         {std::pair{"pool", poolScene({}, 1.0 / 96)}, std::pair{"box", poolScene(box, 1.0 / 96)},
          std::pair{"ball", poolScene(ball, 1.0 / 64)}, std::pair{"slanting", poolScene(slanting, 1.0 / 96)},
          std::pair{"lens", test::lensScene(1.0 / 64)}, std::pair{"both", both}, std::pair{"four points", four},
          std::pair{"strongest", strongest}}) {
        const double ratio = takenOverPromised(scene);
        EXPECT_GT(ratio, 1 / kWithin) << name;
        EXPECT_LT(ratio, kWithin) << name;
    }
}

TEST(MachineSlowness, IsMeasuredOnce) {
    const double slowness = machineSlowness();
    EXPECT_GT(slowness, 0.02);
    EXPECT_LT(slowness, 50);
    EXPECT_EQ(machineSlowness(), slowness);
}

}  // namespace
}  // namespace photic
