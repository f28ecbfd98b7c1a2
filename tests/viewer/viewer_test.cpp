// SPDX-License-Identifier: Apache-2.0
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include <gtest/gtest.h>

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bake/image/image.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

/// Red, green and blue of a PNG, 0 to 1.
struct Picture {
    int width = 0, height = 0;
    std::vector<double> values;
    double mean() const {
        double sum = 0;
        for (const double v : values) sum += v / static_cast<double>(values.size());
        return sum;
    }
    double spread() const {
        double sum = 0;
        for (const double v : values) sum += (v - mean()) * (v - mean()) / static_cast<double>(values.size());
        return std::sqrt(sum);
    }
};

Picture readPicture(const std::filesystem::path& path) {
    Picture out;
    int channels = 0;
    unsigned char* pixels = stbi_load(path.c_str(), &out.width, &out.height, &channels, 3);
    if (!pixels) return out;
    for (int i = 0; i < 3 * out.width * out.height; ++i) out.values.push_back(pixels[i] / 255.0);
    stbi_image_free(pixels);
    return out;
}

double meanDifference(const Picture& a, const Picture& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        sum += std::fabs(a.values[i] - b.values[i]) / static_cast<double>(a.values.size());
    }
    return sum;
}

/// A small pool, baked once for all tests of this file; straight down on its floor.
class Viewer : public testing::Test {
protected:
    static void SetUpTestSuite() {
        place_ = std::make_unique<Workplace>();
        PoolText pool;
        pool.voxel_size = 2.0 / 64;
        place_->write("pool.toml", pool.text());
        ASSERT_EQ(photic(*place_, {"bake", "pool.toml", "-o", "pool.vdb"}).code, 0);
    }
    static void TearDownTestSuite() { place_.reset(); }

    /// What `photic view` draws with these arguments, or skips where there is no GL.
    Picture shot(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "view");
        for (const char* a : {"--screenshot", "shot.png", "--size", "160x120", "--supersample", "1"})
            arguments.push_back(a);
        const Outcome outcome = photic(*place_, arguments);
        if (outcome.err.find("no EGL display") != std::string::npos) return {};
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        const Picture picture = readPicture(*place_ / "shot.png");
        EXPECT_EQ(picture.width, 160);
        EXPECT_EQ(picture.height, 120);
        return picture;
    }

    static inline std::unique_ptr<Workplace> place_;
};

const std::vector<std::string> kDown = {"--eye=0,-0.01,3", "--target=0,0,-1", "--fov", "34", "--no-surface"};

