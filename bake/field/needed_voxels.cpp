// SPDX-License-Identifier: Apache-2.0
#include "bake/field/needed_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

std::int64_t bitsIn(const NeededVoxels::Mask& mask) {
    std::int64_t n = 0;
    for (const auto word : mask) n += std::popcount(word);
    return n;
}

// Bits lo..hi (inclusive) of eight, as the low bits of a byte.
std::uint64_t byteRun(int lo, int hi) { return lo > hi ? 0 : (0xffull >> (7 - (hi - lo))) << lo; }

}  // namespace

NeededVoxels::NeededVoxels(const GridFrame& frame) : frame_(frame) {
    // In 64 bits and floating point: the corners may lie anywhere.
    double leaves = 1;
    std::array<std::int64_t, 3> size{};
    for (int a = 0; a < 3; ++a) {
        size[static_cast<std::size_t>(a)] = std::int64_t{frame.max[a]} - frame.min[a] + 1;
        if (size[static_cast<std::size_t>(a)] <= 0) return;
        leaves *= double((frame.max[a] >> 3) - (frame.min[a] >> 3) + 1);
    }
    if (leaves > double(kMaxLeaves))
        throw Error(ErrorCode::Input, fmt::format("a grid of {} x {} x {} voxels has {:.6g} blocks of 8^3, more than "
                                                  "{}; use larger voxels or a smaller domain",
                                                  size[0], size[1], size[2], leaves, kMaxLeaves));
    leaf_min_ = frame.min >> 3;
    leaf_size_ = (frame.max >> 3) - leaf_min_ + 1;
    page_size_ = (leaf_size_ + ((1 << kPageBits) - 1)) >> kPageBits;

    // The part of a leaf inside the frame, for the 27 ways in which a leaf can touch its border.
    for (std::size_t c = 0; c < 27; ++c) {
        const std::array<int, 3> side{int(c / 9), int(c / 3 % 3), int(c % 3)};
        std::array<std::uint64_t, 3> run{};
        for (int a = 0; a < 3; ++a) {
            const auto ua = static_cast<std::size_t>(a);
            const bool low = side[ua] == 0, high = side[ua] == 2 || leaf_size_[a] == 1;
            run[ua] = byteRun(low ? frame.min[a] & 7 : 0, high ? frame.max[a] & 7 : 7);
        }
        for (int x = 0; x < 8; ++x) {
            std::uint64_t word = 0;
            for (int y = 0; y < 8; ++y)
                if (run[0] >> x & 1 && run[1] >> y & 1) word |= run[2] << (8 * y);
            border_masks_[c][static_cast<std::size_t>(x)] = word;
        }
    }
}

NeededVoxels NeededVoxels::everything(const GridFrame& frame) {
    NeededVoxels needed(frame);
    needed.everything_ = true;
    needed.leaf_count_ = needed.leaf_size_.x * needed.leaf_size_.y * needed.leaf_size_.z;
    needed.count_ = needed.leaf_count_ > 0 ? frame.voxelCount() : 0;
    return needed;
}

NeededVoxels NeededVoxels::none(const GridFrame& frame) {
    NeededVoxels needed(frame);
    needed.pages_.assign(static_cast<std::size_t>(needed.page_size_.x) * static_cast<std::size_t>(needed.page_size_.y) *
                             static_cast<std::size_t>(needed.page_size_.z),
                         -1);
    return needed;
}

NeededVoxels::Mask& NeededVoxels::maskToAddTo(const glm::ivec3& origin) {
    const glm::ivec3 leaf = (origin >> 3) - leaf_min_;
    auto& page = pages_[pageOf(leaf.x, leaf.y, leaf.z)];
    if (page < 0) {
        page = static_cast<std::int32_t>(slots_.size() / kPageLeaves);
        slots_.resize(slots_.size() + kPageLeaves, -1);
    }
    constexpr int m = (1 << kPageBits) - 1;
    auto& slot =
        slots_[static_cast<std::size_t>(page) * kPageLeaves +
               static_cast<std::size_t>(((leaf.x & m) << kPageBits | (leaf.y & m)) << kPageBits | (leaf.z & m))];
    if (slot < 0) {
        slot = static_cast<std::int32_t>(masks_.size());
        leaf_origins_.push_back(origin);
        masks_.push_back(Mask{});
    }
    return masks_[static_cast<std::size_t>(slot)];
}

void NeededVoxels::addColumn(int x, int y, int z_min, int z_max) {
    z_min = std::max(z_min, frame_.min.z), z_max = std::min(z_max, frame_.max.z);
    if (x < frame_.min.x || x > frame_.max.x || y < frame_.min.y || y > frame_.max.y) return;
    for (int z = z_min; z <= z_max; z = (z | 7) + 1) {
        Mask& mask = maskToAddTo({x & ~7, y & ~7, z & ~7});
        mask[static_cast<std::size_t>(x & 7)] |= byteRun(z & 7, std::min(z_max, z | 7) & 7) << (8 * (y & 7));
    }
}

