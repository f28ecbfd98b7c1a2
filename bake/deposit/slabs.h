// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bake/field/needed_voxels.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// Some consecutive layers that one pass of the kernel sums.
struct Slab {
    int first = 0;   ///< layer
    int active = 0;  ///< layers that anybody needs, from `first` on
    int lanes = 16;  ///< 4, 8 or 16, at least `active`
};

/// Slabs that share leaves, to be summed one after the other, and the tiles where they are needed.
struct SlabGroup {
    std::vector<Slab> slabs;
    struct Tile {
        int u = 0, v = 0;  ///< first voxel, multiple of 8
    };
    std::vector<Tile> tiles;
    bool rectangle = false;  ///< the tiles cover the whole frame: tubes are counted against the frame, not tile by tile
};

/// Cuts the needed voxels into groups of slabs along `axis`. Those of a part are the whole's, in the part's tiles, so
/// that its sums are too.
/// @param max_lanes  4, 8 or 16
std::vector<SlabGroup> planSlabs(const NeededVoxels& needed, int axis, int tile_size, int max_lanes);

}  // namespace photic
