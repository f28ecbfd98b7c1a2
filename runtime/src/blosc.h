// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace photic::runtime {

using ByteView = std::span<const unsigned char>;
using MutableBytes = std::span<unsigned char>;

/// Unpacks one block of LZ4 (the block format of lz4_Block_format.md, without a frame).
/// @return whether it was sound and filled `out` to its last byte; `out` may hold anything otherwise
bool unpackLz4(ByteView packed, MutableBytes out);

/// Unpacks one buffer of Blosc 1 (c-blosc 1.x, README_CHUNK_FORMAT.rst), packed by LZ4, with bytes shuffled or not.
/// @param what  names the buffer in errors
/// @throws Failure{Format} unless the buffer is sound and unpacks to just `out`
void unpackBlosc(ByteView packed, MutableBytes out, const std::string& what);

}  // namespace photic::runtime
