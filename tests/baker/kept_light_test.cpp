// SPDX-License-Identifier: Apache-2.0
// Frames that take light from the one before them, against the same frames baked alone: every bit.
#include "bake/methods/kept_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/baker/bake_cost.h"
#include "bake/baker/bake_scene.h"
#include "bake/scene/spline_field.h"
#include "tests/baker/pool_scene.h"

namespace photic {
namespace {

using test::poolScene;
using test::Record;

/// The water as a map of 160 x 160 samples: a swell all over, and a ring of waves in one corner that goes on from frame
/// to frame and fades.
std::shared_ptr<const HeightField> water(int frame) {
    constexpr int kSamples = 160;
    SplineFieldShape shape;
    shape.size = glm::dvec2(2);
    SampleGrid heights{kSamples, kSamples, std::vector<double>(kSamples * kSamples)};
    for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i) {
            const double x = 2 * (i + 0.5) / kSamples - 1, y = 2 * (j + 0.5) / kSamples - 1;
            const double r = std::hypot(x + 0.35, y + 0.35), front = 0.02 * frame;
            double z = 0.008 * std::sin(2 * std::numbers::pi * (2 * x + y)) + 0.004 * std::sin(9 * y + 1);
            if (r < 0.15)
                z += 0.006 * std::exp(-0.2 * frame - std::pow((r - front) / 0.03, 2)) * std::cos(60 * (r - front));
            heights.at(i, j) = z;
        }
    return makeSplineField(shape, heights);
}

Scene frameOf(const std::string& more, int frame) {
    Scene scene = poolScene(more, 1.0 / 128);
    scene.surfaces.front().height_field = water(frame);
    scene.bake.method = "beams";
    return scene;
}

bool same(const LightField& a, const LightField& b) {
    if (a.leafCount() != b.leafCount() || a.channels().count() != b.channels().count()) return false;
    for (int slot = 0; slot < a.leafCount(); ++slot) {
        if (a.state(slot) != b.state(slot)) return false;
        const std::size_t values = static_cast<std::size_t>(a.channels().count());
        if (a.state(slot) == LeafState::Constant &&
            std::memcmp(a.constant(slot).data(), b.constant(slot).data(), values * sizeof(float)) != 0)
            return false;
        if (a.state(slot) == LeafState::Dense &&
            std::memcmp(a.dense(slot), b.dense(slot), values * LightField::kLeafVoxels * sizeof(float)) != 0)
            return false;
    }
    return true;
}

/// Of the tiles that were looked for, those that were there.
double shareKept(const BakeReport& report) {
    for (const std::string& line : report.skipped) {
        int found = 0, all = 0;
        if (std::sscanf(line.c_str(), "%d of %d tiles of light", &found, &all) == 2)
            return static_cast<double>(found) / all;
    }
    return 0;
}

struct Case {
    const char* name;
    std::string more;
    double least_kept;  ///< of a later frame's tiles
};

class KeptLightOf : public testing::TestWithParam<Case> {};

TEST_P(KeptLightOf, FramesIsThatOfFramesAlone) {
    const Case& of = GetParam();
    KeptLight kept;
    for (int frame = 1; frame <= 4; ++frame) {
        Record monitor;
        BakeChoices choices;
        choices.kept_light = &kept;
        const BakedScene together = bakeScene(frameOf(of.more, frame), monitor, choices),
                         alone = bakeScene(frameOf(of.more, frame), monitor);
        EXPECT_TRUE(same(together.volume.field, alone.volume.field)) << "frame " << frame;
        ASSERT_EQ(together.volume.second.has_value(), alone.volume.second.has_value());
        if (alone.volume.second) {
            EXPECT_TRUE(same(*together.volume.second, *alone.volume.second)) << "frame " << frame;
        }
        for (const auto& [name, grid] : alone.volume.scalars)
            EXPECT_TRUE(same(together.volume.scalars.at(name), grid)) << name << ", frame " << frame;
        EXPECT_EQ(together.volume.metadata, alone.volume.metadata) << "frame " << frame;
        EXPECT_EQ(shareKept(alone.report), 0);
        const double share = shareKept(together.report);
        EXPECT_GE(share, frame > 1 ? of.least_kept : 0.0) << "frame " << frame;
    }
}

const char* const kBall = R"(
[[object]]
name = "ball"
role = "blocker"
sphere = { center = [0.1, 0.1, -0.25], radius = 0.1 }
)";
const char* const kGlass = R"(
[[medium]]
name = "glass"
ior = 1.5
[[surface]]
name = "lens"
kind = "sphere"
position = [0.25, 0.25, -0.25]
radius = 0.1
inside = "glass"
event = "both"
)";

