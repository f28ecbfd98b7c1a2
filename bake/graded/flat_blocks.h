// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "bake/graded/spline_index.h"

namespace photic {

/// Which blocks of a spline's cells hold one index throughout, and one medium: light goes straight through them.
class FlatBlocks {
public:
    static constexpr int kCells = 8;  ///< a side of a block

    /// @param media  per node, or empty: a block with several is not flat
    FlatBlocks(const SplineIndex& index, const std::vector<std::uint8_t>& media);

    /// The block that holds a place, in nodes from the spline's first; places beyond the nodes belong to the rim's.
    glm::ivec3 blockOf(const glm::dvec3& node) const;
    bool flat(const glm::ivec3& block) const { return flat_[flatIndex(block)] != 0; }
    glm::ivec3 count() const { return count_; }

private:
    std::size_t flatIndex(const glm::ivec3& b) const {
        return (static_cast<std::size_t>(b.z) * static_cast<std::size_t>(count_.y) + static_cast<std::size_t>(b.y)) *
                   static_cast<std::size_t>(count_.x) +
               static_cast<std::size_t>(b.x);
    }
    glm::ivec3 count_;
    std::vector<std::uint8_t> flat_;
};

}  // namespace photic
