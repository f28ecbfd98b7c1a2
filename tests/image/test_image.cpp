// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include "bake/image/atomic_file.h"
#include "bake/image/colour_map.h"
#include "bake/image/image.h"
#include "bake/report/error.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

class ImageTest : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "photic_image_XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        directory_ = name;
    }
    void TearDown() override { fs::remove_all(directory_); }
    std::string path(const std::string& name) const { return (directory_ / name).string(); }
    std::size_t fileCount() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
    }
    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }

    fs::path directory_;
};

/// Expects an Error of `code` whose message contains every one of `words`.
template <typename Body>
void expectError(ErrorCode code, const std::vector<std::string>& words, const Body& body) {
    try {
        body();
        ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        for (const std::string& word : words)
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
    }
}

Image ramp(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    image.pixels.resize(static_cast<std::size_t>(width * height * channels));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c) image.at(x, y, c) = static_cast<float>(x * 0.37 - y * 1.9 + c * 1000.25);
    return image;
}

TEST_F(ImageTest, FloatExrRoundTripIsExact) {
    for (const int channels : {1, 3, 4}) {
        const Image out = ramp(13, 7, channels);
        writeExr(path("a.exr"), out);
        const Image in = readExr(path("a.exr"));
        ASSERT_EQ(in.width, 13);
        ASSERT_EQ(in.height, 7);
        ASSERT_EQ(in.channels, channels);
        EXPECT_EQ(in.pixels, out.pixels);
    }
    EXPECT_EQ(fileCount(), 1u);
}

TEST_F(ImageTest, HalfExrRoundsAndNeverTurnsFiniteIntoInfinite) {
    Image image = ramp(4, 2, 1);
    image.at(0, 0, 0) = 70000.0f, image.at(1, 0, 0) = -1e9f, image.at(2, 0, 0) = 0.1f;
    writeExr(path("h.exr"), image, ChannelDepth::Half);
    const Image in = readExr(path("h.exr"));
    EXPECT_EQ(in.at(0, 0, 0), 65504.0f);
    EXPECT_EQ(in.at(1, 0, 0), -65504.0f);
    EXPECT_NEAR(in.at(2, 0, 0), 0.1f, 0.1f / 2048);
    EXPECT_NE(in.at(2, 0, 0), 0.1f);
    EXPECT_TRUE(readExrChannels(path("h.exr"), {"Y"})[0].half);
}

TEST_F(ImageTest, UintExrRounds) {
    Image image{3, 1, 1, {1.4f, 70000.6f, -3.0f}};
    writeExr(path("u.exr"), image, ChannelDepth::Uint32);
    EXPECT_EQ(readExr(path("u.exr")).pixels, (std::vector<float>{1.0f, 70001.0f, 0.0f}));
}

TEST_F(ImageTest, NamedChannelsComeInTheOrderAskedAndPassNanOn) {
    Image image = ramp(5, 3, 3);
    image.at(2, 1, 1) = std::numeric_limits<float>::quiet_NaN();
    writeExr(path("rgb.exr"), image);
    EXPECT_EQ(exrChannelNames(path("rgb.exr")), (std::vector<std::string>{"B", "G", "R"}));
    const auto maps = readExrChannels(path("rgb.exr"), {"G", "R", "G"});
    ASSERT_EQ(maps.size(), 3u);
    EXPECT_FALSE(maps[0].half);
    EXPECT_TRUE(std::isnan(maps[0].values[1 * 5 + 2]));
    EXPECT_TRUE(std::isnan(maps[2].values[1 * 5 + 2]));
    EXPECT_EQ(maps[1].values[2 * 5 + 4], image.at(4, 2, 0));
    EXPECT_EQ(maps[0].values[0], image.at(0, 0, 1));
}

TEST_F(ImageTest, DataWindowAwayFromTheOriginKeepsItsTopRowFirst) {
    const std::vector<float> values{1, 2, 3, 4, 5, 6};
    Imf::Header header(Imath::Box2i({0, 0}, {99, 99}), Imath::Box2i({-7, 40}, {-5, 41}));
    header.channels().insert("height", Imf::Channel(Imf::FLOAT));
    Imf::FrameBuffer buffer;
    buffer.insert("height", Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow()));
    {
        Imf::OutputFile file(path("w.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(2);
    }
    const HeightMap map = readExrChannels(path("w.exr"), {"height"})[0];
    EXPECT_EQ(map.width, 3);
    EXPECT_EQ(map.values, values);
    expectError(ErrorCode::Input, {"w.exr", "neither", "height"}, [&] { readExr(path("w.exr")); });
}

TEST_F(ImageTest, TruncatedExrIsRefusedAtEveryLength) {
    Image image = ramp(40, 30, 3);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] *= std::sin(static_cast<float>(i * i));
    writeExr(path("whole.exr"), image);
    const std::string bytes = readFileBytes(path("whole.exr"));
    ASSERT_GT(bytes.size(), 5000u);
    for (std::size_t length = 0; length < bytes.size(); length += length < 600 ? 7 : 211) {
        write("cut.exr", bytes.substr(0, length));
        expectError(ErrorCode::Input, {"cut.exr"}, [&] { readExrChannels(path("cut.exr"), {"G"}); });
    }
    write("cut.exr", bytes.substr(0, bytes.size() - 1));
    expectError(ErrorCode::Input, {"cut.exr", "truncated"}, [&] { readExr(path("cut.exr")); });
}

