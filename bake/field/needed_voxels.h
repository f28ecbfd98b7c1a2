// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/field/grid_frame.h"

namespace photic {

/// Which voxels anybody asked for, as 8^3 leaves with a bit per voxel. Bits use OpenVDB's leaf
/// order: (x & 7) << 6 | (y & 7) << 3 | (z & 7).
///
/// Leaves are numbered over the box of leaf coordinates that covers the frame; a table gives each
/// needed leaf a slot, in the table's order (z fastest), so slots are the same for any thread count.
class NeededVoxels {
public:
    using Mask = std::array<std::uint64_t, 8>;

    /// All voxels of `frame`.
    static NeededVoxels everything(const GridFrame& frame);
    /// No voxel yet; add() them, then finish().
    static NeededVoxels none(const GridFrame& frame);

    /// Marks a voxel; outside the frame is ignored. Not thread-safe.
    void add(const glm::ivec3& voxel);
    /// Numbers the slots. Call once after the last add().
    void finish();

    const GridFrame& frame() const { return frame_; }
    bool isEverything() const { return everything_; }
    std::int64_t count() const { return count_; }                   ///< needed voxels
    int leafCount() const { return static_cast<int>(leaf_origins_.size()); }
    glm::ivec3 leafOrigin(int slot) const { return leaf_origins_[static_cast<std::size_t>(slot)]; }  ///< multiple of 8
    const Mask& mask(int slot) const { return masks_[static_cast<std::size_t>(slot)]; }
    bool leafFull(int slot) const;                                  ///< all 512 needed

    /// Slot of the leaf that holds a voxel, or -1 when none of its voxels is needed or it lies outside.
    int slotOf(const glm::ivec3& voxel) const;
    bool contains(const glm::ivec3& voxel) const;

    static int offsetInLeaf(const glm::ivec3& v) { return (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7); }
    static bool maskBit(const Mask& m, int offset) { return m[static_cast<std::size_t>(offset >> 6)] >> (offset & 63) & 1; }

private:
    GridFrame frame_;
    bool everything_ = false;
    std::int64_t count_ = 0;
    glm::ivec3 leaf_min_{0}, leaf_size_{0};      // in leaf coordinates
    std::vector<std::int32_t> slots_;            // dense table over the leaf box, -1: none
    std::vector<glm::ivec3> leaf_origins_;
    std::vector<Mask> masks_;
};

}  // namespace photic
