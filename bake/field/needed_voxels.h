// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bake/field/grid_frame.h"

namespace photic {

/// Which voxels anybody asked for, as 8^3 leaves with a bit per voxel. Bits use OpenVDB's leaf
/// order: (x & 7) << 6 | (y & 7) << 3 | (z & 7).
///
/// Leaves are numbered over the box of leaf coordinates that covers the frame, z fastest; only needed leaves
/// get a slot, in that order, so slots are the same for any thread count.
/// Memory: nothing per voxel or leaf when everything is needed; otherwise 20 bytes a needed leaf, 64 more for a
/// leaf that is needed in part, and a table of pages of 16^3 leaves.
class NeededVoxels {
public:
    using Mask = std::array<std::uint64_t, 8>;
    static constexpr std::int64_t kMaxLeaves = 0x7fffffff;

    /// All voxels of `frame`. @throws Error{Input} when it has more than kMaxLeaves leaves
    static NeededVoxels everything(const GridFrame& frame);
    /// No voxel yet; add() them, then finish(). @throws Error{Input} when it has more than kMaxLeaves leaves
    static NeededVoxels none(const GridFrame& frame);

    /// The part of `whole` that is baked for one tile: its leaves, and those around it that what is in them depends on.
    /// The frame stays that of the whole, so that light takes the same ways, and layers are summed together as there.
    /// @param tile           from and to the borders of leaves, or of the frame
    /// @param margin_leaves  around it, on each side
    static NeededVoxels partOf(std::shared_ptr<const NeededVoxels> whole, const VoxelBox& tile, int margin_leaves);

    /// Marks a voxel; outside the frame is ignored. Not thread-safe.
    void add(const glm::ivec3& voxel) { addColumn(voxel.x, voxel.y, voxel.z, voxel.z); }
    /// Marks voxels (x, y, z_min .. z_max), inclusive; what lies outside the frame is ignored. Not thread-safe.
    void addColumn(int x, int y, int z_min, int z_max);
    /// Marks voxels of the leaf at `origin` (a multiple of 8); what lies outside the frame is ignored. Not thread-safe.
    void addLeaf(const glm::ivec3& origin, const Mask& mask);
    /// Numbers the slots. Call once after the last add.
    void finish();

    const GridFrame& frame() const { return frame_; }
    bool isEverything() const { return everything_; }
    std::int64_t count() const { return count_; }  ///< needed voxels, those of a part's margin too
    /// What a part was cut from; itself where it is none.
    const NeededVoxels& whole() const { return whole_ ? *whole_ : *this; }
    bool isPart() const { return whole_ != nullptr; }
    /// A part's tile; the frame where it is no part.
    VoxelBox tile() const { return whole_ ? tile_ : VoxelBox{frame_.min, frame_.max}; }
    /// False for a leaf of a part's margin.
    bool inTile(int slot) const { return !whole_ || tile_.contains(glm::max(leafOrigin(slot), frame_.min)); }
    std::int64_t tileCount() const;  ///< needed voxels of the tile
    int leafCount() const { return leaf_count_; }
    glm::ivec3 leafOrigin(int slot) const {  ///< multiple of 8
        return everything_ ? originOf(slot) : leaf_origins_[static_cast<std::size_t>(slot)];
    }
    const Mask& mask(int slot) const {
        if (everything_) return border_masks_[borderClass(leafOrigin(slot))];
        const std::int32_t index = mask_index_[static_cast<std::size_t>(slot)];
        return index < 0 ? kFull : masks_[static_cast<std::size_t>(index)];
    }
    /// All 512 voxels of a leaf are needed.
    bool leafFull(int slot) const {
        return everything_ ? mask(slot) == kFull : mask_index_[static_cast<std::size_t>(slot)] < 0;
    }

    /// Slot of the leaf that holds a voxel, or -1 when none of the leaf's voxels is needed.
    int slotOf(const glm::ivec3& voxel) const {
        const int x = (voxel.x >> 3) - leaf_min_.x, y = (voxel.y >> 3) - leaf_min_.y, z = (voxel.z >> 3) - leaf_min_.z;
        if (static_cast<unsigned>(x) >= static_cast<unsigned>(leaf_size_.x) ||
            static_cast<unsigned>(y) >= static_cast<unsigned>(leaf_size_.y) ||
            static_cast<unsigned>(z) >= static_cast<unsigned>(leaf_size_.z))
            return -1;
        if (everything_) return (x * leaf_size_.y + y) * leaf_size_.z + z;
        return slotInPages(x, y, z);
    }
    bool contains(const glm::ivec3& voxel) const {
        const int slot = slotOf(voxel);
        return slot >= 0 && maskBit(mask(slot), offsetInLeaf(voxel));
    }
    /// Bytes held by the tables.
    std::int64_t bytes() const;

    static int offsetInLeaf(const glm::ivec3& v) { return (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7); }
    static bool maskBit(const Mask& m, int offset) {
        return m[static_cast<std::size_t>(offset >> 6)] >> (offset & 63) & 1;
    }

private:
    static constexpr Mask kFull{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};
    static constexpr int kPageBits = 4;  // a page is 16^3 leaves
    static constexpr std::size_t kPageLeaves = std::size_t{1} << (3 * kPageBits);

    explicit NeededVoxels(const GridFrame& frame);
    glm::ivec3 originOf(int slot) const {
        const int z = slot % leaf_size_.z, column = slot / leaf_size_.z;
        return (leaf_min_ + glm::ivec3(column / leaf_size_.y, column % leaf_size_.y, z)) * 8;
    }
    // Leaves at the frame's low side, within, or at its high side, per axis: one mask for each of the 27 classes.
    std::size_t borderClass(const glm::ivec3& origin) const {
        std::size_t c = 0;
        for (int a = 0; a < 3; ++a) {
            const int leaf = (origin[a] >> 3) - leaf_min_[a];
            c = 3 * c + (leaf == 0 ? 0u : leaf == leaf_size_[a] - 1 ? 2u : 1u);
        }
        return c;
    }
    int slotInPages(int x, int y, int z) const {
        constexpr int m = (1 << kPageBits) - 1;
        const auto page = pages_[pageOf(x, y, z)];
        if (page < 0) return -1;
        return slots_[static_cast<std::size_t>(page) * kPageLeaves +
                      static_cast<std::size_t>(((x & m) << kPageBits | (y & m)) << kPageBits | (z & m))];
    }
    std::size_t pageOf(int x, int y, int z) const {
        return (static_cast<std::size_t>(x >> kPageBits) * static_cast<std::size_t>(page_size_.y) +
                static_cast<std::size_t>(y >> kPageBits)) *
                   static_cast<std::size_t>(page_size_.z) +
               static_cast<std::size_t>(z >> kPageBits);
    }
    Mask& maskToAddTo(const glm::ivec3& origin);

    GridFrame frame_;
    std::shared_ptr<const NeededVoxels> whole_;
    VoxelBox tile_;
    bool everything_ = false;
    std::int64_t count_ = 0;
    int leaf_count_ = 0;
    glm::ivec3 leaf_min_{0}, leaf_size_{0}, page_size_{0};  // in leaf coordinates; in pages
    std::array<Mask, 27> border_masks_{};
    std::vector<std::int32_t> pages_, slots_;  // -1: none
    std::vector<glm::ivec3> leaf_origins_;
    std::vector<std::int32_t> mask_index_;  // per slot; -1: full
    std::vector<Mask> masks_;
};

/// Visits leaves in parallel: body(slot).
void forEachLeaf(const NeededVoxels& needed, const std::function<void(int)>& body);

}  // namespace photic