void NeededVoxels::addLeaf(const glm::ivec3& origin, const Mask& mask) {
    const glm::ivec3 leaf = (origin >> 3) - leaf_min_;
    for (int a = 0; a < 3; ++a)
        if (leaf[a] < 0 || leaf[a] >= leaf_size_[a]) return;
    const Mask& inside = border_masks_[borderClass(origin)];
    Mask clipped;
    std::uint64_t any = 0;
    for (std::size_t w = 0; w < 8; ++w) any |= clipped[w] = mask[w] & inside[w];
    if (any == 0) return;
    Mask& to = maskToAddTo(origin);
    for (std::size_t w = 0; w < 8; ++w) to[w] |= clipped[w];
}

void NeededVoxels::finish() {
    // Leaves in the order of their coordinates, z fastest, whatever the order in which they were added.
    std::vector<std::int32_t> order(leaf_origins_.size());
    std::iota(order.begin(), order.end(), 0);
    const auto before = [&](std::int32_t a, std::int32_t b) {
        const glm::ivec3 &p = leaf_origins_[static_cast<std::size_t>(a)],
                         &q = leaf_origins_[static_cast<std::size_t>(b)];
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    };
    if (!std::is_sorted(order.begin(), order.end(), before)) std::sort(order.begin(), order.end(), before);

    std::vector<glm::ivec3> origins(order.size());
    std::vector<Mask> partial;
    std::vector<std::int32_t> slot_of_old(order.size());
    mask_index_.resize(order.size());
    count_ = 0;
    for (std::size_t slot = 0; slot < order.size(); ++slot) {
        const auto old = static_cast<std::size_t>(order[slot]);
        origins[slot] = leaf_origins_[old];
        slot_of_old[old] = static_cast<std::int32_t>(slot);
        count_ += bitsIn(masks_[old]);
        const bool full = masks_[old] == kFull;
        mask_index_[slot] = full ? -1 : static_cast<std::int32_t>(partial.size());
        if (!full) partial.push_back(masks_[old]);
    }
    for (auto& slot : slots_)
        if (slot >= 0) slot = slot_of_old[static_cast<std::size_t>(slot)];
    partial.shrink_to_fit();
    leaf_origins_ = std::move(origins);
    masks_ = std::move(partial);
    leaf_count_ = static_cast<int>(leaf_origins_.size());
}

NeededVoxels NeededVoxels::partOf(std::shared_ptr<const NeededVoxels> whole, const VoxelBox& tile, int margin_leaves) {
    NeededVoxels part = none(whole->frame());
    const glm::ivec3 low = ((tile.min >> 3) - margin_leaves) * 8, high = ((tile.max >> 3) + margin_leaves) * 8;
    if (whole->everything_) {
        const glm::ivec3 first = glm::max(low, part.leaf_min_ * 8),
                         last = glm::min(high, (part.leaf_min_ + part.leaf_size_ - 1) * 8);
        for (int x = first.x; x <= last.x; x += 8)
            for (int y = first.y; y <= last.y; y += 8)
                for (int z = first.z; z <= last.z; z += 8) part.addLeaf({x, y, z}, kFull);
    } else {
        const VoxelBox leaves{low, high};
        for (int slot = 0; slot < whole->leafCount(); ++slot)
            if (leaves.contains(whole->leafOrigin(slot))) part.addLeaf(whole->leafOrigin(slot), whole->mask(slot));
    }
    part.finish();
    part.whole_ = std::move(whole), part.tile_ = tile;
    return part;
}

std::int64_t NeededVoxels::tileCount() const {
    if (!whole_) return count_;
    std::int64_t count = 0;
    for (int slot = 0; slot < leaf_count_; ++slot)
        if (inTile(slot)) count += bitsIn(mask(slot));
    return count;
}

std::int64_t NeededVoxels::bytes() const {
    return static_cast<std::int64_t>(sizeof(*this) +
                                     4 * (pages_.capacity() + slots_.capacity() + mask_index_.capacity()) +
                                     sizeof(glm::ivec3) * leaf_origins_.capacity() + sizeof(Mask) * masks_.capacity());
}

void forEachLeaf(const NeededVoxels& needed, const std::function<void(int)>& body) {
    // Blocks of leaves: a leaf alone can be too little work for a task.
    constexpr std::int64_t kBlock = 16;
    const std::int64_t leaves = needed.leafCount();
    parallelFor((leaves + kBlock - 1) / kBlock, [&](std::int64_t block) {
        const auto end = std::min(leaves, (block + 1) * kBlock);
        for (auto slot = block * kBlock; slot < end; ++slot) body(static_cast<int>(slot));
    });
}

}  // namespace photic
