// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bake/volume/vdb_bytes.h"

namespace photic {

/// Calls put(voxel, values) for each active voxel of a grid, tiles included; `values` are its components.
template <class Put>
void forEachActiveVoxel(const VdbGrid& grid, Put put) {
    for (const VdbTile& tile : grid.tiles)
        for (int x = 0; x < tile.side; ++x)
            for (int y = 0; y < tile.side; ++y)
                for (int z = 0; z < tile.side; ++z) put(tile.origin + glm::ivec3(x, y, z), tile.value.data());
    const auto components = static_cast<std::size_t>(grid.components);
    std::vector<float> values(VdbGrid::kVoxels * components);
    for (const VdbLeaf& leaf : grid.leaves) {
        grid.values(leaf, values.data());
        const VdbGrid::Mask active = grid.mask(leaf);
        for (int i = 0; i < VdbGrid::kVoxels; ++i)
            if (active[static_cast<std::size_t>(i >> 6)] >> (i & 63) & 1)
                put(leaf.origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7),
                    values.data() + components * static_cast<std::size_t>(i));
    }
}

}  // namespace photic
