// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
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

/// Writes floats 1, 2, 3 ... as the channel `name` over a data window, with `compression`.
void writeWindow(const std::string& path, const Imath::Box2i& display, const Imath::Box2i& data,
                 const std::string& name = "height", Imf::Compression compression = Imf::ZIP_COMPRESSION) {
    const auto count = static_cast<std::size_t>(data.size().x + 1) * static_cast<std::size_t>(data.size().y + 1);
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i + 1);
    Imf::Header header(display, data);
    header.compression() = compression;
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    Imf::FrameBuffer buffer;
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), data));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(data.size().y + 1);
}

TEST_F(ImageTest, DataLiesWhereItsWindowSays) {
    // A window away from the origin, all of it data: its top row comes first.
    writeWindow(path("w.exr"), {{-7, 40}, {-5, 41}}, {{-7, 40}, {-5, 41}});
    HeightMap map = readExrChannels(path("w.exr"), {"height"})[0];
    EXPECT_EQ(map.width, 3);
    EXPECT_EQ(map.values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
    EXPECT_TRUE(map.flaws.empty());
    expectError(ErrorCode::Input, {"w.exr", "neither", "height"}, [&] { readExr(path("w.exr")); });

    // Cropped to its middle: 0 around it.
    writeWindow(path("w.exr"), {{0, 0}, {4, 3}}, {{1, 1}, {3, 2}});
    map = readExrChannels(path("w.exr"), {"height"})[0];
    EXPECT_EQ(map.width, 5);
    EXPECT_EQ(map.values, (std::vector<float>{0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 4, 5, 6, 0, 0, 0, 0, 0, 0}));
    ASSERT_EQ(map.flaws.size(), 1u);
    EXPECT_NE(map.flaws[0].find("30 % of its display window of 5 x 4 pixels; the rest is 0"), std::string::npos);

    // Wider than what is shown, and beside it.
    writeWindow(path("w.exr"), {{1, 0}, {2, 1}}, {{0, 0}, {2, 1}}, "Y");
    map = readExrChannels(path("w.exr"), {"Y"})[0];
    EXPECT_EQ(map.values, (std::vector<float>{2, 3, 5, 6}));
    EXPECT_EQ(readExr(path("w.exr")).pixels, map.values);
    ASSERT_EQ(map.flaws.size(), 1u);
    EXPECT_NE(map.flaws[0].find("33.3 % of its data outside"), std::string::npos) << map.flaws[0];
    writeWindow(path("w.exr"), {{0, 0}, {99, 99}}, {{-7, 40}, {-5, 41}});
    expectError(ErrorCode::Input, {"w.exr", "(-7, 40) to (-5, 41)", "without cropping"},
                [&] { readExrChannels(path("w.exr"), {"height"}); });
}

/// Writes heights without a pattern as the channel `name`, of floats or of halves.
/// @return the heights as they were before they were compressed
std::vector<float> writeRough(const std::string& path, const std::string& name, bool half,
                              Imf::Compression compression) {
    constexpr int kSide = 32;
    std::vector<float> values(kSide * kSide);
    std::vector<Imath::half> halves;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto k = static_cast<double>(i);
        values[i] = static_cast<float>(0.3 + 0.2 * std::sin(k * k));
        halves.emplace_back(values[i]);
        if (half) values[i] = halves.back();
    }
    Imf::Header header(kSide, kSide);
    header.compression() = compression;
    const Imf::PixelType type = half ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(name, Imf::Channel(type));
    Imf::FrameBuffer buffer;
    void* data = half ? static_cast<void*>(halves.data()) : values.data();
    buffer.insert(name, Imf::Slice::Make(type, data, header.dataWindow()));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(kSide);
    return values;
}

