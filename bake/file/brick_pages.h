// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/field/coarse_blocks.h"
#include "bake/file/active_leaves.h"

namespace photic {

/// Where the run-time library has bricks for a volume: pages of 8^3 voxels that hold light or whose far sides read
/// some, and blocks of 2^3 pages that share a brick of voxels twice as wide.
struct BrickPages {
    std::vector<std::array<int, 3>> pages;   ///< with a brick of their own, sorted
    std::vector<std::array<int, 3>> blocks;  ///< that share one, sorted
    std::size_t own = 0;                     ///< pages with either
    glm::ivec3 low{0}, high{0};              ///< voxels around all light, inside
    glm::ivec3 period{0};                    ///< [voxels], from `low` on; 0 along axes where the light does not repeat
    bool repeats() const { return period != glm::ivec3(0); }
};

/// Voxels along each axis after which a volume's light repeats; 0: it does not.
glm::ivec3 periodVoxels(const LightVolume& volume);

BrickPages brickPages(const std::vector<ActiveLeaf>& leaves, const CoarseBlocks& coarse,
                      const glm::ivec3& period = glm::ivec3(0));
/// Of one lobe of a volume, whose active leaves these are.
BrickPages brickPages(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves, const CoarseBlocks& coarse);

/// Those that `coarse_blocks` of a volume's metadata marks.
CoarseBlocks coarseBlocksOf(const LightVolume& volume);

}  // namespace photic
