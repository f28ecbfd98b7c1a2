// SPDX-License-Identifier: Apache-2.0
#include "bake/file/runtime_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/ext/vector_int3_sized.hpp>
#include <limits>
#include <vector>

namespace photic {
namespace {

constexpr std::int64_t kTexelBytes = 8, kBrickVoxels = 9 * 9 * 9, kPageBytes = 4;
constexpr double kDenseAbove = 0.7;

// Rounded up to a box of bricks, as an atlas is.
std::int64_t atlasBricks(std::int64_t count) {
    const auto side = static_cast<std::int64_t>(std::ceil(std::cbrt(static_cast<double>(count))));
    const std::int64_t y = std::min((count + side - 1) / side, side);
    return side * y * ((count + side * y - 1) / (side * y));
}

/// Blocks of 4 x 4 texels in x and y, two textures of 16 bytes a block.
std::int64_t blockBytes(std::int64_t width, std::int64_t height, std::int64_t depth) {
    return (width + 3) / 4 * ((height + 3) / 4) * depth * 32;
}

}  // namespace

std::int64_t denseTextureBytes(std::int64_t texels, FieldChannels channels) {
    return texels * kTexelBytes * (channels.irradiance == 3 ? 2 : 1);
}

RuntimeSize runtimeSize(const BrickPages& pages, FieldChannels channels, const CoarseBlocks& coarse,
                        GameTexels texels) {
    RuntimeSize size;
    size.coarse = static_cast<std::int64_t>(pages.blocks.size());
    size.bricks = static_cast<std::int64_t>(pages.pages.size()) + size.coarse;
    size.pages = 1;
    glm::i64vec3 box(1);
    for (int a = 0; a < 3; ++a) {
        // Cells begin one before the first voxel; the dense texture has one voxel more at the far side.
        // Where light repeats both are one period. With two levels the table begins where blocks do.
        const int period = pages.period[a];
        const int first = (period > 0 ? pages.low[a] : pages.low[a] - 1) >> 3;
        const int last = period > 0 ? pages.low[a] + period - 1 : pages.high[a];
        size.pages *= (last >> 3) - (coarse.empty() ? first : first & ~1) + 1;
        box[a] = period > 0 ? period : pages.high[a] - pages.low[a] + 3;
    }
    const std::int64_t bricks = atlasBricks(size.bricks + 1);  // brick 0 is dark
    if (texels == GameTexels::Bc6h) {
        const std::int64_t dense = blockBytes(box.x, box.y, box.z), atlas = bricks * blockBytes(12, 12, 9);
        size.dense = pages.repeats() || (dense < atlas && coarse.empty());
        size.bytes = size.pages * kPageBytes + (size.dense ? dense : atlas);
        return size;
    }
    const double fill = static_cast<double>(pages.own) / static_cast<double>(size.pages);
    size.dense = fill > kDenseAbove && coarse.empty();
    size.bytes = size.pages * kPageBytes +
                 denseTextureBytes(size.dense ? box.x * box.y * box.z : bricks * kBrickVoxels, channels);
    return size;
}

RuntimeSize runtimeSize(const LightVolume& volume, GameTexels texels) {
    const FieldChannels channels = volume.field.channels();
    const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::Light);
    const CoarseBlocks coarse = coarseBlocksOf(volume);
    RuntimeSize size = runtimeSize(brickPages(volume, leaves, coarse), channels, coarse, texels);
    const std::vector<ActiveLeaf> second = secondLobeLeaves(volume, leaves);
    if (!second.empty()) {
        // A volume of its own.
        const RuntimeSize more = runtimeSize(brickPages(volume, second, coarse), channels, coarse, texels);
        size.bricks += more.bricks, size.coarse += more.coarse, size.pages += more.pages, size.bytes += more.bytes;
    }
    return size;
}

glm::ivec3 fewestBricksShift(const LightVolume& volume) {
    constexpr std::int64_t kMostMarks = std::int64_t{1} << 26;
    const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::Light);
    glm::ivec3 low(std::numeric_limits<int>::max()), high(std::numeric_limits<int>::min());
    for (const ActiveLeaf& leaf : leaves) low = glm::min(low, leaf.origin), high = glm::max(high, leaf.origin + 7);
    glm::ivec3 shift(0);
    for (int axis = 0; axis < 3; ++axis) {
        // Which voxels along this axis hold light, for each column of pages across it. The other axes' shifts, so far
        // as they are chosen, count.
        const int a1 = (axis + 1) % 3, a2 = (axis + 2) % 3, length = high[axis] - low[axis] + 1;
        const auto page = [&](int voxel, int a) { return ((voxel + shift[a]) >> 3) - ((low[a] - 1) >> 3); };
        const int n1 = page(high[a1], a1) + 1, n2 = page(high[a2], a2) + 1;
        if (std::int64_t{length} * n1 * n2 > kMostMarks) return glm::ivec3(0);
        std::vector<char> lit(static_cast<std::size_t>(length) * static_cast<std::size_t>(n1) *
                              static_cast<std::size_t>(n2));
        for (const ActiveLeaf& leaf : leaves)
            for (int i = 0; i < 512; ++i) {
                if (!NeededVoxels::maskBit(leaf.mask, i)) continue;
                const glm::ivec3 v = leaf.origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
                for (int n = 0; n < 4; ++n) {
                    const int column = page(v[a1] - (n & 1), a1) * n2 + page(v[a2] - (n >> 1), a2);
                    lit[static_cast<std::size_t>(column) * static_cast<std::size_t>(length) +
                        static_cast<std::size_t>(v[axis] - low[axis])] = 1;
                }
            }
        std::int64_t fewest = std::numeric_limits<std::int64_t>::max();
        for (int s = 0; s < 8; ++s) {
            std::int64_t bricks = 0;
            for (std::size_t column = 0; column < lit.size(); column += static_cast<std::size_t>(length)) {
                int last = std::numeric_limits<int>::min();
                for (int i = 0; i < length; ++i) {
                    if (!lit[column + static_cast<std::size_t>(i)]) continue;
                    // The page that reads this voxel as its far side, and its own.
                    for (const int p : {(low[axis] + i + s - 1) >> 3, (low[axis] + i + s) >> 3}) {
                        if (p > last) ++bricks, last = p;
                    }
                }
            }
            if (bricks < fewest) fewest = bricks, shift[axis] = s;
        }
    }
    return shift;
}

}  // namespace photic
