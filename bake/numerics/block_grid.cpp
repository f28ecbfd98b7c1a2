// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/block_grid.h"

namespace photic {

BlockGrid::BlockGrid(const glm::ivec3& blocks, std::span<const std::uint8_t> exists) : blocks_(blocks) {
    slots_.assign(
        static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) * static_cast<std::size_t>(blocks.z),
        -1);
    std::size_t at = 0;
    for (int z = 0; z < blocks.z; ++z)
        for (int y = 0; y < blocks.y; ++y)
            for (int x = 0; x < blocks.x; ++x, ++at) {
                if (!exists.empty() && exists[at] == 0) continue;
                slots_[at] = static_cast<std::int32_t>(origins_.size());
                origins_.push_back(glm::ivec3(x, y, z) * kSide);
            }
    neighbours_.resize(origins_.size());
    for (std::size_t s = 0; s < origins_.size(); ++s) {
        const glm::ivec3 block = origins_[s] / kSide;
        for (int face = 0; face < 6; ++face) {
            glm::ivec3 beside = block;
            beside[face / 2] += face % 2 == 0 ? -1 : 1;
            neighbours_[s][static_cast<std::size_t>(face)] = slotAt(beside);
        }
    }
}

std::int64_t BlockGrid::bytes() const {
    return static_cast<std::int64_t>(slots_.capacity() * sizeof(slots_[0]) + origins_.capacity() * sizeof(origins_[0]) +
                                     neighbours_.capacity() * sizeof(neighbours_[0]));
}

}  // namespace photic
