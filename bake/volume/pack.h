// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace photic {

/// How the values of a node are packed (OpenVDB's compression flags).
inline constexpr std::uint32_t kPackedZip = 1, kPackedActive = 2, kPackedBlosc = 4;

/// How a node says which of its values are stored: all, or the active ones, the
/// others being the background.
inline constexpr char kAllValues = 6, kInactiveAreBackground = 0;

/// The most bytes that packBytes() writes for so many.
std::size_t mostPackedBytes(std::size_t size);
/// Writes bytes behind their packed size, or, where packing does not shorten
/// them or nothing is packed, as they are.
/// @return bytes written
std::size_t packBytes(std::uint32_t compression, const char* from, std::size_t size, char* to);

/// Unpacks `packed` bytes into exactly `size` others. @throws VolumeFault when
/// they are not that
void unpackBytes(std::uint32_t compression, const char* from, std::size_t packed, char* to, std::size_t size);

}  // namespace photic
