// SPDX-License-Identifier: Apache-2.0
#include "bake/web/packed_array.h"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <vector>

namespace photic {
namespace {

std::vector<unsigned char> gzipped(const std::vector<unsigned char>& bytes) {
    constexpr int kGzip = 15 + 16;  // the largest window, and gzip's header instead of zlib's
    constexpr int kMemory = 9;
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    std::vector<unsigned char> out;
    std::vector<unsigned char> piece(1 << 16);
    // zlib counts in 32 bits: hand the bytes over in pieces.
    constexpr std::size_t kMost = 1 << 30;
    std::size_t given = 0;
    int state = Z_OK;
    while (state != Z_STREAM_END) {
        if (stream.avail_in == 0 && given < bytes.size()) {
            const std::size_t count = std::min(kMost, bytes.size() - given);
            stream.next_in = const_cast<unsigned char*>(bytes.data() + given);
            stream.avail_in = static_cast<uInt>(count);
            given += count;
        }
        stream.next_out = piece.data();
        stream.avail_out = static_cast<uInt>(piece.size());
        state = deflate(&stream, given == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
        out.insert(out.end(), piece.data(), piece.data() + (piece.size() - stream.avail_out));
    }
    deflateEnd(&stream);
    return out;
}

std::string base64(const std::vector<unsigned char>& bytes) {
    constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? unsigned{bytes[i + k]} : 0u; };
        const unsigned three = byte(0) << 16 | byte(1) << 8 | byte(2);
        text += kLetters[three >> 18];
        text += kLetters[three >> 12 & 63];
        text += i + 1 < bytes.size() ? kLetters[three >> 6 & 63] : '=';
        text += i + 2 < bytes.size() ? kLetters[three & 63] : '=';
    }
    return text;
}

}  // namespace

std::string packedArray(std::span<const std::byte> bytes, std::size_t bytes_a_number) {
    const std::size_t count = bytes.size() / bytes_a_number;
    std::vector<unsigned char> planes(bytes.size());
    for (std::size_t plane = 0; plane < bytes_a_number; ++plane)
        for (std::size_t i = 0; i < count; ++i)
            planes[plane * count + i] = static_cast<unsigned char>(bytes[i * bytes_a_number + plane]);
    return base64(gzipped(planes));
}

}  // namespace photic