// Whether a compression loses anything depends on the channel's type and name too: what is said of it must be so.
TEST_F(ImageTest, CompressionWithLossIsNamedWhereItLost) {
    int lossy = 0;
    for (const auto& [compression, name] :
         std::vector<std::pair<Imf::Compression, std::string>>{{Imf::NO_COMPRESSION, "NONE"},
                                                               {Imf::RLE_COMPRESSION, "RLE"},
                                                               {Imf::ZIPS_COMPRESSION, "ZIPS"},
                                                               {Imf::ZIP_COMPRESSION, "ZIP"},
                                                               {Imf::PIZ_COMPRESSION, "PIZ"},
                                                               {Imf::PXR24_COMPRESSION, "PXR24"},
                                                               {Imf::B44_COMPRESSION, "B44"},
                                                               {Imf::B44A_COMPRESSION, "B44A"},
                                                               {Imf::DWAA_COMPRESSION, "DWAA"},
                                                               {Imf::DWAB_COMPRESSION, "DWAB"}})
        for (const bool half : {false, true})
            for (const std::string channel : {"Y", "height", "sea.R", "Z"}) {
                const std::vector<float> written = writeRough(path("c.exr"), channel, half, compression);
                const HeightMap map = readExrChannels(path("c.exr"), {channel})[0];
                const bool lost = map.values != written;
                // DWA of half floats may lose nothing of heights as rough as these.
                const bool may_lose = half && name.starts_with("DWA") && (channel == "Y" || channel == "sea.R");
                ASSERT_EQ(map.flaws.size(), lost || may_lose ? 1u : 0u)
                    << name << ' ' << channel << (half ? " half" : " float");
                lossy += lost && !may_lose;
                if (lost) {
                    EXPECT_NE(map.flaws[0].find("(" + name + ")"), std::string::npos) << map.flaws[0];
                }
            }
    EXPECT_EQ(lossy, 4 + 2 * 4 + 2 * 2);  // PXR24 of floats, B44 of halves, DWA of floats of two names
}

