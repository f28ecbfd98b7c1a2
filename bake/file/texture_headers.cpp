// SPDX-License-Identifier: Apache-2.0
#include "bake/file/texture_headers.h"

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

namespace photic {
namespace {

static_assert(std::endian::native == std::endian::little,
              "files are little-endian, and numbers are written as they lie in memory");

constexpr std::uint32_t kTexelBytes = 8;  // RGBA16F

template <class Number>
void add(std::string& bytes, Number number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

void padTo(std::string& bytes, std::size_t alignment) {
    while (bytes.size() % alignment != 0) bytes.push_back('\0');
}

template <class Number>
void put(std::string& bytes, std::size_t at, Number number) {
    bytes.replace(at, sizeof(number), reinterpret_cast<const char*>(&number), sizeof(number));
}

// The Khronos data format descriptor of four signed 16-bit floats that are no colours of any space.
std::string formatDescriptor() {
    struct Sample {
        std::uint16_t bit_offset;
        std::uint8_t channel;
    };
    constexpr std::array<Sample, 4> kSamples{{{0, 0}, {16, 1}, {32, 2}, {48, 15}}};  // red, green, blue, alpha
    constexpr std::uint8_t kFloatSigned = 0x80 | 0x40, kModelRgbsda = 1, kPrimariesUnspecified = 0, kTransferLinear = 1;
    constexpr std::uint16_t kBlockBytes = 24 + 16 * kSamples.size();
    std::string d;
    add<std::uint32_t>(d, 4 + kBlockBytes);
    add<std::uint32_t>(d, 0);  // vendor Khronos, basic descriptor block
    add<std::uint16_t>(d, 2);  // of version 1.3
    add<std::uint16_t>(d, kBlockBytes);
    for (const std::uint8_t byte : {kModelRgbsda, kPrimariesUnspecified, kTransferLinear, std::uint8_t{0}})
        add(d, byte);
    add<std::uint32_t>(d, 0);            // texel block of 1 x 1 x 1 x 1
    add<std::uint64_t>(d, kTexelBytes);  // bytes in plane 0, none in the others
    for (const Sample& sample : kSamples) {
        add(d, sample.bit_offset);
        add<std::uint8_t>(d, 15);  // bits less one
        add<std::uint8_t>(d, sample.channel | kFloatSigned);
        add<std::uint32_t>(d, 0);  // position in the block
        add(d, -1.0f);             // what the format's own limits -1 and 1 are
        add(d, 1.0f);
    }
    return d;
}

void addKeyValue(std::string& bytes, std::string_view key, std::string_view value) {
    add(bytes, static_cast<std::uint32_t>(key.size() + 1 + value.size() + 1));
    bytes.append(key).push_back('\0');
    bytes.append(value).push_back('\0');
    padTo(bytes, 4);
}

}  // namespace

// Khronos, KTX File Format Specification, version 2.0.
std::string ktx2Header(const glm::ivec3& size, const std::string& metadata) {
    constexpr std::uint32_t kR16G16B16A16Sfloat = 97;  // VkFormat
    constexpr std::size_t kIndex = 12 + 9 * 4, kLevels = kIndex + 4 * 4 + 2 * 8, kAfterLevels = kLevels + 3 * 8;
    std::string bytes("\xABKTX 20\xBB\r\n\x1A\n", 12);
    add(bytes, kR16G16B16A16Sfloat);
    add<std::uint32_t>(bytes, 2);  // bytes of the type
    for (int axis = 0; axis < 3; ++axis) add(bytes, static_cast<std::uint32_t>(size[axis]));
    for (const std::uint32_t n : {0u, 1u, 1u, 0u}) add(bytes, n);  // no array, one face, one level, no supercompression
    bytes.resize(kAfterLevels, '\0');

    const std::string descriptor = formatDescriptor();
    put(bytes, kIndex, static_cast<std::uint32_t>(bytes.size()));
    put(bytes, kIndex + 4, static_cast<std::uint32_t>(descriptor.size()));
    bytes += descriptor;

    // Sorted by key. Texels go right along +x, up along +y, out along +z.
    const std::size_t key_values = bytes.size();
    addKeyValue(bytes, "KTXorientation", "ruo");
    addKeyValue(bytes, "KTXwriter", "photic");
    addKeyValue(bytes, "photic", metadata);
    put(bytes, kIndex + 8, static_cast<std::uint32_t>(key_values));
    put(bytes, kIndex + 12, static_cast<std::uint32_t>(bytes.size() - key_values));

    padTo(bytes, kTexelBytes);
    const std::uint64_t level = std::uint64_t{kTexelBytes} * static_cast<std::uint64_t>(size.x) *
                                static_cast<std::uint64_t>(size.y) * static_cast<std::uint64_t>(size.z);
    put(bytes, kLevels, static_cast<std::uint64_t>(bytes.size()));
    put(bytes, kLevels + 8, level);
    put(bytes, kLevels + 16, level);
    return bytes;
}

// Microsoft, Programming Guide for DDS.
std::string ddsHeader(const glm::ivec3& size) {
    constexpr std::uint32_t kCaps = 0x1, kHeight = 0x2, kWidth = 0x4, kPitch = 0x8, kPixelFormat = 0x1000,
                            kDepth = 0x800000;
    constexpr std::uint32_t kFourCc = 0x4, kTexture = 0x1000, kComplex = 0x8, kVolume = 0x200000;
    constexpr std::uint32_t kR16G16B16A16Float = 10, kTexture3d = 4, kAlphaCustom = 4;  // alpha is no transparency
    std::string bytes("DDS ");
    add<std::uint32_t>(bytes, 124);
    add(bytes, kCaps | kHeight | kWidth | kPitch | kPixelFormat | kDepth);
    add(bytes, static_cast<std::uint32_t>(size.y));
    add(bytes, static_cast<std::uint32_t>(size.x));
    add(bytes, static_cast<std::uint32_t>(size.x) * kTexelBytes);  // bytes a row
    add(bytes, static_cast<std::uint32_t>(size.z));
    add<std::uint32_t>(bytes, 1);  // one level
    bytes.append(11 * 4, '\0');
    add<std::uint32_t>(bytes, 32);
    add(bytes, kFourCc);
    bytes += "DX10";
    bytes.append(5 * 4, '\0');
    add(bytes, kTexture | kComplex);
    add(bytes, kVolume);
    bytes.append(3 * 4, '\0');
    for (const std::uint32_t n : {kR16G16B16A16Float, kTexture3d, 0u, 1u, kAlphaCustom}) add(bytes, n);
    return bytes;
}

// github.com/peeweek/VectorFieldFile, version 1, the one that Unity imports.
std::string vfHeader(const glm::ivec3& size, char kind) {
    std::string bytes("VF_");
    bytes.push_back(kind);
    for (int axis = 0; axis < 3; ++axis) add(bytes, static_cast<std::uint16_t>(size[axis]));
    return bytes;
}

}  // namespace photic
