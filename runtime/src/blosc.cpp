// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/blosc.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

/// Continues a length of 15 by bytes that are added until one is below 255.
bool extendLength(ByteView packed, std::size_t& at, std::size_t& length) {
    unsigned char more = 255;
    while (more == 255) {
        if (at == packed.size()) return false;
        more = packed[at++];
        length += more;
    }
    return true;
}

/// Repeats what lies `offset` bytes back until `length` bytes are written; the two may overlap.
void repeat(unsigned char* out, std::size_t offset, std::size_t length) {
    const unsigned char* from = out - offset;
    // What is written has the period `offset`, so that each copy may be longer than the one before.
    for (std::size_t done = 0; done < length;) {
        const std::size_t count = std::min(offset + done, length - done);
        std::memcpy(out + done, from, count);
        done += count;
    }
}

template <class T>
T numberAt(ByteView bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

/// The header of a buffer, 16 bytes.
struct BloscHeader {
    static constexpr std::size_t kSize = 16;
    bool shuffled, plain, split;
    std::size_t type_size, unpacked, block_size, packed;
};

BloscHeader readHeader(ByteView packed, std::size_t unpacked, const std::string& what) {
    const auto refuse = [&](const std::string& why) {
        fail(ErrorCode::Format, what + ": " + why +
                                    "; the file is damaged, or packed as this library does not read: "
                                    "export it again, or use --codec none");
    };
    if (packed.size() < BloscHeader::kSize)
        refuse("a packed buffer of " + std::to_string(packed.size()) + " bytes has no header");
    const unsigned flags = packed[2];
    BloscHeader h{(flags & 1) != 0,
                  (flags & 2) != 0,
                  (flags & 16) == 0,
                  packed[3],
                  numberAt<std::uint32_t>(packed, 4),
                  numberAt<std::uint32_t>(packed, 8),
                  numberAt<std::uint32_t>(packed, 12)};
    constexpr unsigned kLz4 = 1;
    if (packed[0] != 2) refuse("a buffer is of Blosc's format " + std::to_string(packed[0]) + ", not 2");
    if (!h.plain && flags >> 5 != kLz4)
        refuse("a buffer is packed by compressor " + std::to_string(flags >> 5) + ", not by LZ4 (1)");
    if ((flags & 4) != 0) refuse("a buffer's bits are shuffled");
    if (h.unpacked != unpacked || h.packed != packed.size() || h.block_size == 0 || h.type_size == 0) {
        refuse("a buffer's sizes, " + std::to_string(h.packed) + " and " + std::to_string(h.unpacked) +
               " bytes in blocks of " + std::to_string(h.block_size) + ", are not those that were expected, " +
               std::to_string(packed.size()) + " and " + std::to_string(unpacked));
    }
    return h;
}

/// One block: streams, each behind its length, then the shuffle undone.
bool unpackBlock(ByteView packed, const BloscHeader& h, MutableBytes out, std::vector<unsigned char>& scratch) {
    // As c-blosc's blosc_d(): whole blocks are split into one stream for each byte of a value, where that is worth it.
    constexpr std::size_t kMostStreams = 16, kShortestStream = 128;
    const bool whole = out.size() == h.block_size;
    const bool split = h.split && whole && h.type_size <= kMostStreams && h.block_size / h.type_size >= kShortestStream;
    const std::size_t streams = split ? h.type_size : 1, length = out.size() / streams;
    const bool shuffled = h.shuffled && h.type_size > 1;
    if (length * streams != out.size()) return false;
    const MutableBytes to = shuffled ? MutableBytes(scratch).first(out.size()) : out;
    std::size_t at = 0;
    for (std::size_t s = 0; s < streams; ++s) {
        if (packed.size() - at < 4) return false;
        const auto count = static_cast<std::size_t>(numberAt<std::uint32_t>(packed, at));
        at += 4;
        if (packed.size() - at < count) return false;
        const MutableBytes part = to.subspan(s * length, length);
        const ByteView from = packed.subspan(at, count);
        if (count == length) {
            std::copy(from.begin(), from.end(), part.begin());
        } else if (!unpackLz4(from, part)) {
            return false;
        }
        at += count;
    }
    if (!shuffled) return true;
    const std::size_t values = out.size() / h.type_size, size = h.type_size;
    for (std::size_t j = 0; j < size; ++j) {
        const unsigned char* from = to.data() + j * values;
        unsigned char* put = out.data() + j;
        for (std::size_t i = 0; i < values; ++i) put[i * size] = from[i];
    }
    std::copy(to.begin() + static_cast<std::ptrdiff_t>(values * size), to.end(),
              out.begin() + static_cast<std::ptrdiff_t>(values * size));
    return true;
}

}  // namespace

bool unpackLz4(ByteView packed, MutableBytes out) {
    std::size_t at = 0, written = 0;
    while (at < packed.size()) {
        const unsigned token = packed[at++];
        std::size_t literals = token >> 4;
        if (literals == 15 && !extendLength(packed, at, literals)) return false;
        if (literals > packed.size() - at || literals > out.size() - written) return false;
        if (literals != 0) std::memcpy(out.data() + written, packed.data() + at, literals);
        at += literals, written += literals;
        if (at == packed.size()) break;  // the last sequence has no match
        if (packed.size() - at < 2) return false;
        const std::size_t offset = packed[at] | static_cast<std::size_t>(packed[at + 1]) << 8;
        at += 2;
        std::size_t length = token & 15;
        if (length == 15 && !extendLength(packed, at, length)) return false;
        length += 4;  // the shortest match
        if (offset == 0 || offset > written || length > out.size() - written) return false;
        repeat(out.data() + written, offset, length);
        written += length;
    }
    return written == out.size();
}

void unpackBlosc(ByteView packed, MutableBytes out, const std::string& what) {
    const BloscHeader h = readHeader(packed, out.size(), what);
    const auto damaged = [&](std::size_t block) {
        fail(ErrorCode::Format, what + ": block " + std::to_string(block) + " does not unpack; the file is damaged");
    };
    if (h.plain) {
        if (packed.size() != BloscHeader::kSize + out.size()) damaged(0);
        std::copy_n(packed.begin() + BloscHeader::kSize, out.size(), out.begin());
        return;
    }
    const std::size_t blocks = (out.size() + h.block_size - 1) / h.block_size;
    if (blocks > (packed.size() - BloscHeader::kSize) / 4) damaged(0);
    std::vector<unsigned char> scratch(std::min(h.block_size, out.size()));
    for (std::size_t b = 0; b < blocks; ++b) {
        const std::size_t start = numberAt<std::uint32_t>(packed, BloscHeader::kSize + 4 * b);
        const std::size_t first = b * h.block_size;
        if (start > packed.size()) damaged(b);
        // Where the block ends is not said; it must end before the buffer does.
        if (!unpackBlock(packed.subspan(start), h, out.subspan(first, std::min(h.block_size, out.size() - first)),
                         scratch))
            damaged(b);
    }
}

}  // namespace photic::runtime
