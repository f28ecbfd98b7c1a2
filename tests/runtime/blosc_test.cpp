// SPDX-License-Identifier: Apache-2.0
// Buffers that Blosc packs unpack to what they were; others are refused, and nothing beyond either end is touched.
#include "runtime/src/blosc.h"

#include <blosc.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

using Buffer = std::vector<unsigned char>;

/// Bytes of floats that vary slowly here, randomly there, and are zero elsewhere: all that a packer meets.
Buffer mixed(std::size_t size, unsigned seed) {
    Buffer out(size);
    std::mt19937 random(seed);
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t part = i / 3000 % 3;
        out[i] = static_cast<unsigned char>(part == 0 ? 0 : part == 1 ? i / 64 : random());
    }
    return out;
}

struct Packing {
    int level, shuffle, type_size;
    std::size_t block;
    const char* compressor = BLOSC_LZ4_COMPNAME;
};

Buffer pack(const Buffer& plain, const Packing& with) {
    Buffer out(plain.size() + BLOSC_MAX_OVERHEAD);
    const int size =
        blosc_compress_ctx(with.level, with.shuffle, static_cast<std::size_t>(with.type_size), plain.size(),
                           plain.data(), out.data(), out.size(), with.compressor, with.block, 1);
    EXPECT_GT(size, 0);
    out.resize(static_cast<std::size_t>(std::max(0, size)));
    return out;
}

/// Unpacks between blocks of just the sizes, so that a sanitizer sees the first byte beyond.
Buffer unpack(const Buffer& packed, std::size_t size) {
    const std::unique_ptr<unsigned char[]> from(new unsigned char[packed.size()]), to(new unsigned char[size]);
    std::copy(packed.begin(), packed.end(), from.get());
    unpackBlosc({from.get(), packed.size()}, {to.get(), size}, "the buffer");
    return {to.get(), to.get() + size};
}

TEST(Blosc, UnpacksWhatBloscPacks) {
    for (const std::size_t size : {1U, 3U, 15U, 127U, 4096U, 99999U, 700001U}) {
        for (const int level : {0, 1, 9}) {
            for (const int shuffle : {BLOSC_NOSHUFFLE, BLOSC_SHUFFLE}) {
                for (const int type_size : {1, 2, 4, 8, 17}) {
                    for (const std::size_t block : {0U, 1U << 12, 1U << 18}) {
                        const Buffer plain = mixed(size, 1);
                        ASSERT_EQ(unpack(pack(plain, {level, shuffle, type_size, block}), size), plain)
                            << size << " bytes, level " << level << ", shuffle " << shuffle << ", of " << type_size;
                    }
                }
            }
        }
    }
}

TEST(Blosc, OtherKindsAreRefused) {
    const Buffer plain = mixed(50000, 2);
    EXPECT_THROW(unpack(pack(plain, {9, BLOSC_BITSHUFFLE, 4, 1 << 18}), plain.size()), Failure);
    EXPECT_THROW(unpack(pack(plain, {9, BLOSC_SHUFFLE, 4, 1 << 18, BLOSC_BLOSCLZ_COMPNAME}), plain.size()), Failure);
    const Buffer packed = pack(plain, {9, BLOSC_SHUFFLE, 4, 1 << 18});
    EXPECT_THROW(unpack(packed, plain.size() - 1), Failure);
    EXPECT_THROW(unpack(packed, plain.size() + 1), Failure);
    EXPECT_THROW(unpack({}, 0), Failure);
}

TEST(Blosc, DamagedBuffersDoNoHarm) {
    const Buffer plain = mixed(20000, 3), packed = pack(plain, {9, BLOSC_SHUFFLE, 4, 1 << 12});
    for (std::size_t size = 0; size < packed.size(); ++size)
        EXPECT_THROW(unpack({packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size)}, plain.size()),
                     Failure);
    std::mt19937 random(4);
    int refused = 0;
    for (int n = 0; n < 5000; ++n) {
        Buffer damaged = packed;
        for (unsigned i = 0; i < 1 + n % 3U; ++i)
            damaged[random() % damaged.size()] = static_cast<unsigned char>(random() % 4 == 0 ? 255 : random());
        try {
            unpack(damaged, plain.size());
        } catch (const Failure&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 500);
}

TEST(Lz4, SequencesByHand) {
    const auto unpacked = [](Buffer packed, std::size_t size) {
        Buffer out(size);
        EXPECT_TRUE(unpackLz4(packed, out));
        return out;
    };
    // Five literals.
    EXPECT_EQ(unpacked({0x50, 'h', 'e', 'l', 'l', 'o'}, 5), (Buffer{'h', 'e', 'l', 'l', 'o'}));
    // Two literals, then six bytes from two back (an overlap), then one literal.
    EXPECT_EQ(unpacked({0x22, 'a', 'b', 2, 0, 0x10, 'c'}, 9), (Buffer{'a', 'b', 'a', 'b', 'a', 'b', 'a', 'b', 'c'}));
    // Lengths of 15 and more go on in further bytes: one literal, 4 + 15 + 255 + 2 of it again.
    EXPECT_EQ(unpacked({0x1f, 7, 1, 0, 255, 2, 0x00}, 277), Buffer(277, 7));
    Buffer out(9);
    for (const Buffer& bad : {Buffer{0x22, 'a', 'b', 3, 0, 0x10, 'c'},  // from before the beginning
                              Buffer{0x22, 'a', 'b', 0, 0, 0x10, 'c'},  // from nowhere
                              Buffer{0x23, 'a', 'b', 2, 0, 0x10, 'c'},  // one byte too many
                              Buffer{0x21, 'a', 'b', 2, 0, 0x10, 'c'},  // one too few
                              Buffer{0xf0, 255, 255}, Buffer{0x22, 'a', 'b', 2}, Buffer{}}) {
        EXPECT_FALSE(unpackLz4(bad, out));
    }
}

}  // namespace
}  // namespace photic::runtime
