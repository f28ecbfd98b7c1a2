// SPDX-License-Identifier: Apache-2.0
// What a bake of media whose index varies stands, says and refuses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <vector>

#include "bake/methods/graded_space.h"
#include "bake/methods/wavefront.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

TEST(Wavefront, StandsHardIndices) {
    const std::string box = ", min = [-0.2, -0.2, -0.2], max = [0.21, 0.2, 0.2] }";
    for (const std::string& index :
         {"{ kind = \"linear\", n0 = 2.5, slope = [0, 0, 0]" + box,
          "{ kind = \"linear\", n0 = 0.5, slope = [0, 0, 0]" + box,
          "{ kind = \"linear\", n0 = 2, slope = [6, 3, -4]" + box,
          std::string("{ kind = \"luneburg\", radius = 0.007 }"), std::string("{ kind = \"luneburg\", radius = 0.05 }"),
          std::string("{ kind = \"fish_eye\", n0 = 3, scale = 0.15, radius = 0.25 }")})
        for (const char* way : {"[0, 0, -1]", "[1, 0.2, 0.1]", "[0, 1, 1]"}) {
            const Bake b =
                bake(sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24",
                             "type = \"sun\"\nangular_diameter = 0\nirradiance = 1\ndirection = " + std::string(way),
                             medium(index, "absorption = 0.5")));
            EXPECT_LT(b.report().power.imbalance(), 1e-9) << index << way;
            EXPECT_LT(b.report().path.imbalance(), 1e-3) << index << way;
            EXPECT_TRUE(std::isfinite(b.field().sum(0))) << index << way;
            EXPECT_GE(b.field().sum(0), 0) << index << way;
        }
}

TEST(Wavefront, StandsThinShells) {
    // A ball of glass around a ball of air, of which the glass is thinner than a voxel, or as thick as a few.
    constexpr double kVoxel = 0.6 / 24;
    for (const double thickness : {0.3, 1.0, 3.0}) {
        const auto ball = [](const char* name, double n, double radius) {
            return fmt::format(
                "[[medium]]\nname = \"{}\"\nindex = {{ kind = \"fish_eye\", n0 = {}, scale = 1000, radius = {} }}\n",
                name, n, radius);
        };
        const Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24", kDown,
                                    ball("hollow", 1, 0.2 - thickness * kVoxel) + ball("glass", 1.5, 0.2));
        const Bake b = bake(scene), photons = bakeWith("photons", scene, with("count", std::int64_t{4000}));
        EXPECT_LT(photons.report().power.imbalance(), 1e-9) << thickness;
        EXPECT_NEAR(photons.report().power.escaped, b.report().power.escaped, 0.25 * b.report().power.escaped)
            << thickness;
        EXPECT_LT(b.report().power.imbalance(), 1e-9) << thickness;
        EXPECT_LT(b.report().path.imbalance(), 1e-3) << thickness;
        EXPECT_GT(b.field().sum(0), 0) << thickness;
        EXPECT_TRUE(std::isfinite(b.field().sum(0))) << thickness;
        EXPECT_LT(b.report().power.dropped, 0.15 * b.report().power.escaped) << thickness;
    }
}

TEST(Wavefront, ThreadsChangeNoBit) {
    const Scene scene = sceneOf("min = [-0.4, -0.4, -0.5]\nmax = [0.4, 0.4, 0.4]\nresolution = 40", kDown,
                                medium("{ kind = \"luneburg\", radius = 0.3 }", "absorption = 0.3"));
    setThreadCount(1);
    const Bake one = bake(scene);
    setThreadCount(3);
    const Bake three = bake(scene);
    setThreadCount(0);
    EXPECT_EQ(one.report().path.expected, three.report().path.expected);
    EXPECT_EQ(one.report().power.escaped, three.report().power.escaped);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
}

/// Keeps what it is told.
struct Listener : Monitor {
    std::vector<std::pair<std::string, double>> stages;
    std::vector<std::string> warnings;
    int calls_left = -1;  ///< until it is cancelled; less than 0: never
    mutable std::mutex mutex;
    void progress(std::string_view stage, double fraction) override {
        const std::lock_guard lock(mutex);
        stages.emplace_back(stage, fraction);
        if (calls_left > 0) --calls_left;
    }
    void warn(const std::string& message) override { warnings.push_back(message); }
    bool cancelled() const override {
        const std::lock_guard lock(mutex);
        return calls_left == 0;
    }
};

