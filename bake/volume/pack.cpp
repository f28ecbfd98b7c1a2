// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/pack.h"

#include <blosc.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "bake/volume/byte_cursor.h"

namespace photic {

std::size_t mostPackedBytes(std::size_t size) {
    return sizeof(std::int64_t) + std::max<std::size_t>(compressBound(size), size + BLOSC_MAX_OVERHEAD);
}

std::size_t packBytes(std::uint32_t compression, const char* from, std::size_t size, char* to) {
    if (!(compression & (kPackedBlosc | kPackedZip))) {
        if (size > 0) std::memcpy(to, from, size);
        return size;
    }
    char* behind = to + sizeof(std::int64_t);
    std::int64_t packed = 0;
    if (compression & kPackedBlosc) {
        // OpenVDB's choice: LZ4 of shuffled words of four bytes, in one block.
        packed = blosc_compress_ctx(9, 1, sizeof(float), size, from, behind, size + BLOSC_MAX_OVERHEAD, "lz4", size, 1);
    } else {
        uLongf bytes = compressBound(size);
        const bool done = compress2(reinterpret_cast<Bytef*>(behind), &bytes, reinterpret_cast<const Bytef*>(from),
                                    size, Z_DEFAULT_COMPRESSION) == Z_OK;
        packed = done && bytes < size ? static_cast<std::int64_t>(bytes) : 0;
    }
    if (packed <= 0) {
        packed = -static_cast<std::int64_t>(size);
        if (size > 0) std::memcpy(behind, from, size);
    }
    std::memcpy(to, &packed, sizeof(packed));
    return sizeof(packed) + static_cast<std::size_t>(packed > 0 ? packed : -packed);
}

void unpackBytes(std::uint32_t compression, const char* from, std::size_t packed, char* to, std::size_t size) {
    bool whole = false;
    if (compression & kPackedBlosc) {
        // Blosc reads as many bytes as its own header says, whatever there are: the
        // two must agree first.
        std::size_t unpacked = 0;
        whole = blosc_cbuffer_validate(from, packed, &unpacked) == 0 && unpacked == size &&
                blosc_decompress_ctx(from, to, size, 1) == static_cast<int>(size);
    } else {
        uLongf unpacked = size;
        whole =
            uncompress(reinterpret_cast<Bytef*>(to), &unpacked, reinterpret_cast<const Bytef*>(from), packed) == Z_OK &&
            unpacked == size;
    }
    if (!whole)
        throw VolumeFault(
            "it is damaged: what is packed in it does not unpack; "
            "write or copy it again");
}

}  // namespace photic
