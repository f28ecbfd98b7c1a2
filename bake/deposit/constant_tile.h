// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "bake/deposit/edge_kernel.h"

namespace photic {

/// Whether a few wide tubes of equal density (a flat surface) fill the whole tile in all of its layers, so that its
/// leaves are constant and nothing needs to be summed.
///
/// @param values  out, per channel: power x path length per voxel [W m]
/// @return false whenever in doubt: many tubes, an attenuating medium, a rim, an end or the surface inside the tile
bool constantTile(const TubeSet& set, const std::vector<std::uint32_t>& blocks, const TileSums& tile, float* values);

}  // namespace photic
