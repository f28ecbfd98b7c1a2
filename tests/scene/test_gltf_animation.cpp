// SPDX-License-Identifier: Apache-2.0
// What a glTF's animations move, against what its tracks say by the standard's own formulas.
#include "bake/scene/gltf_animation.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/scene/gltf_room.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using nlohmann::json;
using test::GltfFileTest;
using test::GltfRoom;

const double kHalf = std::sqrt(0.5);

/// A room in which a test lets things move.
struct MovingRoom : GltfRoom {
    /// A channel of a node, with keys at times in seconds.
    void move(std::size_t node, const std::string& path, const std::vector<float>& times,
              const std::vector<float>& values, const std::string& between = "LINEAR",
              const std::string& name = "play") {
        json* animation = nullptr;
        for (json& known : root["animations"])
            if (known["name"] == name) animation = &known;
        if (!animation) {
            root["animations"].push_back({{"name", name}, {"channels", json::array()}, {"samplers", json::array()}});
            animation = &root["animations"].back();
        }
        const int input = add<float>(times, 5126, "SCALAR"),
                  output = add<float>(values, 5126, path == "rotation" ? "VEC4" : "VEC3");
        (*animation)["channels"].push_back(
            {{"sampler", (*animation)["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
        (*animation)["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", between}});
    }
    json& channel() { return root["animations"][0]["channels"][0]; }
    json& sampler() { return root["animations"][0]["samplers"][0]; }
};

class GltfAnimationTest : public GltfFileTest {
protected:
    Scene at(const MovingRoom& room, int frame) { return open(room, frame); }
    glm::dvec3 blockAt(const MovingRoom& room, int frame) { return at(room, frame).surfaces.at(0).center; }
};

void expectAt(const glm::dvec3& place, const glm::dvec3& wanted) {
    EXPECT_NEAR(glm::length(place - wanted), 0, 2e-6) << place.x << " " << place.y << " " << place.z << " in place of "
                                                      << wanted.x << " " << wanted.y << " " << wanted.z;
}

// The block rests at (0.1, 1, 0.2) of the file, which is (0.1, -0.2, 1) here. 24 frames are a second.
TEST_F(GltfAnimationTest, ABlockGoesStraightFromKeyToKey) {
    MovingRoom room;
    room.move(1, "translation", {0.5f, 1.5f}, {0.1f, 1, 0.2f, 0.5f, 2, 0.2f});
    expectAt(blockAt(room, 0), {0.1, -0.2, 1});  // before its first key
    expectAt(blockAt(room, 12), {0.1, -0.2, 1});
    expectAt(blockAt(room, 18), {0.2, -0.2, 1.25});
    expectAt(blockAt(room, 36), {0.5, -0.2, 2});
    expectAt(blockAt(room, 99), {0.5, -0.2, 2});
    noted("it moves from frame 12 to 36, 24 a second");
    EXPECT_EQ(notes_.warnings, "");
    // The box that is baked holds it in every frame, and is the same in all.
    EXPECT_GT(at(room, 0).domain.max.z, 2.25);
    EXPECT_EQ(at(room, 0).domain.max, at(room, 36).domain.max);
    // Frames in which it stands still are one scene; others are not.
    EXPECT_EQ(at(room, 0).hash, at(room, 12).hash);
    EXPECT_NE(at(room, 12).hash, at(room, 13).hash);
}

TEST_F(GltfAnimationTest, StepsAndSplinesAreTheStandards) {
    MovingRoom steps;
    steps.move(1, "translation", {0, 1}, {0, 1, 0, 1, 1, 0}, "STEP");
    expectAt(blockAt(steps, 23), {0, 0, 1});
    expectAt(blockAt(steps, 24), {1, 0, 1});
    // p(t) = (2t3 - 3t2 + 1) p0 + T (t3 - 2t2 + t) b0 + (3t2 - 2t3) p1 + T (t3 - t2) a1, here T = 2 s and t = 1/4.
    MovingRoom spline;
    spline.move(1, "translation", {0, 2},
                {9, 9, 9, 0, 1, 0, 0.5f, 0, 0,  // in, value, out
                 0, 0.25f, 0, 1, 1, 0, 9, 9, 9},
                "CUBICSPLINE");
    const double t = 0.25, t2 = t * t, t3 = t2 * t;
    expectAt(blockAt(spline, 12), {2 * (t3 - 2 * t2 + t) * 0.5 + (3 * t2 - 2 * t3), 0, 1 + 2 * (t3 - t2) * 0.25});
    expectAt(blockAt(spline, 0), {0, 0, 1});
    expectAt(blockAt(spline, 48), {1, 0, 1});
}

TEST_F(GltfAnimationTest, ABlockTurnsAboutItsNodeTheShortWay) {
    MovingRoom room;
    // A quarter turn about the file's Y, given by the quaternion of the long way.
    room.move(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, float(-kHalf), 0, float(-kHalf)});
    room.block()["scale"] = {0.25, 0.5, 0.25};
    const Scene half = at(room, 12);
    // It turns about its own middle, and by 45 degrees about Z: its square of 0.5 m stands on its corner.
    expectAt(half.surfaces[0].center, {0.1, -0.2, 1});
    glm::dvec3 low(1e9), high(-1e9);
    for (const glm::dvec3& p : half.surfaces[0].mesh->positions) low = glm::min(low, p), high = glm::max(high, p);
    EXPECT_NEAR(high.x - low.x, 0.5 * std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(high.z - low.z, 1.0, 1e-6);
    const Scene quarter = at(room, 24);
    for (const glm::dvec3& p : quarter.surfaces[0].mesh->positions) EXPECT_LT(std::fabs(p.x - 0.1), 0.2500001);
}

TEST_F(GltfAnimationTest, WhatHangsFromAMovingNodeMovesWithIt) {
    MovingRoom room;
    // An arm that turns a quarter about the file's Y in a second; the block hangs 1 m out along its X, and goes up.
    room.root["nodes"].push_back({{"name", "arm"}, {"children", {1}}, {"scale", {2, 2, 2}}});
    room.root["scenes"][0]["nodes"] = {0, 2};
    room.block()["translation"] = {1, 0, 0};
    room.move(2, "rotation", {0, 1}, {0, 0, 0, 1, 0, float(kHalf), 0, float(kHalf)});
    room.move(1, "translation", {0, 1}, {1, 0, 0, 1, 1, 0});
    expectAt(blockAt(room, 0), {2, 0, 0});
    // Half-way: 45 degrees; the file's Y turns X towards -Z, which is +Y here.
    expectAt(blockAt(room, 12), {2 * kHalf, 2 * kHalf, 1});
    expectAt(blockAt(room, 24), {0, 2, 2});
}

TEST_F(GltfAnimationTest, LampsMoveAndAim) {
    MovingRoom room;
    room.light({{"type", "spot"}, {"intensity", 683}, {"spot", {{"outerConeAngle", 0.5}}}},
               {{"name", "lamp"}, {"translation", {0, 3, 0}}, {"rotation", {-kHalf, 0, 0, kHalf}}});
    room.light({{"type", "directional"}, {"intensity", 683}}, {{"name", "sun"}, {"rotation", {-kHalf, 0, 0, kHalf}}});
    room.move(2, "translation", {0, 1}, {0, 3, 0, 2, 3, 0});
    room.move(3, "rotation", {0, 1},
              {float(-kHalf), 0, 0, float(kHalf), float(-std::sin(std::numbers::pi / 8)), 0, 0,
               float(std::cos(std::numbers::pi / 8))});
    const Scene scene = at(room, 12);
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(notes_.warnings, "");
    const bool lamp_first = scene.lights[0].type == LightType::Spot;
    const Light& lamp = scene.lights[lamp_first ? 0 : 1];
    const Light& sun = scene.lights[lamp_first ? 1 : 0];
    expectAt(*lamp.position, {1, 0, 3});
    expectAt(lamp.direction, {0, 0, -1});
    // From straight down to 45 degrees: 22.5 half-way. The file's -Z is +Y here.
    expectAt(sun.direction, {0, std::sin(std::numbers::pi / 8), -std::cos(std::numbers::pi / 8)});
    // A sequence has one reference: the lamp's at its first keyframe.
    EXPECT_EQ(scene.referenceIrradiance(), at(room, 24).referenceIrradiance());
}

TEST_F(GltfAnimationTest, AGlassThatMovesUnderALampKeepsTheReference) {
    MovingRoom room;
    room.light({{"type", "point"}, {"intensity", 683}}, {{"name", "bulb"}, {"translation", {0, 3, 0}}});
    room.move(1, "translation", {0, 1}, {0, 1, 0, 0, 2, 0});
    room.move(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, float(kHalf), 0, float(kHalf)});
    const double first = at(room, 0).referenceIrradiance();
    EXPECT_NEAR(first, 1.0 / 4, 1e-6);  // 1 W/sr over 2 m
    EXPECT_EQ(at(room, 12).referenceIrradiance(), first);
    EXPECT_EQ(at(room, 24).referenceIrradiance(), first);
}

TEST_F(GltfAnimationTest, AScaleThatStaysIsNoMotionAndOneThatMovesIsRefused) {
    MovingRoom room;
    room.move(1, "scale", {0, 1}, {0.25f, 0.5f, 0.25f, 0.25f, 0.5f, 0.25f});
    room.move(1, "translation", {0, 1}, {0, 1, 0, 1, 1, 0});
    expectAt(blockAt(room, 24), {1, 0, 1});
    MovingRoom grows;
    grows.move(1, "scale", {0, 1}, {0.25f, 0.5f, 0.25f, 0.5f, 0.5f, 0.25f}, "LINEAR", "Grow");
    refusedRoom(grows, {"room.glb", "scales 'block'", "'Grow'", "remove the channel 'scale'"});
    // Turned below an uneven scale it would shear.
    MovingRoom shears;
    shears.root["nodes"].push_back({{"name", "arm"}, {"children", {1}}, {"scale", {2, 1, 1}}});
    shears.root["scenes"][0]["nodes"] = {0, 2};
    shears.move(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, float(kHalf), 0, float(kHalf)});
    refusedRoom(shears, {"moves 'block'", "changes its shape", "apply scales"});
    // What is not shown may do as it likes.
    grows.block()["extras"] = {{"photic_role", "ignored"}};
    grows.root["nodes"][0]["extras"] = {{"photic_role", "mirror"}};
    EXPECT_EQ(at(grows, 0).surfaces.size(), 1u);
}