std::vector<std::string> with(std::vector<std::string> a, const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

TEST_F(Viewer, DrawsWithoutAScreen) {
    const Picture picture = shot({"pool.toml", "pool.vdb"});
    if (picture.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    EXPECT_GT(picture.mean(), 0.1);
    EXPECT_GT(picture.spread(), 0.08);
}

TEST_F(Viewer, LiveLightLooksLikeTheBake) {
    const Picture baked = shot(with({"pool.toml", "pool.vdb"}, kDown));
    if (baked.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const Picture dark = shot(with({"pool.toml", "pool.vdb", "--right", "none"}, kDown));
    const double scale = meanDifference(baked, dark);
    EXPECT_GT(scale, 0.1);
    for (const char* source : {"caustic-map", "warped-volumes"}) {
        const Picture live = shot(with({"pool.toml", "--right", source}, kDown));
        EXPECT_LT(meanDifference(live, baked), 0.06 * scale) << source;
    }
    const Picture looked_up = shot(with({"pool.toml", "--right", "look-up"}, kDown));
    EXPECT_GT(meanDifference(looked_up, baked), 0.06 * scale);
}

TEST_F(Viewer, SplitShowsBothHalves) {
    const Picture right = shot(with({"pool.toml", "pool.vdb", "--right", "none"}, kDown));
    if (right.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const Picture left = shot(with({"pool.toml", "pool.vdb"}, kDown));
    const Picture both =
        shot(with({"pool.toml", "pool.vdb", "--left", "baked", "--right", "none", "--split", "0.5"}, kDown));
    for (int y = 0; y < both.height; ++y) {
        for (int x = 0; x < both.width; ++x) {
            if (std::abs(x - 80) < 3) continue;  // the line between them
            const auto i = static_cast<std::size_t>(3 * (y * both.width + x));
            ASSERT_EQ(both.values[i], (x < 80 ? left : right).values[i]) << x << " " << y;
        }
    }
}

TEST_F(Viewer, ShowsAVolumeWithoutItsScene) {
    const Picture picture = shot({"pool.vdb"});
    if (picture.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    EXPECT_GT(picture.spread(), 0.05);
}

/// Means over a box in the middle of a picture.
double middleOf(const Picture& picture) {
    double sum = 0;
    int count = 0;
    for (int y = 50; y < 70; ++y) {
        for (int x = 60; x < 100; ++x, ++count) {
            const auto i = static_cast<std::size_t>(3 * (y * picture.width + x));
            sum += (picture.values[i] + picture.values[i + 1] + picture.values[i + 2]) / 3;
        }
    }
    return sum / count;
}

TEST_F(Viewer, LightInTheWaterIsSeenWhereNothingLiesBehind) {
    // From beside the pool, along its floor, towards the side that has no wall.
    const std::vector<std::string> across = {"pool.toml", "pool.vdb", "--no-surface",     "--eye=0,5,-0.5",
                                             "--fov",     "12",       "--target=0,0,-0.5"};
    const Picture unlit = shot(with(across, {"--shafts", "0.3", "--right", "none"}));
    if (unlit.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const Picture lit = shot(with(across, {"--shafts", "0.3"}));
    EXPECT_GT(middleOf(lit), middleOf(unlit) + 0.03);
}

TEST_F(Viewer, AVolumeAloneHasNoBlackFloor) {
    const Picture picture = shot({"pool.vdb", "--ambient", "0", "--eye=0,-0.01,5", "--target=0,0,-1", "--fov", "34"});
    if (picture.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    double darkest = 1;
    for (const double v : picture.values) darkest = std::min(darkest, v);
    EXPECT_GT(darkest, 0.05);  // the background begins at 0.07
}

TEST_F(Viewer, ReflectedLightIsBrightAtFirstSightAndItsMirrorIsDrawn) {
    place_->write("arch.toml", R"(photic = 1
[domain]
min = [-1, -1, 0]
max = [1, 1, 1.1]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = [0, 0.5, -0.866]
[[surface]]
name = "water"
kind = "height_field"
waves = [{ amplitude = 0.01, wavelength = 1.0, direction = 20.0, phase = 0.4 }]
size = [6, 6]
event = "reflect"
ior_below = 1.333
[[object]]
name = "arch"
plane = { point = [0, 0, 1], normal = [0, 0, -1] }
role = "movable"
)");
    const Outcome baked = photic(*place_, {"bake", "arch.toml", "-o", "arch.vdb"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    // Another scene's volume is shown, with a word.
    const Outcome mixed =
        photic(*place_, {"view", "arch.toml", "pool.vdb", "--screenshot", "mixed.png", "--size", "64x48"});
    if (mixed.err.find("no EGL display") == std::string::npos) {
        EXPECT_EQ(mixed.code, 0) << mixed.err;
        EXPECT_NE(mixed.err.find("pool.vdb' seems to be of another scene"), std::string::npos) << mixed.err;
    }
    const Picture below = shot({"arch.toml", "arch.vdb", "--eye=0,-2,0.1", "--target=0,0,0.9", "--ambient", "0"});
    if (below.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    EXPECT_GT(middleOf(below), 0.3);
    // From above: the arch's back, which is drawn, and the water beside it.
    const std::vector<std::string> above = {"arch.toml", "arch.vdb", "--eye=0,-3,0.6", "--target=0,-0.6,0"};
    EXPECT_GT(middleOf(shot(above)), middleOf(shot(with(above, {"--no-surface"}))) + 0.02);
}

TEST_F(Viewer, BallIsLit) {
    const Picture without = shot(with({"pool.toml", "pool.vdb"}, kDown));
    if (without.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const Picture with_ball = shot(with({"pool.toml", "pool.vdb", "--ball=0,0,-0.6,0.3"}, kDown));
    const auto middle = static_cast<std::size_t>(3 * (60 * 160 + 80));
    EXPECT_GT(with_ball.values[middle], 0.3);
    EXPECT_GT(meanDifference(without, with_ball), 0.005);
}

TEST_F(Viewer, ObjectsAreSeenThrough) {
    place_->write("lens.toml", R"(photic = 1
[domain]
min = [-1, -1, -1]
max = [1, 1, 1]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = [0.3, 0, -1]
irradiance = 1000
[[medium]]
name = "lens"
index = { kind = "luneburg", radius = 0.6 }
absorption = [0, 3, 3]
[[object]]
name = "floor"
role = "movable"
plane = { point = [0, 0, -0.9], normal = [0, 0, 1] }
)");
    ASSERT_EQ(photic(*place_, {"export", "lens.toml", "-o", "lens.ivol"}).code, 0);
    const std::vector<std::string> scene{"lens.toml", "--right", "none", "--eye=3,0,0.4", "--target=0,0,0"};
    const Picture without = shot(scene);
    if (without.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const Picture lens = shot(with(scene, {"lens.ivol"})), turned = shot(with(scene, {"lens.ivol", "--turn", "90"}));
    const std::size_t middle = 3 * (60 * 160 + 80);
    EXPECT_GT(lens.values[middle], 1.5 * lens.values[middle + 1]) << "red glass";
    EXPECT_GT(lens.values[middle], 0.05);
    EXPECT_NE(lens.values, turned.values) << "the environment turns";
    // Panoramas of a sequence: behind the lens is what its frame has.
    for (const int frame : {1, 2}) {
        Image sky{32, 16, 3, {}};
        for (int i = 0; i < 32 * 16; ++i)
            for (const float v : {0.1F, frame == 1 ? 1.0F : 0.1F, frame == 1 ? 0.1F : 1.0F}) sky.pixels.push_back(v);
        writeExr((place_->path() / ("sky.000" + std::to_string(frame) + ".exr")).string(), sky);
    }
    const auto under = [&](const char* frame) {
        return shot(with(scene, {"lens.ivol", "--environment", "sky.####.exr", "--frames", frame}));
    };
    const Picture green = under("1"), blue = under("2-3");
    EXPECT_GT(green.values[middle + 1], 2 * green.values[middle + 2]);
    EXPECT_GT(blue.values[middle + 2], 2 * blue.values[middle + 1]);
    const auto refused = [&](const std::string& file) {
        return photic(*place_, {"view", file, "no.ivol", "--right", "none", "--screenshot", "shot.png"}).code;
    };
    EXPECT_EQ(refused("lens.ivol"), 2) << "neither a scene nor a volume";
    EXPECT_EQ(refused("lens.toml"), 3) << "no such file";
    const Outcome around =
        photic(*place_, {"view", "lens.toml", "--environment", "sky.0001.exr", "--screenshot", "shot.png"});
    EXPECT_EQ(around.code, 2) << "around nothing";
    EXPECT_NE(around.err.find("--environment"), std::string::npos) << around.err;
    const Outcome missing = photic(*place_, {"view", "lens.toml", "lens.ivol", "--right", "none", "--environment",
                                             "sky.####.exr", "--frames", "7", "--screenshot", "shot.png"});
    EXPECT_EQ(missing.code, 3);
    EXPECT_NE(missing.err.find("sky.0007.exr"), std::string::npos) << missing.err;
}

/// Where programs put temporary files, for a while.
class TemporaryPlace {
public:
    explicit TemporaryPlace(const std::filesystem::path& path) : path_(path) {
        std::filesystem::create_directory(path);
        setenv("TMPDIR", path.c_str(), 1);
    }
    ~TemporaryPlace() { unsetenv("TMPDIR"); }
    TemporaryPlace(const TemporaryPlace&) = delete;
    TemporaryPlace& operator=(const TemporaryPlace&) = delete;
    bool empty() const { return std::filesystem::is_empty(path_); }

private:
    std::filesystem::path path_;
};

TEST_F(Viewer, AMovedLightLooksLikeItsBakeByHand) {
    PoolText pool;
    pool.voxel_size = 2.0 / 64, pool.sun_direction = "[-0.25, 0.5, -2]";
    place_->write("moved.toml", pool.text());
    ASSERT_EQ(photic(*place_, {"bake", "moved.toml", "-o", "moved.vdb"}).code, 0);
    const Picture by_hand = shot(with({"moved.toml", "moved.vdb"}, kDown));
    if (by_hand.values.empty()) GTEST_SKIP() << "no GL without a screen here";
    const TemporaryPlace temporary(*place_ / "temporary");
    const Picture before = shot(with({"pool.toml", "pool.vdb"}, kDown));
    const Picture moved = shot(with({"pool.toml", "pool.vdb", "--light-direction=-0.25,0.5,-2"}, kDown));
    EXPECT_GT(meanDifference(before, by_hand), 0.01);
    EXPECT_EQ(moved.values, by_hand.values);
    EXPECT_EQ(shot(with({"pool.toml", "--bake"}, kDown)).values, before.values) << "no volume is needed for that";
    EXPECT_TRUE(temporary.empty()) << "nothing is left behind";
}

TEST_F(Viewer, NothingIsLeftOfABakeThatIsInterrupted) {
    const TemporaryPlace temporary(*place_ / "temporary");
    Program viewer(*place_, {"view", "pool.toml", "--bake", "--bake-with", "--voxel-size 0.003 --threads 1",
                             "--screenshot", "never.png"});
    const auto baking = [&] { return std::filesystem::exists(*place_ / "temporary") && !temporary.empty(); };
    for (int n = 0; n < 2000 && !baking(); ++n) usleep(5000);
    if (!baking()) {
        const Outcome none = viewer.wait();
        ASSERT_NE(none.err.find("no EGL display"), std::string::npos) << none.err;
        GTEST_SKIP() << "no GL without a screen here";
    }
    usleep(300000);
    kill(viewer.pid(), SIGTERM);
    const Outcome outcome = viewer.wait();
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_TRUE(temporary.empty());
    EXPECT_FALSE(place_->has("never.png"));
}

TEST_F(Viewer, MistakesAreNamed) {
    const auto expect = [&](std::vector<std::string> arguments, int code, const char* part) {
        arguments.insert(arguments.begin(), "view");
        const Outcome outcome = photic(*place_, arguments);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    };
    expect({}, 2, "FILES");
    expect({"pool.exr", "--screenshot", "x.png"}, 2, "pool.exr");
    expect({"pool.toml", "--size", "7"}, 2, "--size");
    expect({"pool.toml", "--eye", "1,2"}, 2, "--eye");
    expect({"pool.toml", "--right", "magic"}, 2, "--right");
    expect({"pool.vdb", "--bake"}, 2, "--bake");
    expect({"pool.toml", "--light-position=0,0,3", "--screenshot", "x.png"}, 2, "no light that can be moved so");
    expect({"pool.toml", "--light-direction=0,0,1", "--screenshot", "x.png"}, 3, "pool.toml:8:1: the light");
    expect({"missing.vdb", "--screenshot", "x.png"}, 3, "missing.vdb");
    expect({"missing.toml", "--screenshot", "x.png"}, 3, "missing.toml");
    expect({"pool.vdb", "--right", "look-up", "--screenshot", "x.png"}, 2, "scene");
    expect({"pool.toml", "--right", "baked", "--screenshot", "x.png"}, 2, "volume");
    place_->write("broken.nvdb", "NanoVDB0 and then nothing");
    expect({"broken.nvdb", "--screenshot", "x.png"}, 3, "broken.nvdb");
    EXPECT_FALSE(place_->has("x.png"));
}

}  // namespace
}  // namespace photic::test
