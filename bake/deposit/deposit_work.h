// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/deposit/voxelise.h"
#include "bake/field/grid_frame.h"
#include "bake/tubes/bent_rows.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// What summing some tubes takes, counted as the edge kernel goes about it and not done: it looks at a tube in all
/// layers of a slab at once, and at every voxel that an edge passes in any of them.
struct DepositWork {
    double tubes = 0;  ///< a tube in a slab, at one point of its layers
    double cells = 0;  ///< a column of voxels of a slab along the edges of such a tube, which it shares with another

    DepositWork operator*(double times) const { return {times * tubes, times * cells}; }
    DepositWork& operator+=(const DepositWork& other) {
        tubes += other.tubes, cells += other.cells;
        return *this;
    }
};

/// As if every voxel of the frame were needed.
/// @param options  its quadrature and has_edges count
DepositWork depositWork(const TubeSet& tubes, const GridFrame& frame, const VoxeliseOptions& options);

/// Of bent tubes in one slab of `layers` layers, at one point of each.
DepositWork depositWork(const TubeSet& tubes, const BentRows& bent, const GridFrame& frame, int layers);

}  // namespace photic
