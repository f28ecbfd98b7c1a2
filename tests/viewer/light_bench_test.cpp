// SPDX-License-Identifier: Apache-2.0
// The bake that follows a light: begun when it rests, ended when it moves on, swapped in, put away. Without GL.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <glm/geometric.hpp>
#include <thread>

#include "bake/report/error.h"
#include "photic/runtime_vdb.h"
#include "runtime/viewer/light_bench.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

using namespace viewer;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// What a renderer is told, without one.
class Listener final : public Renderer {
public:
    runtime::Status setStage(const Stage& stage) override {
        stages.push_back(stage);
        return runtime::Done{};
    }
    runtime::Status setVolume(int, const runtime::Volume& volume) override {
        volumes.push_back(volume);
        return runtime::Done{};
    }
    runtime::Status sendVolume(int, const runtime::Volume& volume) override {
        volumes.push_back(volume);
        parts_left = 3;
        return runtime::Done{};
    }
    runtime::Result<bool> bringVolume() override { return --parts_left <= 0; }
    runtime::Status setLight(const runtime::WaterLight& light) override {
        suns.emplace_back(light.direction[0], light.direction[1], light.direction[2]);
        return runtime::Done{};
    }
    runtime::Status setObjects(const std::vector<runtime::IndexVolume>&) override { return runtime::Done{}; }
    void setEnvironment(const Environment&) override {}
    bool hasObjects() const override { return false; }
    runtime::Status draw(const viewer::Picture&, unsigned, int, int) override { return runtime::Done{}; }
    bool has(Source source) const override {
        return (source != Source::BakedA && source != Source::BakedB) || !volumes.empty();
    }
    std::string device() const override { return "none"; }

    std::vector<Stage> stages;
    std::vector<runtime::Volume> volumes;
    std::vector<glm::vec3> suns;
    int parts_left = 0;
};

/// A scene on the disk, shown by nobody.
class LightBenches : public testing::Test {
protected:
    void SetUp() override {
        PoolText pool;
        pool.voxel_size = 2.0 / 32;
        place_.write("pool.toml", pool.text());
        options_.scene = (place_ / "pool.toml").string();
    }
    void open() {
        show_ = std::make_unique<Show>(options_, listener_);
        bench_ = std::make_unique<LightBench>(options_, *show_, listener_, PHOTIC_PROGRAM);
    }
    /// Frames until the bench rests, or fails.
    void play() {
        const auto end = steady_clock::now() + std::chrono::seconds(60);
        while (bench_->busy() && bench_->rebake().phase() != Rebake::Phase::Failed && steady_clock::now() < end) {
            bench_->update();
            std::this_thread::sleep_for(milliseconds(1));
        }
    }
    void playFor(milliseconds time) {
        for (const auto end = steady_clock::now() + time; steady_clock::now() < end;) {
            bench_->update();
            std::this_thread::sleep_for(milliseconds(1));
        }
    }
    /// Plays until a bake runs. @return its process
    pid_t playUntilBaking() {
        const auto end = steady_clock::now() + std::chrono::seconds(20);
        while (!bench_->rebake().process() && steady_clock::now() < end) playFor(milliseconds(1));
        return bench_->rebake().process() ? bench_->rebake().process()->pid() : -1;
    }
    /// A bake by hand, of the scene with another sun.
    runtime::Volume byHand(const std::string& direction) {
        PoolText pool;
        pool.voxel_size = 2.0 / 32, pool.sun_direction = direction;
        place_.write("hand.toml", pool.text());
        EXPECT_EQ(photic(place_, {"bake", "hand.toml", "-o", "hand.vdb"}).code, 0);
        return runtime::loadVdb((place_ / "hand.vdb").string()).value();
    }
    static bool same(const runtime::Volume& a, const runtime::Volume& b) {
        const runtime::VoxelBox box = a.litVoxels();
        if (a.litVoxelCount() != b.litVoxelCount() || a.litVoxelCount() == 0) return false;
        for (int k = box.min[2]; k <= box.max[2]; ++k)
            for (int j = box.min[1]; j <= box.max[1]; ++j)
                for (int i = box.min[0]; i <= box.max[0]; ++i) {
                    const runtime::Light x = a.sample(a.voxelCentre(i, j, k)), y = b.sample(b.voxelCentre(i, j, k));
                    if (x.irradiance.x != y.irradiance.x || x.flux.x != y.flux.x || x.flux.z != y.flux.z) return false;
                }
        return true;
    }

