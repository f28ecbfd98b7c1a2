// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <numbers>

#include "bake/image/atomic_file.h"
#include "bake/image/image.h"
#include "tests/scene/scene_texts.h"
#include "tests/scene/surface_checks.h"

namespace photic {
namespace {

using test::SceneTest;

class HeightMaps : public SceneTest {
protected:
    template <typename F>
    void map(const std::string& name, int width, int height, int channels, const F& f,
             ChannelDepth depth = ChannelDepth::Float) {
        Image image{width, height, channels, {}};
        image.pixels.resize(static_cast<std::size_t>(width * height * channels));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < channels; ++c) image.at(x, y, c) = static_cast<float>(f(x, y, c));
        writeExr(path(name), image, depth);
    }
    std::shared_ptr<const HeightField> field(const std::string& keys) {
        return loadSurfaceKeys(keys).surfaces[0].height_field;
    }
};

TEST_F(HeightMaps, TopRowIsPlusYAndTexelsAreCentred) {
    map("h.exr", 8, 4, 1, [](int x, int y, int) { return x + 100 * y; });
    const auto h = field("file = \"h.exr\"\nsize = [4, 2]\ncenter = [10, 20, 1]\nscale = 0.5\nlevel = 2");
    // Texel (3, 0) of the top row: x = 10 - 2 + 3.5 * 0.5, y = 20 + 1 - 0.5 * 0.5.
    EXPECT_NEAR(h->at({9.75, 20.75}).position.z, 1 + 0.5 * (3 - 2), 1e-12);
    EXPECT_NEAR(h->at({8.25, 19.25}).position.z, 1 + 0.5 * (300 - 2), 1e-11);
    EXPECT_NEAR(h->at({9, 20}).normal.x, -0.5 * 2, 1e-11);       // one per texel of 0.5 m, by 0.5 m
    EXPECT_NEAR(h->at({9, 20}).normal.y, 0.5 * 100 * 2, 1e-10);  // rows grow downwards
    EXPECT_EQ(h->at({12.1, 20}).position.z, 1);
    EXPECT_DOUBLE_EQ(h->featureSize(), 0.5);
}

TEST_F(HeightMaps, TexelsAtCornersGoFromEdgeToEdge) {
    map("h.exr", 9, 5, 1, [](int x, int y, int) { return x + 100 * y; });
    const std::string keys = "file = \"h.exr\"\nsize = [4, 2]\ncenter = [10, 20, 1]\noutside = \"none\"\n";
    const auto h = field(keys + "texels = \"corners\"");
    EXPECT_NEAR(h->at({8, 21}).position.z, 1, 1e-10);
    EXPECT_NEAR(h->at({12, 19}).position.z, 1 + 408, 1e-10);
    EXPECT_NEAR(h->at({9.5, 20.5}).position.z, 1 + 103, 1e-10);
    EXPECT_NEAR(h->at({10, 20}).normal.x, -2, 1e-10);
    EXPECT_DOUBLE_EQ(h->featureSize(), 0.5);
    EXPECT_LT(test::rowDifference(*h, {7.9, 20.3}, 0.01, 420), 1e-9);
    EXPECT_GT(std::fabs(field(keys)->at({8, 21}).position.z - 1), 0.1);
    refusedSurface("file = \"h.exr\"\nsize = [4, 2]\noutside = \"periodic\"\ntexels = \"corners\"", "s.toml:13:1",
                   {"both edges", "centers"});
}

TEST_F(HeightMaps, BilinearWhenAsked) {
    map("h.exr", 8, 8, 1, [](int x, int, int) { return x == 4 ? 1.0 : 0.0; });
    const std::string keys = "file = \"h.exr\"\nsize = [8, 8]\n";
    EXPECT_NEAR(field(keys + "interpolation = \"bilinear\"")->at({0.75, 0}).position.z, 0.75, 1e-12);
    EXPECT_GT(std::fabs(field(keys)->at({0.75, 0}).position.z - 0.75), 0.02);
}

TEST_F(HeightMaps, PeriodicMapsGoOn) {
    const auto wave = [](int x, int y, int) { return std::sin(2 * std::numbers::pi * (x + 2 * y) / 16); };
    map("h.exr", 16, 16, 1, wave);
    const auto h = field("file = \"h.exr\"\nsize = [2, 2]\noutside = \"periodic\"");
    EXPECT_TRUE(warnings_.messages.empty());
    EXPECT_NEAR(h->at({0.9, 0.9}).position.z, h->at({-1.1, 4.9}).position.z, 1e-12);
    map("h.exr", 16, 16, 1, [](int x, int, int) { return x; });
    field("file = \"h.exr\"\nsize = [2, 2]\noutside = \"periodic\"");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("does not join at its edges (steps 15.0 times"), std::string::npos)
        << warnings_.messages[0];
}

