// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "bake/paths/row_trace.h"

namespace photic {

/// How much the light of a strip of lattice rows bends between neighbours: second differences of the landing points, in
/// voxels, along the rows, across them, and along the cells' diagonals.
class BendRows {
public:
    /// @param rays     rows + 1 rows, and one more in memory on either side
    /// @param floor_w  the grid's last face along the light; rays that end earlier land where they end
    void measure(const RayRow* rays, int rows, double floor_w);

    /// The larger bend at the ends of the edge from corner (i, row) to (i + di, row + dj), along that edge.
    double ofEdge(int i, int row, int di, int dj) const {
        const std::vector<float>& bend = bend_[di && dj ? 2 : di ? 0 : 1];
        return std::max(bend[at(i, row)], bend[at(i + di, row + dj)]);
    }
    /// The largest of the edges of a block.
    double most(int first, int columns) const;
    /// Whether neighbours in a block end more than a layer apart inside the grid, though their rays are more than a
    /// voxel apart: on a slope or a wall.
    static bool endsApart(const RayRow* rays, int rows, int first, int columns, double floor_w);

private:
    std::size_t at(int i, int row) const { return static_cast<std::size_t>(row * stride_ + i); }
    int stride_ = 0, rows_ = 0;
    std::vector<float> bend_[3];
};

}  // namespace photic