    Workplace place_;
    Options options_;
    Listener listener_;
    std::unique_ptr<Show> show_;
    std::unique_ptr<LightBench> bench_;
};

TEST_F(LightBenches, BakeWhatAHandWouldOfTheMovedLight) {
    open();
    EXPECT_FALSE(bench_->busy());
    const std::filesystem::path folder = bench_->rebake().folder();
    bench_->moveTo({}, {-0.25, 0.5, -2});
    ASSERT_EQ(listener_.suns.size(), 1U) << "what needs no bake follows at once";
    EXPECT_NEAR(listener_.suns[0].x, -0.25 / std::sqrt(0.0625 + 0.25 + 4), 1e-6);
    play();
    ASSERT_EQ(listener_.volumes.size(), 1U) << bench_->words();
    EXPECT_TRUE(same(listener_.volumes[0], byHand("[-0.25, 0.5, -2]")));
    EXPECT_FALSE(same(listener_.volumes[0], byHand("[0.433, 0.25, -0.866]"))) << "the comparison can fail";
    EXPECT_EQ(show_->picture.right, Source::BakedA);
    EXPECT_NEAR(static_cast<double>(listener_.stages.back().light.direction[1]), 0.5 / std::sqrt(0.0625 + 0.25 + 4),
                1e-6);
    EXPECT_TRUE(std::filesystem::is_empty(folder)) << "scene and volume are gone when they were read";
    bench_.reset();
    EXPECT_FALSE(std::filesystem::exists(folder));
}

TEST_F(LightBenches, BeginAgainWhenTheLightMovesOn) {
    options_.bake_arguments = "--voxel-size 0.004 --threads 1 --measure no";  // many seconds
    open();
    bench_->moveTo({}, {0.1, 0, -1});
    const pid_t first = playUntilBaking();
    ASSERT_GT(first, 0);
    ASSERT_EQ(kill(first, 0), 0);
    const auto begun = steady_clock::now();
    bench_->moveTo({}, {0.2, 0, -1});
    EXPECT_LT(steady_clock::now() - begun, std::chrono::seconds(1)) << "nobody waits for the old one";
    EXPECT_NE(kill(first, 0), 0) << "the first bake has ended";
    EXPECT_EQ(bench_->rebake().process(), nullptr);
    const pid_t second = playUntilBaking();
    ASSERT_GT(second, 0);
    EXPECT_NE(second, first);
    // It says how far it is.
    const auto end = steady_clock::now() + std::chrono::seconds(30);
    while (bench_->done() == 0 && bench_->rebake().process() && steady_clock::now() < end) playFor(milliseconds(5));
    EXPECT_GT(bench_->done(), 0) << bench_->words();
    EXPECT_EQ(bench_->words().rfind("baking: ", 0), 0U) << bench_->words();
    const std::filesystem::path folder = bench_->rebake().folder();
    bench_.reset();
    EXPECT_NE(kill(second, 0), 0) << "it ends with the viewer";
    EXPECT_FALSE(std::filesystem::exists(folder));
    EXPECT_TRUE(listener_.volumes.empty());
}