TEST(Wavefront, TellsHowFarItIs) {
    // Three channels, and light that turns.
    const std::string ball = "{ kind = \"luneburg\", radius = 0.3 }";
    const Scene scene = sceneOf("min = [-0.4, -0.4, -0.4]\nmax = [0.4, 0.4, 0.4]\nresolution = 32", kDown,
                                medium("[" + ball + ", " + ball + ", " + ball + "]"));
    const Method& method = chooseMethod("auto", scene);
    auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    Listener listener;
    (void)method.bake(scene, needed, {}, listener);
    double last = 0;
    int index_calls = 0;
    for (const auto& [stage, fraction] : listener.stages) {
        if (stage == "index") {
            ++index_calls;
            EXPECT_EQ(last, 0);
            continue;
        }
        ASSERT_EQ(stage, "fronts");
        EXPECT_GE(fraction, last - 1e-12);
        last = fraction;
    }
    EXPECT_EQ(index_calls, 2);
    EXPECT_GT(last, 0.9);
    EXPECT_LE(last, 1);
    const MethodCost cost = method.cost({scene, sceneFrame(scene), 32.0 * 32 * 32, {}});
    ASSERT_EQ(cost.stages.size(), 2u);
    EXPECT_EQ(cost.stages[0].name + cost.stages[1].name, "indexfronts");
    EXPECT_GT(cost.stages[1].seconds, 0);
    // A stop is heard in each stage.
    for (const int calls : {1, 6}) {
        Listener stopping;
        stopping.calls_left = calls;
        EXPECT_THROW((void)method.bake(scene, needed, {}, stopping), Error) << calls;
    }
}

TEST(Wavefront, WarnsOfIndicesThatJump) {
    const auto warnings = [](double n) {
        const Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 16", kDown,
                                    medium(fmt::format("{{ kind = \"linear\", n0 = {}, slope = [0, 0, 0], min = [-0.2, "
                                                       "-0.2, -0.2], max = [0.2, 0.2, 0.2] }}",
                                                       n)));
        Listener listener;
        auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
        const BakeResult result = findMethod("wavefront")->bake(scene, needed, {}, listener);
        const std::vector<std::string>& skipped = result.report.skipped;
        EXPECT_EQ(std::count_if(skipped.begin(), skipped.end(),
                                [](const std::string& what) { return what.starts_with("reflection at faces"); }),
                  1);
        std::string all;
        for (const std::string& warning : listener.warnings) all += warning + "\n";
        return all;
    };
    EXPECT_EQ(warnings(1.3).find("n^2 changes"), std::string::npos);
    EXPECT_NE(warnings(2.5).find("n^2 changes by"), std::string::npos);
}

TEST(Wavefront, RefusesByNameWhatItCannotBake) {
    const Monitor monitor;
    const auto refusal = [](const std::string& rest) {
        const Scene scene = sceneOf("min = [-1, -1, -1]\nmax = [1, 1, 1]\nresolution = 8", kDown, rest);
        try {
            chooseMethod("wavefront", scene);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const std::string lens = medium("{ kind = \"luneburg\", radius = 0.5 }");
    EXPECT_EQ(refusal(lens), "");
    EXPECT_EQ(refusal(lens + "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1] }\n"), "");
    EXPECT_EQ(refusal(lens + "[[object]]\nname = \"floor\"\nrole = \"movable\"\nplane = { point = [0, 0, -1] }\n"), "");
    const std::string ball =
        "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.2\ninside = \"glass\"\n[[medium]]\nname = "
        "\"glass\"\nior = 1.5\n";
    EXPECT_EQ(refusal(lens + ball), "");
    EXPECT_NE(refusal(ball).find("index"), std::string::npos);
    // And the other way round: methods that follow straight rays name it.
    const Scene scene = sceneOf("min = [-1, -1, -1]\nmax = [1, 1, 1]\nresolution = 8", kDown, lens);
    for (const char* method : {"beams", "eikonal", "wave"}) {
        try {
            chooseMethod(method, scene);
            ADD_FAILURE() << method;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("'lens'"), std::string::npos) << method << ": " << error.what();
        }
    }
    EXPECT_EQ(chooseMethod("auto", scene).name, "wavefront");
}

TEST(Wavefront, SaysWhatLiesSoFarAwayThatTheSpaceBetweenIsNextToAllThereIs) {
    const auto refusal = [](const std::string& center) {
        const Scene scene = sceneOf(
            "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nvoxel_size = 0.05", kDown,
            medium("{ kind = \"luneburg\", radius = 0.4 }") +
                "[[medium]]\nname = \"far\"\nindex = { kind = \"luneburg\", center = " + center + ", radius = 0.4 }\n");
        try {
            const GradedSpace space(scene, sceneFrame(scene), {});
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            return std::string(error.what());
        }
        return std::string();
    };
    // 840 x 840 x 20 voxels; and 840 x 840 x 840, of which all but a thousandth of a per cent is air.
    EXPECT_EQ(refusal("[40, 40, 0]"), "");
    const std::string far = refusal("[40, 40, 40]");
    for (const char* word : {"'far' lies 67.", "m beside the domain", "voxel_size of 0.06", "leave it out"})
        EXPECT_NE(far.find(word), std::string::npos) << word << ": " << far;
}

}  // namespace
}  // namespace photic
