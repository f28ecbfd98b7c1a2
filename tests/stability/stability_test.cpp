// SPDX-License-Identifier: Apache-2.0
// Some random scenes with fixed seeds, and proof that the checkers notice what they are there for.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <optional>

#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"
#include "tests/conformance/bake_scene.h"
#include "tests/stability/laws.h"
#include "tests/stability/random_scene.h"
#include "tests/stability/trial.h"

namespace photic::stability {
namespace {

constexpr std::uint64_t kFirstSeed = 1;
constexpr int kScenes = 24;

TEST(Stability, RandomScenesHoldEveryLaw) {
    int held = 0;
    std::uint64_t seed = kFirstSeed;
    const auto next = [&]() -> std::optional<SceneModel> {
        if (seed == kFirstSeed + kScenes) return std::nullopt;
        return randomScene(seed++);
    };
    tryScenes(threadCount(), 60, next, [&](const SceneModel& scene, const Outcome& outcome) {
        held += outcome.kind == Outcome::Kind::Held;
        for (const Violation& v : outcome.violations)
            ADD_FAILURE() << "seed " << scene.seed << ": " << v.law << ": " << v.what;
    });
    EXPECT_GT(held, kScenes / 2) << "most scenes were refused";
}

TEST(Stability, SeedsGiveTheSameSceneAndDifferentOnes) {
    const std::string folder = ::testing::TempDir();
    EXPECT_EQ(randomScene(7).toml(folder), randomScene(7).toml(folder));
    EXPECT_NE(randomScene(7).toml(folder), randomScene(8).toml(folder));
}

LightField fieldOf(float irradiance, float down) {
    GridFrame frame;
    frame.max = glm::ivec3(7);
    LightField field(std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), {1, true});
    const std::vector<float> values{irradiance, 0, 0, -down};
    field.setConstant(0, values);
    return field;
}

TEST(Stability, BrokenFieldsAreNoticed) {
    EXPECT_FALSE(brokenByField(fieldOf(1, 0.9f)));
    EXPECT_TRUE(brokenByField(fieldOf(1, 1.1f))) << "direction longer than 1";
    EXPECT_TRUE(brokenByField(fieldOf(-1, 0))) << "negative";
    EXPECT_TRUE(brokenByField(fieldOf(std::numeric_limits<float>::quiet_NaN(), 0))) << "not a number";
    EXPECT_NEAR(blockDifference(fieldOf(1.1f, 1), fieldOf(1, 1), 4), 0.1, 1e-6);
    EXPECT_FALSE(brokenByBand(fieldOf(1, 1), fieldOf(1, 1)));
    EXPECT_TRUE(brokenByBand(fieldOf(1.001f, 1), fieldOf(1, 1)));
    EXPECT_TRUE(brokenByBand(fieldOf(1.001f, 1), fieldOf(1, 1), 2)) << "in the middle of a leaf";
    EXPECT_FALSE(brokenByBand(fieldOf(1.001f, 1), fieldOf(1, 1), 4)) << "none is so far from the border";
    EXPECT_TRUE(sameBits(fieldOf(1, 1), fieldOf(1, 1)));
    EXPECT_FALSE(sameBits(fieldOf(1, 1), fieldOf(std::nextafter(1.0f, 2.0f), 1)));
    EXPECT_TRUE(sameBits(fieldOf(1, 1), fieldOf(2, 2), 2));
    EXPECT_FALSE(sameBits(fieldOf(1, 1), fieldOf(std::nextafter(2.0f, 3.0f), 2), 2));
}

TEST(Stability, ScenesShrinkToWhatMatters) {
    SceneModel scene;
    for (std::uint64_t seed = 1;
         scene.things.size() < 3 || scene.water != SceneModel::Water::Waves || !scene.glasses.empty(); ++seed)
        scene = randomScene(seed);
    const double center = scene.things[1].center.x;
    const auto fails = [&](const SceneModel& s) {
        return s.things.size() == 1 && s.things[0].center.x == center ? true : s.things.size() > 1;
    };
    const SceneModel small = shrink(scene, fails, 1000);
    ASSERT_EQ(small.things.size(), 1u);
    EXPECT_EQ(small.things[0].center.x, center);
    EXPECT_EQ(small.water, SceneModel::Water::Flat);
    EXPECT_EQ(small.scale, 1);
    EXPECT_EQ(small.lamps.size(), 1u);
    EXPECT_EQ(small.quadrature, 1);
}

}  // namespace
}  // namespace photic::stability
