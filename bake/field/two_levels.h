// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "bake/field/coarse_blocks.h"
#include "bake/field/light_field.h"
#include "bake/report/monitor.h"

namespace photic {

/// Light that repeats after so many voxels along an axis, from voxel `first` on; 0: it does not.
struct RepeatingVoxels {
    glm::ivec3 first{0}, period{0};
    /// The voxel that stands for one.
    glm::ivec3 wrapped(const glm::ivec3& voxel) const;
};

/// A field that is made smooth where that costs least: in blocks of 16^3 voxels its values become those that a
/// trilinear look-up on voxels twice as wide gives, so that a game can hold each such block in one brick of 9^3 texels
/// instead of eight (docs/volume_bytes.md). The wide voxels are centred on every second fine one and are fitted to the
/// whole field by least squares (coarsened()). A block includes its far sides: neighbours share them, and what a
/// look-up reads is the same from either side.
///
/// Where light repeats the wide voxels do so too: the period is even and begins with a block, and a block that ends
/// with it has its far side at the period's beginning.
///
/// Blocks are ordered by what they cost, error for each brick that they save. Two lobes have the same blocks.
class TwoLevels {
public:
    /// @param second  the second lobe, on the same voxels; or null
    /// @param repeats  `first` a multiple of 16 and `period` even along axes that do
    /// @throws Error{Cancelled}
    TwoLevels(const LightField& field, const LightField* second, const Monitor& monitor,
              const RepeatingVoxels& repeats = {});

    /// Blocks that save something.
    int blockCount() const { return static_cast<int>(blocks_.size()); }

    struct Made {
        LightField field;  ///< on the voxels of the given one and those that the blocks add at its border
        std::optional<LightField> second;
        CoarseBlocks blocks;
    };
    /// The first so many blocks made coarse.
    Made with(int count) const;

private:
    struct Block {
        glm::ivec3 at;
        double cost;  ///< sum over needed voxels of |new - old| irradiance [W/m2], over the leaves that it saves
    };
    const LightField& field_;
    const LightField* second_;
    RepeatingVoxels repeats_;
    LightField coarse_;
    std::optional<LightField> coarse_second_;
    std::vector<Block> blocks_;
};

}  // namespace photic
