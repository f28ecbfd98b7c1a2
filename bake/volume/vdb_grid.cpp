// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstring>
#include <glm/common.hpp>

#include "bake/volume/byte_cursor.h"
#include "bake/volume/pack.h"
#include "bake/volume/vdb_bytes.h"

namespace photic {
namespace {

constexpr VdbGrid::Mask kFull{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};

std::int64_t bitsIn(const VdbGrid::Mask& mask) {
    std::int64_t n = 0;
    for (const auto word : mask) n += std::popcount(word);
    return n;
}

}  // namespace

VdbGrid::Mask VdbGrid::mask(const VdbLeaf& leaf) const {
    if (leaf.kind == VdbLeaf::Kind::Tile) return kFull;
    Mask mask;
    std::memcpy(mask.data(), file_ + leaf.mask, sizeof(mask));
    return mask;
}

std::size_t VdbGrid::bytesOf(const VdbLeaf& leaf) const {
    const auto width = static_cast<std::size_t>(components) * (half_ ? 2 : sizeof(float));
    const bool all = leaf.kind == VdbLeaf::Kind::AllVoxels;
    const std::size_t stored = (all ? kVoxels : static_cast<std::size_t>(bitsIn(mask(leaf)))) * width;
    return leaf.values + (leaf.packed != 0 ? leaf.packed : stored) - leaf.mask;
}

void VdbGrid::values(const VdbLeaf& leaf, float* out) const {
    const auto width = static_cast<std::size_t>(components);
    if (leaf.kind == VdbLeaf::Kind::Tile) {
        const auto& value = leaf_tiles_[leaf.values];
        for (std::size_t i = 0; i < kVoxels; ++i) std::copy_n(value.begin(), width, out + i * width);
        return;
    }
    const Mask active = mask(leaf);
    const bool all = leaf.kind == VdbLeaf::Kind::AllVoxels;
    const std::size_t count = (all ? kVoxels : static_cast<std::size_t>(bitsIn(active))) * width;
    char unpacked[kVoxels * 3 * sizeof(float)];
    const char* from = file_ + leaf.values;
    if (leaf.packed != 0) {
        unpackBytes(compression_, from, leaf.packed, unpacked, count * (half_ ? 2 : sizeof(float)));
        from = unpacked;
    }
    float stored[kVoxels * 3];
    float* to = all ? out : stored;
    if (half_)
        convert_.toFloat(from, count, to);
    else
        std::memcpy(to, from, count * sizeof(float));
    if (all) return;
    const float* next = stored;
    for (std::size_t i = 0; i < kVoxels; ++i) {
        const bool on = active[i >> 6] >> (i & 63) & 1;
        for (std::size_t c = 0; c < width; ++c) out[i * width + c] = on ? next[c] : 0.0f;
        next += on ? width : 0;
    }
}

std::int64_t VdbGrid::tileVoxels() const {
    std::int64_t voxels = 0;
    for (const VdbTile& tile : tiles) voxels += std::int64_t{tile.side} * tile.side * tile.side;
    return voxels;
}

std::int64_t VdbGrid::activeVoxels() const {
    std::int64_t voxels = tileVoxels();
    for (const VdbLeaf& leaf : leaves) voxels += bitsIn(mask(leaf));
    return voxels;
}

void VdbGrid::expandTiles() {
    for (const VdbTile& tile : tiles) {
        VdbLeaf leaf;
        leaf.kind = VdbLeaf::Kind::Tile;
        leaf.values = leaf_tiles_.size();
        leaf_tiles_.push_back(tile.value);
        for (int x = 0; x < tile.side; x += 8)
            for (int y = 0; y < tile.side; y += 8)
                for (int z = 0; z < tile.side; z += 8) {
                    leaf.origin = tile.origin + glm::ivec3(x, y, z);
                    leaves.push_back(leaf);
                }
    }
    tiles.clear();
}

void growByActive(const glm::ivec3& origin, const VdbGrid::Mask& mask, glm::ivec3& min, glm::ivec3& max) {
    bool within = true;
    for (int a = 0; a < 3; ++a) within = within && min[a] <= origin[a] && max[a] >= origin[a] + 7;
    if (within) return;
    std::uint64_t columns = 0;  // a bit a (y, z), over all x
    glm::ivec3 low(8), high(-1);
    for (int x = 0; x < 8; ++x) {
        const std::uint64_t slice = mask[static_cast<std::size_t>(x)];
        if (slice == 0) continue;
        columns |= slice, low.x = std::min(low.x, x), high.x = x;
    }
    if (columns == 0) return;
    low.y = std::countr_zero(columns) >> 3, high.y = (63 - std::countl_zero(columns)) >> 3;
    columns |= columns >> 32, columns |= columns >> 16, columns |= columns >> 8;
    const auto z = static_cast<std::uint8_t>(columns);
    low.z = std::countr_zero(z), high.z = 7 - std::countl_zero(z);
    min = glm::min(min, origin + low), max = glm::max(max, origin + high);
}

bool VdbGrid::activeBox(glm::ivec3& min, glm::ivec3& max) const {
    constexpr int kFar = 0x7fffffff;
    min = glm::ivec3(kFar), max = glm::ivec3(-kFar);
    for (const VdbTile& tile : tiles)
        min = glm::min(min, tile.origin), max = glm::max(max, tile.origin + glm::ivec3(tile.side - 1));
    for (const VdbLeaf& leaf : leaves) growByActive(leaf.origin, mask(leaf), min, max);
    return max.x >= min.x;
}

}  // namespace photic
