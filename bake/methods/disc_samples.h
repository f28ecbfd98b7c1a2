// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/paths/optical_scene.h"
#include "bake/scene/scene.h"

namespace photic {

/// How many directions of a sun's disc stand for it where it is sampled: by how far its rim's light lands from its
/// middle's, in voxels (root mean square over rays through every surface, along their strongest branches). The samples
/// then lie half a voxel apart.
/// @param most  no more than these
int discSamples(const OpticalScene& optics, const Light& light, int most);

}  // namespace photic