// Files that are not what their names say: often met, and each with its own remedy.
TEST_F(ImageTest, WhatStandsInForAFileIsNamed) {
    const std::vector<std::pair<std::string, std::string>> stand_ins{
        {"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "git lfs pull"},
        {"/annex/objects/SHA256E-s12345--4d7a.exr\n", "git annex get"},
        {std::string("\x1f\x8b\x08\0\0\0", 6), "packed with gzip"},
        {"\x28\xb5\x2f\xfd....", "Zstandard"},
        {"PK\x03\x04....", "ZIP archive"},
        {"\r\n<!DOCTYPE HTML><html>404 Not Found</html>", "web page"},
        {"<html><head>", "web page"}};
    for (const auto& [bytes, word] : stand_ins) {
        write("sea.exr", bytes);
        expectError(ErrorCode::Input, {"sea.exr", word}, [&] { readExrChannels(path("sea.exr"), {"Y"}); });
        expectError(ErrorCode::Input, {"sea.exr", word}, [&] { readPng16(path("sea.exr")); });
    }
    for (const std::string plain : {"", "v", "version = 1\n", "# <html>\n", "PK"}) {
        write("plain", plain);
        EXPECT_EQ(readFileBytes(path("plain")), plain);
    }
}

TEST_F(ImageTest, OfSeveralPartsTheOneWithTheChannelIsRead) {
    const auto writeParts = [&](const std::vector<std::string>& channels) {
        std::vector<Imf::Header> headers;
        for (std::size_t p = 0; p < channels.size(); ++p) {
            Imf::Header header(2, 2);
            header.setName("part" + std::to_string(p)), header.setType(Imf::SCANLINEIMAGE);
            header.channels().insert(channels[p], Imf::Channel(Imf::FLOAT));
            headers.push_back(header);
        }
        Imf::MultiPartOutputFile file(path("p.exr").c_str(), headers.data(), static_cast<int>(headers.size()));
        for (std::size_t p = 0; p < channels.size(); ++p) {
            const std::vector<float> values(4, static_cast<float>(p + 1));
            Imf::FrameBuffer buffer;
            buffer.insert(channels[p], Imf::Slice::Make(Imf::FLOAT, values.data(), headers[p].dataWindow()));
            Imf::OutputPart part(file, static_cast<int>(p));
            part.setFrameBuffer(buffer);
            part.writePixels(2);
        }
    };
    writeParts({"mask", "Y"});
    EXPECT_EQ(exrChannelNames(path("p.exr")), (std::vector<std::string>{"Y", "mask"}));
    EXPECT_EQ(readExrChannels(path("p.exr"), {"Y"})[0].values, std::vector<float>(4, 2.0f));
    EXPECT_EQ(readExrChannels(path("p.exr"), {"mask"})[0].values, std::vector<float>(4, 1.0f));
    EXPECT_EQ(readExr(path("p.exr")).pixels, std::vector<float>(4, 2.0f));
    expectError(ErrorCode::Input, {"no part with the channel 'Z'", "'part0' (mask), 'part1' (Y)"},
                [&] { readExrChannels(path("p.exr"), {"Z"}); });
    writeParts({"Y", "Y"});
    expectError(ErrorCode::Input, {"2 parts", "channel 'Y'", "'part0' (Y), 'part1' (Y)"},
                [&] { readExrChannels(path("p.exr"), {"Y"}); });
}

TEST_F(ImageTest, DeepDataIsRefusedByName) {
    Imf::Header header(2, 2);
    header.setType(Imf::DEEPSCANLINE), header.compression() = Imf::ZIPS_COMPRESSION;
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    { Imf::DeepScanLineOutputFile file(path("d.exr").c_str(), header); }
    expectError(ErrorCode::Input, {"d.exr", "deep data", "flatten"}, [&] { readExrChannels(path("d.exr"), {"Y"}); });
}

TEST_F(ImageTest, EightBitsInALargerTypeAreNoticed) {
    Image image{16, 16, 1, std::vector<float>(256)};
    for (int i = 0; i < 256; ++i)
        image.pixels[static_cast<std::size_t>(i)] = static_cast<float>((i * 7) % 256) / 255.0f;
    writeExr(path("e.exr"), image);
    HeightMap map = readExrChannels(path("e.exr"), {"Y"})[0];
    ASSERT_EQ(map.flaws.size(), 1u);
    EXPECT_NE(map.flaws[0].find("256 heights of a picture of 8 bits"), std::string::npos);
    EXPECT_NE(map.flaws[0].find("off by about 11 %"), std::string::npos) << map.flaws[0];
    image.pixels[9] += 1e-4f;
    writeExr(path("e.exr"), image);
    EXPECT_TRUE(readExrChannels(path("e.exr"), {"Y"})[0].flaws.empty());
    writeExr(path("e.exr"), Image{16, 16, 1, std::vector<float>(256, 0.2f)});  // flat water
    EXPECT_TRUE(readExrChannels(path("e.exr"), {"Y"})[0].flaws.empty());
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
    Imf::Header large(30000, 30000);
    large.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    { Imf::OutputFile file(path("large.exr").c_str(), large); }
    expectError(ErrorCode::Input, {"30000 x 30000", "268435456 in all"}, [&] { readExr(path("large.exr")); });
}

/// A PNG of one row of 16-bit grey with stored (uncompressed) data; stb writes 8 bits only.
std::string png16(const std::vector<std::uint16_t>& values) {
    const auto big_endian = [](std::size_t v) {
        return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                           static_cast<char>(v)};
    };
    const auto chunk = [&](const std::string& type, const std::string& data) {
        std::uint32_t crc = 0xffffffffu;
        for (const char c : type + data) {
            crc ^= static_cast<unsigned char>(c);
            for (int k = 0; k < 8; ++k) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
        }
        return big_endian(data.size()) + type + data + big_endian(~crc);
    };
    std::string row(1, '\0');
    for (const std::uint16_t v : values) row += static_cast<char>(v >> 8), row += static_cast<char>(v);
    std::uint32_t a = 1, b = 0;
    for (const char c : row) a = (a + static_cast<unsigned char>(c)) % 65521, b = (b + a) % 65521;
    const auto length = static_cast<std::uint16_t>(row.size());
    const std::string stored{'\x78',
                             '\x01',
                             '\x01',
                             static_cast<char>(length),
                             static_cast<char>(length >> 8),
                             static_cast<char>(~length),
                             static_cast<char>(~length >> 8)};
    return std::string("\x89PNG\r\n\x1a\n") +
           chunk("IHDR", big_endian(values.size()) + std::string("\0\0\0\x01\x10\0\0\0\0", 9)) +
           chunk("IDAT", stored + row + big_endian(b << 16 | a)) + chunk("IEND", "");
}

