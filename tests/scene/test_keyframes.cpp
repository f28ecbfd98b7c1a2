// SPDX-License-Identifier: Apache-2.0
// Lights, surfaces and objects that move: where they are at a frame, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <variant>

#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneText;
class Keyframes : public test::SceneTest {};

SceneText withLight(const std::string& keys) {
    SceneText text;
    text.light = "[[light]]\n" + keys;
    return text;
}

constexpr const char* kTurningSun =
    "type = \"sun\"\nkeyframes = [{ frame = 1, direction = [0, 0, -2] }, { frame = 11, direction = [1, 0, -1] }]\n";

TEST_F(Keyframes, ADirectionTurnsAtAnEvenPace) {
    for (const int frame : {-5, 1, 4, 11, 40}) {
        const double part = std::clamp((frame - 1) / 10.0, 0.0, 1.0), angle = part * std::acos(-1.0) / 4;
        const glm::dvec3 expected(std::sin(angle), 0, -std::cos(angle));
        EXPECT_LT(glm::length(load(withLight(kTurningSun), frame).lights[0].direction - expected), 1e-12) << frame;
    }
}

TEST_F(Keyframes, AFrameThatChangesNothingHasTheHashOfTheOneBefore) {
    const auto hash = [&](int frame) { return load(withLight(kTurningSun), frame).hash; };
    EXPECT_NE(hash(4), hash(5));
    EXPECT_EQ(hash(11), hash(12));
    EXPECT_EQ(hash(-3), hash(1));
}

TEST_F(Keyframes, ALampKeepsTheReferenceOfItsFirstKeyframe) {
    const SceneText text = withLight(
        "type = \"point\"\npower = 100\nkeyframes = [{ frame = 0, position = [0, 0, 2] }, { frame = 10, position = "
        "[0, 4, 4] }]\n");
    const Scene first = load(text, 0), fifth = load(text, 5);
    EXPECT_LT(glm::length(*fifth.lights[0].position - glm::dvec3(0, 2, 3)), 1e-12);
    EXPECT_NEAR(first.referenceIrradiance(), 100 / (4 * std::acos(-1.0) * 4), 1e-9);
    EXPECT_EQ(fifth.referenceIrradiance(), first.referenceIrradiance());
}

// There is no irradiance where a lamp is: it counts as standing half way out of the body that it stands in.
TEST_F(Keyframes, ALampInTheMiddleOfAMovingBallCountsAsHalfWayOut) {
    SceneText text = withLight("type = \"point\"\npower = 100\nposition = [0, 0, -0.5]\n");
    text.rest =
        "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.1\nior_below = 1.5\nkeyframes = [{ frame = 0, "
        "position = [0, 0, -0.5] }, { frame = 4, position = [0, 0.8, -0.5] }]\n";
    text.surface = "";
    for (const int frame : {0, 2})
        EXPECT_NEAR(load(text, frame).referenceIrradiance() * 4 * std::acos(-1.0) * 0.05 * 0.05 / 100, 1, 0.01)
            << frame;
}

TEST_F(Keyframes, ShapesMoveAndTurn) {
    SceneText text;
    text.rest =
        "[[object]]\nname = \"box\"\nbox = { min = [0, 0, 0], max = [1, 0.2, 0.1] }\nkeyframes = [\n"
        "  { frame = 0, position = [0, 0, -1], rotation = [0, 0, 0] },\n"
        "  { frame = 2, rotation = [0, 0, 90] },\n  { frame = 4, position = [0.4, 0, -1] }]\n"
        "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.1\nior_below = 1.5\nkeyframes = [{ frame = 0, "
        "position = "
        "[0, 0, -0.5] }, { frame = 4, position = [0, 0.8, -0.5] }]\n";
    const Scene scene = load(text, 2);
    EXPECT_LT(glm::length(scene.surfaces[1].sphere->center - glm::dvec3(0, 0.4, -0.5)), 1e-12);
    const auto& mesh = *std::get<1>(scene.objects[0].shape);
    glm::dvec3 low(1e9), high(-1e9);
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    // Turned by 90 degrees, and half of its way along: the position has no keyframe at 2.
    EXPECT_LT(glm::length(low - glm::dvec3(0.2 - 0.2, 0, -1)), 1e-9);
    EXPECT_LT(glm::length(high - glm::dvec3(0.2, 1, -0.9)), 1e-9);
}

TEST_F(Keyframes, WhatCannotBeMeantIsRefused) {
    const auto sun = [&](const std::string& keys, const std::vector<std::string>& words) {
        refused(withLight("type = \"sun\"\n" + keys), "s.toml", words);
    };
    sun("keyframes = 3\n", {"give an array"});
    sun("keyframes = []\n", {"empty"});
    sun("keyframes = [{ frame = 1 }]\n", {"moves nothing"});
    sun("keyframes = [{ direction = [0, 0, -1] }]\n", {"frame"});
    sun("keyframes = [{ frame = 1, irradiance = 3 }]\n", {"irradiance"});
    sun("keyframes = [{ frame = 1, direction = [0, 0, 0] }]\n", {"no length"});
    sun("direction = [0, 0, -1]\nkeyframes = [{ frame = 1, direction = [0, 0, -1] }]\n", {"keep one of the two"});
    sun("keyframes = [{ frame = 1, direction = [0, 0, -1] }, { frame = 1, direction = [0, 1, -1] }]\n",
        {"two keyframes", "frame 1"});
    sun("keyframes = [{ frame = 5, direction = [0, 0, -1] }, { frame = 9, direction = [0, 0, 1] }]\n", {"opposite"});
    sun("keyframes = [{ frame = 1, position = [0, 0, 1], direction = [0, 0, -1] }]\n", {"'position'", "a sun has"});
}

}  // namespace
}  // namespace photic
