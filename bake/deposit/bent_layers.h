// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <utility>
#include <vector>

#include "bake/deposit/gauss_points.h"
#include "bake/deposit/slabs.h"
#include "bake/field/light_field.h"
#include "bake/tubes/bent_rows.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// Tubes with bent legs in one slab, each by itself.
struct BentTubes {
    const TubeSet& set;
    const BentRows& bent;
    /// Per tube: the cell of the launched front that it comes from. Neighbours are one apart along either axis, or
    /// none.
    std::span<const glm::ivec2> cells;
};

/// One tube of them.
struct BentTube {
    std::uint32_t number;     ///< in the set
    std::uint32_t corner[3];  ///< in TubeSet::corners
};

/// Calls visit(BentTube) for each of a block that carries power.
template <class Visit>
void forEachTube(const TubeSet& set, const TubeBlock& block, const Visit& visit) {
    for (std::uint32_t t = 0; t < block.topology->triangles.size(); ++t) {
        const BentTube tube{block.first_tube + t,
                            {block.first_corner + block.topology->triangles[t].corner[0],
                             block.first_corner + block.topology->triangles[t].corner[1],
                             block.first_corner + block.topology->triangles[t].corner[2]}};
        const float* power = set.tubes[tube.number].power;
        if (power[0] > 0 || power[1] > 0 || power[2] > 0) visit(tube);
    }
}

/// The same of all blocks.
template <class Visit>
void forEachTube(const TubeSet& set, const Visit& visit) {
    for (const TubeBlock& block : set.blocks) forEachTube(set, block, visit);
}

/// Where a tube crosses a plane in a layer, and what it leaves there.
struct TubeOnLayer {
    double u[3], v[3];  ///< of the corners [voxels] from BentRows::first_column
    double open = 0;    ///< mean part of the layer between its ends
    double lit = 0;     ///< mean of its corners: 1 where it has been in a medium
    float amounts[6];   ///< per channel, then along x, y, z [W m]: power x path, all that the layer point stands for
    double mean = 0;    ///< of the amounts' channels
    double area2 = 0;   ///< twice its signed area [voxels^2]
};

/// @param lane  of the slab, which starts at layer `first_w`
/// @return whether it is there at all
bool crossLayer(const BentTubes& tubes, const BentTube& tube, int first_w, int lane, const LayerPoint& point,
                FieldChannels channels, TubeOnLayer& out);

/// The lanes of a slab by the leaves that they lie in: different ones may be written from different threads.
/// @return first and last lane of each, the last exclusive
std::vector<std::pair<int, int>> lanesByLeaf(const Slab& slab);

}  // namespace photic
