// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/display.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/picture/text.h"
#include "bake/report/error.h"

namespace photic {
namespace {

Image flat(int width, int height, int channels, float value) {
    return {width, height, channels,
            std::vector<float>(
                static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels),
                value)};
}

int differing(const Image& a, const Image& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) count += a.pixels[i] != b.pixels[i];
    return count;
}

TEST(Display, EncodesSrgb) {
    EXPECT_NEAR(encodeSrgb(0.5), 0.7353569830524495, 1e-12);
    EXPECT_NEAR(encodeSrgb(0.001), 0.01292, 1e-12);
    EXPECT_EQ(encodeSrgb(-1), 0);
    EXPECT_NEAR(encodeSrgb(7), 1, 1e-12);
}

TEST(Display, LinearPicturesReachWhiteAtWhite) {
    Image image = flat(3, 1, 1, 0);
    image.at(1, 0, 0) = 250;
    image.at(2, 0, 0) = 2000;
    const Image shown = displayLinear(image, 1000);
    ASSERT_EQ(shown.channels, 3);
    EXPECT_EQ(shown.at(0, 0, 1), 0.0F);
    EXPECT_NEAR(static_cast<double>(shown.at(1, 0, 1)), encodeSrgb(0.25), 1e-6);
    EXPECT_NEAR(static_cast<double>(shown.at(2, 0, 1)), 1.0, 1e-6);
}

TEST(Display, FilmicRisesAndKeepsTheBackgroundWhereNothingIs) {
    Image image = flat(4, 1, 4, 0);
    for (int x = 1; x < 4; ++x) {
        for (int c = 0; c < 3; ++c) image.at(x, 0, c) = static_cast<float>(x * x) * 0.1F;
        image.at(x, 0, 3) = 1;
    }
    const Image shown = displayFilmic(image, 1);
    EXPECT_LT(shown.at(1, 0, 0), shown.at(2, 0, 0));
    EXPECT_LT(shown.at(2, 0, 0), shown.at(3, 0, 0));
    EXPECT_LE(shown.at(3, 0, 0), 1.0F);
    // Half coverage lies between the background and the full colour, whatever the radiance.
    Image half = flat(1, 1, 4, 0.05F);
    half.at(0, 0, 3) = 0.5F;
    const Image full = displayFilmic(flat(1, 1, 4, 0.1F), 1), mixed = displayFilmic(half, 1),
                none = displayFilmic(flat(1, 1, 4, 0), 1);
    Image opaque = flat(1, 1, 4, 0.1F);
    opaque.at(0, 0, 3) = 1;
    EXPECT_NEAR(
        static_cast<double>(mixed.at(0, 0, 2)),
        0.5 * static_cast<double>(displayFilmic(opaque, 1).at(0, 0, 2)) + 0.5 * static_cast<double>(none.at(0, 0, 2)),
        1e-6);
    EXPECT_NE(full.at(0, 0, 2), none.at(0, 0, 2));
}

TEST(Display, PercentileLeavesOutWhatIsTransparent) {
    Image image = flat(10, 10, 4, 0);
    for (int i = 0; i < 50; ++i) {
        for (int c = 0; c < 3; ++c) image.at(i % 10, i / 10, c) = static_cast<float>(i + 1);
        image.at(i % 10, i / 10, 3) = 1;
    }
    EXPECT_EQ(percentile(image, 0), 1);
    EXPECT_EQ(percentile(image, 1), 50);
    EXPECT_NEAR(percentile(image, 0.5), 25, 1);
    EXPECT_EQ(percentile(flat(4, 4, 4, 0), 0.5), 0);
}

TEST(Display, NiceCeilingRoundsUp) {
    EXPECT_DOUBLE_EQ(niceCeiling(1234), 1500);
    EXPECT_DOUBLE_EQ(niceCeiling(0.07), 0.08);
    EXPECT_DOUBLE_EQ(niceCeiling(3), 3);
    EXPECT_DOUBLE_EQ(niceCeiling(9.1), 10);
    EXPECT_DOUBLE_EQ(niceCeiling(0), 1);
    EXPECT_DOUBLE_EQ(niceCeiling(INFINITY), 1);
}

TEST(Display, MappedPicturesCarryABarFromMaxToMin) {
    const Image image = flat(64, 200, 1, 5);
    const Image shown = displayMapped(image, ColourMap::Viridis, 0, 10, "W/m2");
    ASSERT_GT(shown.width, 64 + 14);
    ASSERT_EQ(shown.height, 200);
    const auto expect_colour = [&](int x, int y, double value, double tolerance) {
        const auto colour = colourOf(ColourMap::Viridis, value);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(shown.at(x, y, c), colour[static_cast<std::size_t>(c)], tolerance) << x << ' ' << y << ' ' << c;
    };
    expect_colour(30, 100, 0.5, 1e-6);
    // The bar begins one margin (8) right of the picture, 22 below the top, and ends a margin above the bottom.
    expect_colour(64 + 8 + 5, 22, 1.0, 0.02);
    expect_colour(64 + 8 + 5, 191, 0.0, 0.02);
    // Its labels depend on the range.
    EXPECT_GT(differing(shown, displayMapped(flat(64, 200, 1, 50), ColourMap::Viridis, 0, 100, "W/m2")), 20);
}

TEST(Display, TextIsDrawnAndClipped) {
    Image image = flat(40, 12, 3, 0);
    drawText(image, 0, 0, "Hg7", 1, {1, 0.5, 0});
    const int ink = differing(image, flat(40, 12, 3, 0));
    EXPECT_GT(ink, 30);
    EXPECT_EQ(textWidth("Hg7", 2), 2 * textWidth("Hg7", 1));
    Image other = flat(40, 12, 3, 0);
    drawText(other, 0, 0, "Hg8", 1, {1, 0.5, 0});
    EXPECT_GT(differing(image, other), 0);
    drawText(image, -300, -5, "outside \xff\n", 9, {1, 1, 1});
    drawText(image, 39, 11, std::string(400, 'W'), 3, {1, 1, 1});
}

TEST(Display, EnlargesByWholePixels) {
    Image image = flat(3, 2, 1, 0);
    image.at(2, 1, 0) = 7;
    const Image large = enlarge(image, 8);
    ASSERT_EQ(large.width, 12);
    ASSERT_EQ(large.height, 8);
    EXPECT_EQ(large.at(11, 7, 0), 7.0F);
    EXPECT_EQ(large.at(8, 4, 0), 7.0F);
    EXPECT_EQ(large.at(7, 4, 0), 0.0F);
    EXPECT_EQ(enlarge(image, 0, 2).height, 4);
    // A thin band.
    const Image band{100, 2, 1, std::vector<float>(200)}, longer = enlarge(band, 50);
    EXPECT_EQ(longer.width, 200);
    EXPECT_EQ(longer.height, 4);
}

TEST(Display, FilmStripLaysPicturesOutInRows) {
    const Image strip =
        filmStrip({flat(20, 10, 3, 0.1F), flat(20, 10, 3, 0.2F), flat(20, 10, 3, 0.3F)}, {"a", "b", "c"}, 2);
    EXPECT_EQ(strip.width, 2 * (20 + 6) + 6);
    EXPECT_EQ(strip.height, 2 * (10 + 14 + 6) + 6);
    EXPECT_EQ(strip.at(6 + 26 + 3, 6 + 3, 0), 0.2F);
    EXPECT_EQ(strip.at(6 + 3, 6 + 30 + 3, 0), 0.3F);
    EXPECT_THROW(filmStrip({}, {}, 2), Error);
}

}  // namespace
}  // namespace photic
