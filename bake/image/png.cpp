// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>

#include "bake/image/atomic_file.h"
#include "bake/image/height_flaws.h"
#include "bake/image/image.h"
#include "bake/report/error.h"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace photic {
namespace {

/// What the decoder says of a failure; it does not always say.
const char* reason() {
    const char* words = stbi_failure_reason();
    return words ? words : "its pixels cannot be decoded";
}

std::uint32_t bigEndian(std::string_view bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

/// The checksum of a chunk's type and data (ISO 3309), which the decoder does not look at.
std::uint32_t checksum(std::string_view bytes) {
    static const auto table = [] {
        std::array<std::uint32_t, 256> out{};
        for (std::uint32_t i = 0; i < 256; ++i) {
            out[i] = i;
            for (int k = 0; k < 8; ++k) out[i] = out[i] & 1 ? 0xedb88320u ^ (out[i] >> 1) : out[i] >> 1;
        }
        return out;
    }();
    std::uint32_t crc = 0xffffffffu;
    for (const char c : bytes) crc = table[(crc ^ static_cast<unsigned char>(c)) & 255] ^ (crc >> 8);
    return ~crc;
}

/// Why the chunks of a PNG cannot be those that were written, or "".
std::string damageOf(std::string_view bytes) {
    for (std::size_t at = 8; at < bytes.size();) {
        if (bytes.size() - at < 12) return "it ends within a chunk";
        const std::size_t size = bigEndian(bytes.substr(at));
        if (size > bytes.size() - at - 12) return "it ends within a chunk";
        const std::string_view body = bytes.substr(at + 4, size + 4);
        if (checksum(body) != bigEndian(bytes.substr(at + 8 + size)))
            return fmt::format("the checksum of its chunk at byte {} does not fit", at);
        if (body == "IEND") return "";
        at += size + 12;
    }
    return "it has no end";
}

/// Without chunks of pixels that hold none, which a PNG may have and the decoder copies from nowhere.
std::string withoutEmptyChunks(std::string_view bytes) {
    std::string out(bytes.substr(0, 8));
    for (std::size_t at = 8; at < bytes.size();) {
        const std::string_view chunk = bytes.substr(at, bigEndian(bytes.substr(at)) + std::size_t{12});
        if (chunk.size() > 12 || chunk.substr(4, 4) != "IDAT") out += chunk;
        if (chunk.substr(4, 4) == "IEND") break;
        at += chunk.size();
    }
    return out;
}

/// Collects what the encoder emits.
void append(void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

}  // namespace

HeightMap readPng16(const std::string& path) {
    const std::string bytes = readFileBytes(path);
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw Error(ErrorCode::Input, fmt::format("'{}' has {} bytes; a PNG may have up to 2 GiB", path, bytes.size()));
    const int size = static_cast<int>(bytes.size());

    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(data, size, &width, &height, &channels))
        throw Error(ErrorCode::Input, fmt::format("'{}' is not a PNG, or is truncated: {}", path, reason()));
    if (!stbi_is_16_bit_from_memory(data, size))
        throw Error(
            ErrorCode::Input,
            fmt::format("'{}' is an 8-bit PNG: its 256 steps of height would be seen as caustics (slopes are off by "
                        "about 11 %); save 16 bits, or better a float EXR",
                        path));
    if (channels != 1)
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' has {} channels; a height map in PNG is grey, without alpha", path, channels));
    if (width > kLargestSide || height > kLargestSide || std::int64_t{width} * height > kMostPixels)
        throw Error(ErrorCode::Input, fmt::format("'{}' is {} x {} pixels; the limit is {} a side and {} in all", path,
                                                  width, height, kLargestSide, kMostPixels));
    if (const std::string damage = damageOf(bytes); !damage.empty())
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or truncated ({} bytes): {}",
                                                  path, bytes.size(), damage));

    const std::string full = withoutEmptyChunks(bytes);
    const std::unique_ptr<stbi_us, void (*)(void*)> pixels(
        stbi_load_16_from_memory(reinterpret_cast<const stbi_uc*>(full.data()), static_cast<int>(full.size()), &width,
                                 &height, &channels, 1),
        stbi_image_free);
    if (!pixels)
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or truncated ({} bytes): {}",
                                                  path, bytes.size(), reason()));
    HeightMap map;
    map.width = width, map.height = height;
    map.values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < map.values.size(); ++i) map.values[i] = static_cast<float>(pixels.get()[i] / 65535.0);
    noteEightBits(map);
    return map;
}

void writePng(const std::string& path, const Image& image) { writeFileAtomically(path, encodePng(path, image)); }

std::string encodePng(const std::string& path, const Image& image) {
    std::vector<stbi_uc> quantised(image.pixels.size());
    for (std::size_t i = 0; i < quantised.size(); ++i) {
        const float v = image.pixels[i];
        quantised[i] = static_cast<stbi_uc>(v > 0.0f ? std::lround(std::min(v, 1.0f) * 255.0f) : 0);  // NaN is black
    }
    std::string bytes;
    if (!stbi_write_png_to_func(append, &bytes, image.width, image.height, image.channels, quantised.data(),
                                image.width * image.channels))
        throw Error(ErrorCode::Failed, fmt::format("cannot encode '{}': {} x {} pixels of {} channels", path,
                                                   image.width, image.height, image.channels));
    return bytes;
}

}  // namespace photic