TEST_F(GltfAnimationTest, WhatIsLeftOutIsSaid) {
    MovingRoom room;
    room.move(1, "translation", {0, 1}, {0, 1, 0, 1, 1, 0}, "LINEAR", "there");
    room.move(1, "translation", {0, 1}, {0, 1, 0, 9, 1, 0}, "LINEAR", "elsewhere");
    room.move(0, "weights", {0, 1}, {0, 0, 0, 0, 0, 0}, "LINEAR", "there");
    room.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}}}}};
    room.root["nodes"].push_back({{"camera", 0}, {"name", "front"}});
    room.root["scenes"][0]["nodes"].push_back(2);
    room.move(2, "translation", {0, 1}, {0, 1, 0, 9, 1, 0});
    expectAt(blockAt(room, 24), {1, 0, 1});
    noted("'there' and 'elsewhere' both move the translation of 'block': the first one is taken");
    noted("1 of its animated channels move morph weights, and are not read");
    noted("the camera 'front' moves, which is not read");
    // Named as a mesh, the file stands still, and says so; a part of it is moved by whoever names it.
    test::Notes notes;
    Monitor& monitor = notes;
    (void)loadMesh(path("room.glb"), {}, monitor, [](std::string_view) {});
    EXPECT_NE(notes.warnings.find("animated channels are not read"), std::string::npos) << notes.warnings;
}