TEST_F(ImageTest, Png16ReadsGrey) {
    const std::string png = png16({0x8000, 0xffff});
    write("g.png", png);
    const HeightMap map = readPng16(path("g.png"));
    ASSERT_EQ(map.values.size(), 2u);
    EXPECT_FLOAT_EQ(map.values[0], 32768.0f / 65535.0f);
    EXPECT_FLOAT_EQ(map.values[1], 1.0f);

    // Some programs begin or end the pixels with a chunk that holds none.
    std::string spaced = png;
    spaced.insert(png.find("IDAT") - 4, std::string("\0\0\0\0IDAT\x35\xaf\x06\x1e", 12));
    write("spaced.png", spaced);
    EXPECT_EQ(readPng16(path("spaced.png")).values, map.values);

    for (std::size_t length = 0; length < png.size(); ++length) {
        write("cut.png", png.substr(0, length));
        expectError(ErrorCode::Input, {"cut.png"}, [&] { readPng16(path("cut.png")); });
    }
    // Any byte that is another, too.
    for (std::size_t i = 0; i < png.size(); ++i) {
        std::string damaged = png;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        write("bad.png", damaged);
        expectError(ErrorCode::Input, {"bad.png"}, [&] { readPng16(path("bad.png")); });
    }
}

TEST_F(ImageTest, EightBitsStretchedToSixteenAreNoticed) {
    std::vector<std::uint16_t> stretched, shifted, whole;
    for (unsigned v = 3; v < 200; v += 7)
        stretched.push_back(static_cast<std::uint16_t>(257 * v)),
            shifted.push_back(static_cast<std::uint16_t>(256 * v)),
            whole.push_back(static_cast<std::uint16_t>(257 * v + v % 3));
    for (const auto& [values, flaws] : {std::pair{stretched, 1u}, std::pair{shifted, 1u}, std::pair{whole, 0u},
                                        std::pair{std::vector<std::uint16_t>(8, 514), 0u}}) {
        write("s.png", png16(values));
        EXPECT_EQ(readPng16(path("s.png")).flaws.size(), flaws);
    }
}

// Cameras and terrain programs have 10 and 12 bits: less of a step, and a step all the same.
TEST_F(ImageTest, TenAndTwelveBitsAreNoticedToo) {
    for (const int bits : {10, 12, 13}) {
        std::vector<std::uint16_t> stretched, shifted;
        for (unsigned v = 1; v < 1u << bits; v += 37)
            stretched.push_back(static_cast<std::uint16_t>(std::lround(v * 65535.0 / ((1 << bits) - 1)))),
                shifted.push_back(static_cast<std::uint16_t>(v << (16 - bits)));
        Image exact{static_cast<int>(stretched.size()), 1, 1, {}};
        for (unsigned v = 1; v < 1u << bits; v += 37)
            exact.pixels.push_back(static_cast<float>(v) / static_cast<float>((1 << bits) - 1));
        write("shifted.png", png16(shifted));
        writeExr(path("stretched.exr"), exact);
        for (const auto& flaws :
             {readPng16(path("shifted.png")).flaws, readExrChannels(path("stretched.exr"), {"Y"})[0].flaws}) {
            ASSERT_EQ(flaws.size(), bits == 13 ? 0u : 1u) << bits;
            if (bits == 13) continue;
            EXPECT_NE(flaws[0].find(std::to_string(1 << bits) + " heights"), std::string::npos) << flaws[0];
            EXPECT_NE(flaws[0].find(bits == 10 ? "about 3 %" : "about 0.7 %"), std::string::npos) << flaws[0];
        }
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
