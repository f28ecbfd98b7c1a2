// SPDX-License-Identifier: Apache-2.0
#include "bake/web/packed_array.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace photic::test {
namespace {

std::vector<unsigned char> fromBase64(const std::string& text) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<unsigned char> bytes;
    unsigned held = 0, bits = 0;
    for (const char letter : text) {
        if (letter == '=') break;
        held = held << 6 | static_cast<unsigned>(letters.find(letter));
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<unsigned char>(held >> bits));
    }
    return bytes;
}

std::vector<unsigned char> gunzipped(std::vector<unsigned char> packed, std::size_t size) {
    std::vector<unsigned char> bytes(size + 1);
    z_stream stream{};
    stream.next_in = packed.data(), stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = bytes.data(), stream.avail_out = static_cast<uInt>(bytes.size());
    EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
    bytes.resize(stream.total_out);
    inflateEnd(&stream);
    return bytes;
}

TEST(PackedArray, HoldsTheBytesOfARankTogether) {
    for (const std::size_t count : {0u, 1u, 2u, 3u, 70000u}) {
        std::vector<std::uint32_t> numbers(count);
        for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<std::uint32_t>(2654435761u * i);
        const std::string text = packedArray(numbers);
        EXPECT_EQ(text.size() % 4, 0u);
        const auto planes = gunzipped(fromBase64(text), 4 * count);
        ASSERT_EQ(planes.size(), 4 * count);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint32_t number = 0;
            for (std::size_t plane = 0; plane < 4; ++plane)
                number |= static_cast<std::uint32_t>(planes[plane * count + i]) << 8 * plane;
            ASSERT_EQ(number, numbers[i]) << i;
        }
    }
}

TEST(PackedArray, TakesLessForSmoothHalves) {
    // Halves of a slow ramp: the upper bytes hardly change, the lower ones seem random.
    std::vector<std::uint16_t> numbers(60000);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<std::uint16_t>(0x3c00 + i / 60 + (i * 2654435761u >> 29));
    EXPECT_LT(packedArray(numbers).size(), numbers.size() * 2 * 2 / 3);
}

}  // namespace
}  // namespace photic::test