TEST_F(GltfAnimationTest, TheRateOfFramesIsTheScenes) {
    MovingRoom room;
    room.move(1, "translation", {0, 1}, {0, 1, 0, 1, 1, 0});
    room.root["scenes"][0]["extras"] = {{"photic", {{"frame_rate", 10}}}};
    expectAt(blockAt(room, 5), {0.5, 0, 1});
    noted("it moves from frame 0 to 10, 10 a second");
    EXPECT_EQ(loadFrameRate(path("room.glb")), 10);
    room.root["scenes"][0]["extras"] = {{"photic", {{"frame_rate", 0}}}};
    refusedRoom(room, {"photic.frame_rate", "is 0"});
    room.root["scenes"][0]["extras"] = {{"photic", {{"frame_rate", 1e6}}}};
    refusedRoom(room, {"'block'", "frame 1000000", "lower photic.frame_rate"});
}

TEST_F(GltfAnimationTest, DamagedAnimationsAreRefused) {
    MovingRoom good;
    good.move(1, "translation", {0, 1}, {0, 1, 0, 1, 1, 0});
    const auto damaged = [&](const std::function<void(MovingRoom&)>& damage, const std::vector<std::string>& words) {
        MovingRoom room = good;
        damage(room);
        refusedRoom(room, words);
    };
    damaged([](MovingRoom& r) { r.channel()["target"]["path"] = "colour"; }, {"'play'", "moves 'colour'"});
    damaged([](MovingRoom& r) { r.channel()["target"]["node"] = 77; }, {"node 77"});
    damaged([](MovingRoom& r) { r.channel()["sampler"] = 3; }, {"sampler 3"});
    damaged([](MovingRoom& r) { r.channel()["sampler"] = -1; }, {"sampler -1"});
    damaged([](MovingRoom& r) { r.channel().erase("sampler"); }, {"sampler null"});
    damaged([](MovingRoom& r) { r.sampler().erase("input"); }, {"no 'input'"});
    damaged([](MovingRoom& r) { r.sampler()["output"] = 1000; }, {"refers to accessor 1000"});
    damaged([](MovingRoom& r) { r.sampler()["output"] = r.sampler()["input"]; }, {"does not hold 3 numbers"});
    damaged([](MovingRoom& r) { r.sampler()["interpolation"] = "BEZIER"; }, {"'BEZIER'", "CUBICSPLINE"});
    damaged([](MovingRoom& r) { r.sampler()["interpolation"] = "CUBICSPLINE"; }, {"2 times ask for 6 values", "has 2"});
    damaged(
        [](MovingRoom& r) {
            r.sampler()["input"] = r.add<float>({1, 1}, 5126, "SCALAR");
        },
        {"must rise", "key 1 is at 1 s"});
    damaged([](MovingRoom& r) { r.sampler()["input"] = r.add<float>({-1, 1}, 5126, "SCALAR"); }, {"key 0 is at -1 s"});
    damaged([](MovingRoom& r) { r.sampler()["input"] = r.add<float>({0, NAN}, 5126, "SCALAR"); }, {"must rise"});
    damaged(
        [](MovingRoom& r) {
            r.sampler()["output"] = r.add<float>({0, 1, 0, INFINITY, 1, 0}, 5126, "VEC3");
        },
        {"value 1 is not a finite number"});
    damaged(
        [](MovingRoom& r) {
            r.block().erase("translation"), r.block().erase("scale"),
                r.block()["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        },
        {"node 1", "matrix"});
    MovingRoom turns;
    turns.move(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 0});
    refusedRoom(turns, {"rotation 1 has no length"});
    // A channel without a node is an extension's, and is ignored.
    MovingRoom none = good;
    none.channel()["target"].erase("node");
    expectAt(blockAt(none, 24), {0.1, -0.2, 1});
}

}  // namespace
}  // namespace photic
