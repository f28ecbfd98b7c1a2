// SPDX-License-Identifier: Apache-2.0
#include "bake/file/brick_pages.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <nlohmann/json.hpp>

namespace photic {
namespace {

/// A leaf's voxels with x, y or z = 0, in the order of its mask's bits.
NeededVoxels::Mask nearSide(int axis) {
    NeededVoxels::Mask side{};
    for (int i = 0; i < 512; ++i) {
        if ((i >> (3 * (2 - axis)) & 7) == 0) side[static_cast<std::size_t>(i >> 6)] |= std::uint64_t{1} << (i & 63);
    }
    return side;
}

}  // namespace

glm::ivec3 periodVoxels(const LightVolume& volume) {
    glm::ivec3 period(0);
    const auto text = volume.metadata.find("period");
    if (text == volume.metadata.end()) return period;
    const auto json = nlohmann::json::parse(text->second, nullptr, false);
    for (std::size_t a = 0; json.is_array() && a < json.size() && a < 3; ++a) {
        if (!json[a].is_number() || json[a].get<double>() == 0) continue;
        glm::dvec3 world(0);
        world[static_cast<int>(a)] = json[a].get<double>();
        const glm::dvec3 steps = glm::abs(volume.field.frame().indexFromWorld() * world);
        const int longest = steps.x >= steps.y && steps.x >= steps.z ? 0 : steps.y >= steps.z ? 1 : 2;
        period[longest] = static_cast<int>(std::lround(steps[longest]));
    }
    return period;
}

BrickPages brickPages(const std::vector<ActiveLeaf>& leaves, const CoarseBlocks& coarse, const glm::ivec3& period) {
    const std::array<NeededVoxels::Mask, 3> sides{nearSide(0), nearSide(1), nearSide(2)};
    BrickPages out;
    out.period = period;
    auto& pages = out.pages;
    out.low = glm::ivec3(std::numeric_limits<int>::max()), out.high = glm::ivec3(std::numeric_limits<int>::min());
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
            out.low = glm::min(out.low, voxel), out.high = glm::max(out.high, voxel);
        }
    }
    // Before the first page of a period lies its last one, where it is cut between pages.
    for (int a = 0; a < 3; ++a) {
        if (period[a] == 0 || period[a] % 8 != 0 || (out.low[a] & 7) != 0) continue;
        for (std::array<int, 3>& page : pages) {
            int& at = page[static_cast<std::size_t>(a)];
            if (8 * at < out.low[a]) at += period[a] / 8;
        }
    }
    std::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end()), pages.end());
    out.own = pages.size();
    std::erase_if(pages, [&](const std::array<int, 3>& page) {
        const std::array<int, 3> block{page[0] >> 1, page[1] >> 1, page[2] >> 1};
        if (!coarse.has({block[0], block[1], block[2]})) return false;
        out.blocks.push_back(block);
        return true;
    });
    std::sort(out.blocks.begin(), out.blocks.end());
    out.blocks.erase(std::unique(out.blocks.begin(), out.blocks.end()), out.blocks.end());
    return out;
}

BrickPages brickPages(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves, const CoarseBlocks& coarse) {
    return brickPages(leaves, coarse, periodVoxels(volume));
}

CoarseBlocks coarseBlocksOf(const LightVolume& volume) {
    const auto blocks = volume.metadata.find("coarse_blocks");
    return blocks == volume.metadata.end() ? CoarseBlocks() : CoarseBlocks::fromText(blocks->second);
}

}  // namespace photic
