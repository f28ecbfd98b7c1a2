// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/grid_frame.h"
#include "bake/scene/scene.h"

namespace photic {

/// The scene's voxel grid: domain, voxel size, shear ("light": the strongest light's mean refracted direction).
/// World (0,0,0) maps to a fixed place relative to voxel corners whatever the domain, so tiles of a bake line up:
/// without shear, voxel (i,j,k) covers [i h, (i+1) h] x ... and is centred at (i + 1/2) h. Where only receivers are
/// needed, the indices are moved by up to 7 voxels along each axis, so that flat receivers' bands fill the fewest
/// leaves; the voxels themselves stay where they are.
/// @throws Error{Input} for a box of more than 2^38 voxels or an empty one
GridFrame sceneFrame(const Scene& scene);

}  // namespace photic