INSTANTIATE_TEST_SUITE_P(
    Baker, KeptLightOf,
    testing::Values(Case{"Waves", "", 0.4}, Case{"Band", "[bake]\nwhere = \"receivers\"\n", 0.4},
                    Case{"FourPoints", "[bake]\nquadrature = 4\nprefilter = true\n", 0.4}, Case{"Shadow", kBall, 0.4},
                    Case{"Glass", kGlass, 0.2},
                    Case{"Medium",
                         "[medium]\nabsorption = [0.5, 0.1, 0.05]\n[bake]\ngrids = [\"irradiance\", "
                         "\"direction\", \"caustic\"]\n",
                         0.3},
                    Case{"TwoSuns",
                         "[[light]]\ntype = \"sun\"\ndirection = [-0.5, 0.1, -0.8]\nirradiance = [300, 200, "
                         "100]\nangular_diameter = 0.53\n[bake]\nlobes = 2\n",
                         0.3},
                    Case{"SampledDisc", std::string(kBall) + "[bake.beams]\ndisc = \"sample\"\ndisc_samples = 4\n",
                         0.2}),
    [](const auto& of) { return of.param.name; });

TEST(KeptLight, ServesNoOtherSun) {
    KeptLight kept;
    BakeChoices choices;
    choices.kept_light = &kept;
    Record monitor;
    bakeScene(frameOf("", 1), monitor, choices);
    EXPECT_GT(kept.bytes(), 0);
    Scene turned = frameOf("", 1);
    turned.lights.front().direction = glm::normalize(glm::dvec3(0.21, 0.1, -0.9));
    const BakedScene together = bakeScene(turned, monitor, choices);
    EXPECT_EQ(shareKept(together.report), 0);
    EXPECT_TRUE(same(together.volume.field, bakeScene(turned, monitor).volume.field));
    // Of what changes all over nothing is kept.
    EXPECT_EQ(kept.bytes(), 0);
}

TEST(KeptLight, ServesNoOtherVoxels) {
    KeptLight kept;
    BakeChoices choices;
    choices.kept_light = &kept;
    Record monitor;
    bakeScene(frameOf("", 1), monitor, choices);
    const std::string band = "[bake]\nwhere = \"receivers\"\n";
    const BakedScene together = bakeScene(frameOf(band, 1), monitor, choices);
    EXPECT_EQ(shareKept(together.report), 0);
    EXPECT_TRUE(same(together.volume.field, bakeScene(frameOf(band, 1), monitor).volume.field));
}

// Memory that a bake would want for itself is not taken.
TEST(KeptLight, KeepsToTheMemoryThatIsLeft) {
    KeptLight kept;
    const Scene scene = frameOf("", 1);
    Record monitor;
    BakeChoices choices;
    choices.kept_light = &kept;
    const BakedScene whole = bakeScene(scene, monitor, choices);
    const std::int64_t all = kept.bytes();
    ASSERT_GT(all, whole.report.field_bytes / 2);
    EXPECT_LT(all, 1.2 * static_cast<double>(whole.report.field_bytes));
    kept.clear();
    EXPECT_EQ(kept.bytes(), 0);
    choices.max_memory_bytes =
        bakeCost(scene, chooseMethod("beams", scene), whole.volume.field.frame(), &whole.volume.field.needed(), choices)
            .memory_bytes +
        all / 3;
    for (int frame = 1; frame <= 2; ++frame) {
        const Scene next = frameOf("", frame);
        const BakedScene baked = bakeScene(next, monitor, choices);
        EXPECT_LE(kept.bytes(), all / 3);
        EXPECT_TRUE(same(baked.volume.field, bakeScene(next, monitor).volume.field));
        EXPECT_GE(shareKept(baked.report), frame > 1 ? 0.05 : 0.0);
    }
}

}  // namespace
}  // namespace photic