TEST_F(LightBenches, SayWhatTheBakerSays) {
    open();
    bench_->moveTo({}, {0.1, 0, 1});
    play();
    ASSERT_EQ(bench_->rebake().phase(), Rebake::Phase::Failed);
    EXPECT_EQ(bench_->words().rfind(options_.scene + ":8:1: the light 'light 1' travels upwards", 0), 0U)
        << bench_->words();
    EXPECT_EQ(bench_->rebake().failure().code(), ErrorCode::Input);
    EXPECT_THROW(bench_->finish([] { return false; }), Error);
    // The next place is as good as any.
    bench_->moveTo({}, {0.1, 0, -1});
    play();
    EXPECT_EQ(listener_.volumes.size(), 1U) << bench_->words();
}

TEST_F(LightBenches, SayWhenThereIsNoBaker) {
    options_.bake = true;
    show_ = std::make_unique<Show>(options_, listener_);
    bench_ = std::make_unique<LightBench>(options_, *show_, listener_, (place_ / "nobody").string());
    play();
    EXPECT_NE(bench_->words().find("cannot run photic"), std::string::npos) << bench_->words();
    options_.bake_arguments = "--no-such-option";
    bench_ = std::make_unique<LightBench>(options_, *show_, listener_, PHOTIC_PROGRAM);
    play();
    EXPECT_NE(bench_->words().find("--no-such-option"), std::string::npos) << bench_->words();
    EXPECT_EQ(bench_->rebake().failure().code(), ErrorCode::Usage);
}

TEST_F(LightBenches, FollowTheFileWhenItIsWatched) {
    options_.watch = true;
    open();
    playFor(milliseconds(400));
    EXPECT_FALSE(bench_->busy()) << "nothing has changed";
    PoolText pool;
    pool.voxel_size = 2.0 / 32, pool.sun_direction = "[-0.25, 0.5, -2]";
    const auto edit = [&](const std::string& text) {
        std::this_thread::sleep_for(milliseconds(20));  // another time than the last
        place_.write("pool.toml", text);
        playFor(milliseconds(900));
        play();
    };
    edit(pool.text());
    ASSERT_EQ(listener_.volumes.size(), 1U) << bench_->words();
    EXPECT_TRUE(same(listener_.volumes[0], byHand("[-0.25, 0.5, -2]")));
    EXPECT_NEAR(bench_->lights()[0].direction.x, -0.25 / std::sqrt(0.0625 + 0.25 + 4), 1e-6);
    edit("photic = 1\nnonsense");
    EXPECT_EQ(bench_->rebake().phase(), Rebake::Phase::Failed);
    EXPECT_NE(bench_->words().find("pool.toml:2"), std::string::npos) << bench_->words();
    edit(pool.text());
    EXPECT_EQ(listener_.volumes.size(), 2U) << bench_->words();
}

TEST_F(LightBenches, MoveLampsByNameAndFindTheScenesFiles) {
    place_.write("cube.obj", "v -0.2 -0.2 -0.9\nv 0.2 -0.2 -0.9\nv 0 0.2 -0.9\nf 1 2 3\n");
    place_.write("lamp.toml", R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 0.1]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1
[[light]]
name = "lamp"
type = "point"
position = [0.5, 0, 2]
power = 100
[[surface]]
kind = "height_field"
size = [3, 3]
waves = [{ amplitude = 0.01, wavelength = 1.0, direction = 20.0, phase = 0.4 }]
[[object]]
name = "leaf"
file = "cube.obj"
)");
    options_.scene = (place_ / "lamp.toml").string();
    options_.light = "lamp";
    options_.light_position = glm::vec3(-0.5f, 0.25f, 1.5f);
    options_.bake = true;
    open();
    EXPECT_EQ(bench_->chosen(), 1U);
    play();
    ASSERT_EQ(listener_.volumes.size(), 1U) << bench_->words();
    EXPECT_EQ(*show_->lights()[1].position, glm::dvec3(-0.5, 0.25, 1.5));
    EXPECT_EQ(show_->lights()[0].direction, glm::dvec3(0, 0, -1));
    options_.light = "moon";
    EXPECT_THROW(LightBench(options_, *show_, listener_, PHOTIC_PROGRAM), Error);
}

}  // namespace
}  // namespace photic::test
