// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "bake/file/brick_pages.h"
#include "bake/file/vdb.h"

namespace photic {

/// The GPU memory that the run-time library takes for a volume (docs/files.md): bricks of 9^3 RGBA16F texels and a
/// table of pages, or one dense texture where more than 70 % of the box's pages have bricks. Coloured volumes take
/// twice the texels. As BC6H (CompressedLight) a brick is 12 x 12 x 9 texels of two bytes, and one texture is taken
/// where that is smaller. Blocks of 16^3 voxels that `coarse_blocks` of the metadata marks take one brick each.
struct RuntimeSize {
    std::int64_t bricks = 0;  ///< that hold light, of both levels
    std::int64_t coarse = 0;  ///< of them, those of 16^3 voxels
    std::int64_t pages = 0;   ///< of 8^3 voxels, in the box
    bool dense = false;
    std::int64_t bytes = 0;
};

enum class GameTexels { Halves, Bc6h };

RuntimeSize runtimeSize(const LightVolume& volume, GameTexels texels = GameTexels::Halves);
/// Of one lobe.
RuntimeSize runtimeSize(const BrickPages& pages, FieldChannels channels, const CoarseBlocks& coarse, GameTexels texels);

/// How far (0..7 along each axis) to move the indices of a volume's voxels so that the fewest bricks hold them: a
/// floor's band that lies in one layer of bricks instead of across two. 0 for boxes too large to try it.
glm::ivec3 fewestBricksShift(const LightVolume& volume);

/// Bytes of dense RGBA16F textures of `texels`.
std::int64_t denseTextureBytes(std::int64_t texels, FieldChannels channels);

}  // namespace photic