TEST_F(HeightMaps, DisplacementAsBlendersOceanWritesIt) {
    // R: along x, G: height, B: along y.
    map("o.exr", 8, 8, 3, [](int x, int y, int c) { return c == 0 ? 0.1 : c == 1 ? 1 + 0.01 * x : -0.2 + 0.0 * y; });
    const auto h = field("file = \"o.exr\"\nsize = [8, 8]\ndisplacement = true\nscale = 2\nlevel = 1");
    const SurfacePoint p = h->at({0.5, 0.5});
    EXPECT_NEAR(glm::length(p.position - glm::dvec3(0.7, 0.1, 0.08)), 0, 1e-6);
    EXPECT_NEAR(h->maxDisplacement(), std::hypot(0.2, 0.4), 1e-6);
    const auto swapped =
        field("file = \"o.exr\"\nsize = [8, 8]\nchannel = \"R\"\ndisplacement_channels = [\"B\", \"G\"]");
    EXPECT_NEAR(swapped->at({0.5, 0.5}).position.x, 0.3, 1e-6);
    EXPECT_NEAR(swapped->at({0.5, 0.5}).position.z, 0.1, 1e-6);
    map("fold.exr", 8, 8, 3, [](int x, int, int c) { return c == 0 ? (x % 2 ? 2.0 : -2.0) : 0.0; });
    field("file = \"fold.exr\"\nsize = [8, 8]\ndisplacement = true");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("folds the surface"), std::string::npos);
}

TEST_F(HeightMaps, SequencesFollowTheFrame) {
    for (const int frame : {7, 12345})
        map(frame == 7 ? "w.0007.exr" : "w.12345.exr", 4, 4, 1, [&](int, int, int) { return frame; });
    const std::string keys = "file = \"w.####.exr\"\nsize = [1, 1]";
    EXPECT_NEAR(loadSurfaceKeys(keys, 7).surfaces[0].height_field->at({0, 0}).position.z, 7, 1e-12);
    EXPECT_NEAR(loadSurfaceKeys(keys, 12345).surfaces[0].height_field->at({0, 0}).position.z, 12345, 1e-9);
    EXPECT_NE(loadSurfaceKeys(keys, 7).hash, loadSurfaceKeys(keys, 12345).hash);
    refusedSurface(keys, "s.toml:10:1", {"w.0000.exr", "No such file"});
}

TEST_F(HeightMaps, BadValuesAreNamedByPixel) {
    map("h.exr", 8, 6, 1, [](int x, int y, int) {
        return (x == 5 && y == 3) || y == 5 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
    });
    refusedSurface("file = \"h.exr\"\nsize = [1, 1]", "s.toml:10:1",
                   {"h.exr", "is nan at pixel (5, 3), counted from the top left; 9 of 48 pixels"});
    map("h.exr", 8, 6, 1,
        [](int x, int y, int) { return x == 0 && y == 5 ? std::numeric_limits<double>::infinity() : 0.0; });
    refusedSurface("file = \"h.exr\"\nsize = [1, 1]", "s.toml:10:1", {"is inf at pixel (0, 5)"});
    map("h.exr", 3, 9, 1, [](int, int, int) { return 0; });
    refusedSurface("file = \"h.exr\"\nsize = [1, 1]", "s.toml:10:1", {"3 x 9 pixels", "needs 4 a side"});
}

TEST_F(HeightMaps, HalfFloatsAreWarnedAbout) {
    map(
        "h.exr", 8, 8, 1, [](int x, int, int) { return 0.1 * x; }, ChannelDepth::Half);
    field("file = \"h.exr\"\nsize = [1, 1]");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("half floats"), std::string::npos);
    EXPECT_NE(warnings_.messages[0].find("s.toml:10:1"), std::string::npos);
}

TEST_F(HeightMaps, UnusableFilesAreRefused) {
    const std::string size = "\nsize = [1, 1]";
    refusedSurface("file = \"gone.exr\"" + size, "s.toml:10:1", {"gone.exr", "No such file"});
    refusedSurface("file = \"a.tif\"" + size, "s.toml:10:1", {"a.tif", ".exr and 16-bit .png"});
    refusedSurface("file = \"n.vdb\"" + size, "s.toml:10:1", {"n.vdb' is a volume", "[[index]] with file = \"n.vdb\""});
    map("rgb.exr", 8, 8, 3, [](int, int, int) { return 0; });
    refusedSurface("file = \"rgb.exr\"" + size, "s.toml:10:1", {"has the channels B, G, R", "channel = \"G\""});
    refusedSurface("file = \"rgb.exr\"\nchannel = \"Z\"" + size, "s.toml:10:1", {"no channel 'Z'", "B, G, R"});
    refusedSurface("file = \"rgb.exr\"\ndisplacement_channels = [\"R\"]" + size, "s.toml:11:1", {"has 1 names"});
    refusedSurface("file = \"rgb.exr\"\nchannel = \"G\"", "s.toml:9:1", {"needs 'size'"});
    writePng(path("8.png"), Image{4, 4, 1, std::vector<float>(16, 0.5f)});
    refusedSurface("file = \"8.png\"" + size, "s.toml:10:1", {"8-bit PNG", "16 bits"});
    refusedSurface("file = \"8.png\"\nchannel = \"G\"" + size, "s.toml:11:1", {"'channel' is for EXR"});

    map("whole.exr", 32, 32, 1, [](int x, int y, int) { return std::sin(x * y); });
    const std::string bytes = readFileBytes(path("whole.exr"));
    for (const double share : {0.0, 0.01, 0.1, 0.5, 0.99}) {
        write("cut.exr", bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
        refusedSurface("file = \"cut.exr\"" + size, "s.toml:10:1", {"cut.exr"});
    }
}

}  // namespace
}  // namespace photic