TEST_F(ImageTest, UnusableExrIsRefusedByReason) {
    expectError(ErrorCode::Input, {"none.exr", "No such file"}, [&] { readExr(path("none.exr")); });
    expectError(ErrorCode::Input, {"directory"}, [&] { readExr(directory_.string()); });
    write("text.exr", "not an image");
    expectError(ErrorCode::Input, {"text.exr", "not an OpenEXR"}, [&] { readExr(path("text.exr")); });
    writeExr(path("rgb.exr"), ramp(2, 2, 3));
    expectError(ErrorCode::Input, {"'Z'", "B, G, R"}, [&] { readExrChannels(path("rgb.exr"), {"Z"}); });

    // A header that claims 40000 columns, over no data.
    Imf::Header header(40000, 1);
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    { Imf::OutputFile file(path("wide.exr").c_str(), header); }
    expectError(ErrorCode::Input, {"40000 x 1", "32768"}, [&] { readExr(path("wide.exr")); });
}

TEST_F(ImageTest, Png16ReadsGrey) {
    // stb writes 8 bits only: a 2 x 1 PNG of 16-bit grey, 0x8000 and 0xffff, with stored (uncompressed) data.
    const auto chunk = [](const std::string& type, const std::string& data) {
        std::uint32_t crc = 0xffffffffu;
        for (const char c : type + data) {
            crc ^= static_cast<unsigned char>(c);
            for (int k = 0; k < 8; ++k) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
        }
        const auto big_endian = [](std::uint32_t v) {
            return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                               static_cast<char>(v)};
        };
        return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(~crc);
    };
    const std::string row("\0\x80\x00\xff\xff", 5);
    std::uint32_t a = 1, b = 0;
    for (const char c : row) a = (a + static_cast<unsigned char>(c)) % 65521, b = (b + a) % 65521;
    const std::string adler{static_cast<char>(b >> 8), static_cast<char>(b), static_cast<char>(a >> 8),
                            static_cast<char>(a)};
    const std::string png =
        std::string("\x89PNG\r\n\x1a\n") + chunk("IHDR", std::string("\0\0\0\x02\0\0\0\x01\x10\0\0\0\0", 13)) +
        chunk("IDAT", std::string("\x78\x01\x01\x05\x00\xfa\xff", 7) + row + adler) + chunk("IEND", "");
    write("g.png", png);
    const HeightMap map = readPng16(path("g.png"));
    ASSERT_EQ(map.values.size(), 2u);
    EXPECT_FLOAT_EQ(map.values[0], 32768.0f / 65535.0f);
    EXPECT_FLOAT_EQ(map.values[1], 1.0f);

    for (std::size_t length = 0; length + 20 < png.size(); ++length) {
        write("cut.png", png.substr(0, length));
        expectError(ErrorCode::Input, {"cut.png"}, [&] { readPng16(path("cut.png")); });
    }
}

TEST_F(ImageTest, PngOf8BitsIsRefusedByName) {
    writePng(path("8.png"), Image{2, 2, 1, {0, 1, 0.5f, 0.25f}});
    expectError(ErrorCode::Input, {"8.png", "8-bit", "16 bits"}, [&] { readPng16(path("8.png")); });
    expectError(ErrorCode::Input, {"none.png", "No such file"}, [&] { readPng16(path("none.png")); });
}

TEST_F(ImageTest, PngIsClampedAndNanIsBlack) {
    Image image{4, 1, 1, {-1.0f, 2.0f, std::numeric_limits<float>::quiet_NaN(), 0.5f}};
    writePng(path("a.png"), image);
    const std::string bytes = readFileBytes(path("a.png"));
    EXPECT_EQ(bytes.substr(1, 3), "PNG");
    EXPECT_EQ(bytes[25], 0);  // colour type: grey
    EXPECT_EQ(fileCount(), 1u);
    EXPECT_EQ(colourOf(ColourMap::Magma, std::nan(""))[1], 1.0f);
}

TEST_F(ImageTest, FailedWriteKeepsTheOldFileAndLeavesNothing) {
    const Image old = ramp(4, 4, 1);
    writeExr(path("o.exr"), old);

    // A file size limit stands in for a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    rlimit small = before;
    small.rlim_cur = 4096;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    Image noise = ramp(128, 128, 3);
    for (std::size_t i = 0; i < noise.pixels.size(); ++i) noise.pixels[i] = std::sin(static_cast<float>(i * i));
    expectError(ErrorCode::Failed, {"o.exr", "too large"}, [&] { writeExr(path("o.exr"), noise); });
    expectError(ErrorCode::Failed, {"o.png", "too large"}, [&] { writePng(path("o.png"), noise); });
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);

    EXPECT_EQ(readExr(path("o.exr")).pixels, old.pixels);
    EXPECT_EQ(fileCount(), 1u);
    expectError(ErrorCode::Failed, {"missing", "No such file"}, [&] { writePng(path("missing/o.png"), noise); });
    expectError(ErrorCode::Failed, {"no regular file"}, [&] { writeExr("/dev/null", old); });
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(ColourMap, LightnessOfPerceptualMapsGrows) {
    for (const ColourMap map : {ColourMap::Magma, ColourMap::Viridis}) {
        double before = -1;
        for (int i = 0; i <= 64; ++i) {
            const auto c = colourOf(map, i / 64.0);
            const auto linear = [](double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); };
            const double lightness = std::cbrt(0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]));
            EXPECT_GT(lightness, before) << i;
            before = lightness;
        }
    }
    EXPECT_EQ(colourOf(ColourMap::BlueRed, 0.5)[0], colourOf(ColourMap::BlueRed, 0.5)[2]);
    EXPECT_EQ(colourOf(ColourMap::Viridis, 7), colourOf(ColourMap::Viridis, 1));
    EXPECT_EQ(colourMapNames().size(), 3u);
}

}  // namespace
}  // namespace photic
