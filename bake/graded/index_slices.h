// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/graded/front_kernel.h"
#include "bake/graded/spline_index.h"

namespace photic {

/// A spline whose nodes are the voxels of a grid, as fronts along one axis see it.
struct FrontFrame {
    int axis = 2;              ///< w; u and v are the next two, in turn
    glm::ivec3 first_node{0};  ///< voxel of the spline's node (0, 0, 0)
};

/// Collapses a spline in the middle planes of the steps of `layers` layers from `first_w` on, in the light's order.
/// @param steps  a layer
void collapseIndex(const SplineIndex& index, const FrontFrame& frame, int first_w, int layers, int sense, int steps,
                   IndexSlices& out);

}  // namespace photic
