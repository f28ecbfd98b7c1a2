// SPDX-License-Identifier: Apache-2.0
#include "bake/file/runtime_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "bake/field/coarse_blocks.h"
#include "bake/file/active_leaves.h"

namespace photic {
namespace {

constexpr std::int64_t kTexelBytes = 8, kBrickVoxels = 9 * 9 * 9, kPageBytes = 4;
constexpr double kDenseAbove = 0.7;

// A leaf's voxels with x, y or z = 0, in the order of its mask's bits.
NeededVoxels::Mask nearSide(int axis) {
    NeededVoxels::Mask side{};
    for (int i = 0; i < 512; ++i) {
        if ((i >> (3 * (2 - axis)) & 7) == 0) side[static_cast<std::size_t>(i >> 6)] |= std::uint64_t{1} << (i & 63);
    }
    return side;
}

// Rounded up to a box of bricks, as an atlas is.
std::int64_t atlasBricks(std::int64_t count) {
    const auto side = static_cast<std::int64_t>(std::ceil(std::cbrt(static_cast<double>(count))));
    const std::int64_t y = std::min((count + side - 1) / side, side);
    return side * y * ((count + side * y - 1) / (side * y));
}

/// Of the volume that these leaves make.
RuntimeSize sizeOf(const std::vector<ActiveLeaf>& leaves, FieldChannels channels, const CoarseBlocks& coarse = {}) {
    const std::array<NeededVoxels::Mask, 3> sides{nearSide(0), nearSide(1), nearSide(2)};
    std::vector<std::array<int, 3>> pages;
    glm::ivec3 low(std::numeric_limits<int>::max()), high(std::numeric_limits<int>::min());
    for (const ActiveLeaf& leaf : leaves) {
        const glm::ivec3 page = leaf.origin / 8;  // exact: a multiple
        // The page itself, and those before it whose far side reads this leaf's near side.
        for (int n = 0; n < 8; ++n) {
            NeededVoxels::Mask read = leaf.mask;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (!(n >> axis & 1)) continue;
                for (std::size_t w = 0; w < 8; ++w) read[w] &= sides[axis][w];
            }
            if (std::all_of(read.begin(), read.end(), [](std::uint64_t word) { return word == 0; })) continue;
            pages.push_back({page.x - (n & 1), page.y - (n >> 1 & 1), page.z - (n >> 2 & 1)});
        }
        for (int i = 0; i < 512; ++i) {
            if (!NeededVoxels::maskBit(leaf.mask, i)) continue;
            const glm::ivec3 voxel = leaf.origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            low = glm::min(low, voxel), high = glm::max(high, voxel);
        }
    }
    std::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end()), pages.end());

    RuntimeSize size;
    std::vector<std::array<int, 3>> wide;  // blocks that pages share
    const auto own = static_cast<std::int64_t>(pages.size());
    std::erase_if(pages, [&](const std::array<int, 3>& page) {
        const std::array<int, 3> block{page[0] >> 1, page[1] >> 1, page[2] >> 1};
        if (!coarse.has({block[0], block[1], block[2]})) return false;
        wide.push_back(block);
        return true;
    });
    std::sort(wide.begin(), wide.end());
    wide.erase(std::unique(wide.begin(), wide.end()), wide.end());
    size.coarse = static_cast<std::int64_t>(wide.size());
    size.bricks = static_cast<std::int64_t>(pages.size()) + size.coarse;
    size.pages = 1;
    std::int64_t texels = 1;
    for (int a = 0; a < 3; ++a) {
        // Cells begin one before the first voxel; the dense texture has one voxel more at the far side.
        // With two levels the table begins where blocks do.
        const int first = (low[a] - 1) >> 3;
        size.pages *= (high[a] >> 3) - (coarse.empty() ? first : first & ~1) + 1;
        texels *= high[a] - low[a] + 3;
    }
    const double fill = static_cast<double>(own) / static_cast<double>(size.pages);
    size.dense = fill > kDenseAbove && coarse.empty();
    const std::int64_t brick_texels = atlasBricks(size.bricks + 1) * kBrickVoxels;  // brick 0 is dark
    size.bytes = size.pages * kPageBytes + denseTextureBytes(size.dense ? texels : brick_texels, channels);
    return size;
}

}  // namespace

std::int64_t denseTextureBytes(std::int64_t texels, FieldChannels channels) {
    return texels * kTexelBytes * (channels.irradiance == 3 ? 2 : 1);
}

RuntimeSize runtimeSize(const LightVolume& volume) {
    const FieldChannels channels = volume.field.channels();
    const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::Light);
    const auto blocks = volume.metadata.find("coarse_blocks");
    const CoarseBlocks coarse =
        blocks == volume.metadata.end() ? CoarseBlocks() : CoarseBlocks::fromText(blocks->second);
    RuntimeSize size = sizeOf(leaves, channels, coarse);
    const std::vector<ActiveLeaf> second = secondLobeLeaves(volume, leaves);
    if (!second.empty()) {
        // A volume of its own.
        const RuntimeSize more = sizeOf(second, channels);
        size.bricks += more.bricks, size.pages += more.pages, size.bytes += more.bytes;
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
