// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace photic {

/// Row-major float image, top row first, channels interleaved.
struct Image {
    int width = 0, height = 0, channels = 0;
    std::vector<float> pixels;
    float& at(int x, int y, int c) { return pixels[(static_cast<std::size_t>(y) * width + x) * channels + c]; }
    float at(int x, int y, int c) const { return pixels[(static_cast<std::size_t>(y) * width + x) * channels + c]; }
};

enum class ChannelDepth { Half, Float, Uint32 };

/// One channel of a height map, as stored (no scale), with the precision that it was stored in.
struct HeightMap {
    int width = 0, height = 0;
    std::vector<float> values;  ///< row-major, top row first
    bool half = false;          ///< stored as half floats: slopes lose 0.3 %, curvature 3 % or far more with an offset
    /// What else storing it has cost, and what would do, each to follow the file's name: "is compressed with loss ...".
    std::vector<std::string> flaws{};
};

inline constexpr int kLargestSide = 32768;                          ///< [pixels] of an image that is read
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;  ///< of one

/// Reads named channels ("R", "G", "Z", "Y" ...) of an EXR; all have the display window's size, and are 0 where the
/// data window does not reach. Of several parts, the one that holds all of the channels.
/// @throws Error{Input} when missing, truncated, not an EXR, too large (kLargestSide, kMostPixels), deep, when the data
/// window lies outside the display window, when a channel is absent (lists those present) or subsampled, or when
/// several parts hold them
std::vector<HeightMap> readExrChannels(const std::string& path, const std::vector<std::string>& channels);

/// Names of the channels of all parts of an EXR, sorted.
std::vector<std::string> exrChannelNames(const std::string& path);

/// Reads a 16-bit grey PNG as 0..1.
/// @throws Error{Input} for any damage (chunks' checksums are looked at) and by name for 8 bits, colour or alpha, and
/// for what is too large (kLargestSide, kMostPixels)
HeightMap readPng16(const std::string& path);

/// Writes `image` (1, 3 or 4 channels: Y, RGB, RGBA) as EXR, to a temporary name, then renamed.
/// @throws Error{Failed}
void writeExr(const std::string& path, const Image& image, ChannelDepth depth = ChannelDepth::Float);
/// The bytes of that file; `path` is for messages.
std::string encodeExr(const std::string& path, const Image& image, ChannelDepth depth = ChannelDepth::Float);

/// Reads an EXR (Y, RGB or RGBA), as readExrChannels() does.
Image readExr(const std::string& path);

/// Writes 8-bit PNG from values that are already display-referred 0..1 (clamped), to a temporary name, then renamed.
void writePng(const std::string& path, const Image& image);
/// The bytes of that file; `path` is for messages.
std::string encodePng(const std::string& path, const Image& image);

}  // namespace photic
