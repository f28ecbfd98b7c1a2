// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "runtime/src/guarded.h"
#include "runtime/src/volume_data.h"

namespace photic::runtime {
namespace {

[[noreturn]] void damaged() { fail(ErrorCode::Format, "the metadata's 'coarse_blocks' is no list of blocks"); }

unsigned digitOf(char c) {
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
    damaged();
}

}  // namespace

CoarseBlocks CoarseBlocks::of(const std::string& text) {
    CoarseBlocks out;
    if (text.empty()) return out;
    int numbers[6] = {}, used = 0;
    if (std::sscanf(text.c_str(), "%9d,%9d,%9d,%9d,%9d,%9d:%n", numbers, numbers + 1, numbers + 2, numbers + 3,
                    numbers + 4, numbers + 5, &used) != 6 ||
        used == 0)
        damaged();
    std::uint64_t blocks = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        out.min[a] = numbers[a], out.count[a] = numbers[3 + a];
        if (out.count[a] < 1 || out.count[a] > kLargestIndex / 16 || std::abs(out.min[a]) > kLargestIndex / 16)
            damaged();
        // So many digits there are: no more memory than the file has bytes.
        blocks *= static_cast<std::uint64_t>(out.count[a]);
        if (blocks > 4 * text.size()) damaged();
    }
    if (blocks > 4 * (text.size() - static_cast<std::size_t>(used))) damaged();
    out.marks.resize(static_cast<std::size_t>(blocks));
    for (std::size_t i = 0; i < out.marks.size(); ++i)
        out.marks[i] = (digitOf(text[static_cast<std::size_t>(used) + i / 4]) >> (i % 4) & 1) != 0;
    return out;
}

void CoarseBlocks::keepWithin(std::size_t axis, int first, int last) {
    std::size_t n = 0;
    Int3 at;
    for (at[2] = 0; at[2] < count[2]; ++at[2]) {
        for (at[1] = 0; at[1] < count[1]; ++at[1]) {
            for (at[0] = 0; at[0] < count[0]; ++at[0], ++n) {
                const std::int64_t low = std::int64_t{16} * (min[axis] + at[axis]);
                if (low < first || low + 16 > last) marks[n] = false;
            }
        }
    }
}

bool CoarseBlocks::has(const Int3& block) const {
    std::size_t at[3];
    for (std::size_t a = 0; a < 3; ++a) {
        const int from_first = block[a] - min[a];
        if (from_first < 0 || from_first >= count[a]) return false;
        at[a] = static_cast<std::size_t>(from_first);
    }
    return marks[(at[2] * static_cast<std::size_t>(count[1]) + at[1]) * static_cast<std::size_t>(count[0]) + at[0]];
}

}  // namespace photic::runtime
