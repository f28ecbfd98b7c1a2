// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"

namespace photic {

/// Inverts the blur of a trilinear look-up: [1/8, 3/4, 1/8]^-1 per axis, solved exactly on runs of voxels that are
/// needed and lit, mirrored at their ends (x[-1] = x[0]). Voxels hand light to their neighbours: sums are kept, and
/// what is even stays so, up to the ends. A voxel keeps at least half of the least of itself and its neighbours, which
/// limits the sharpening beside darkness; then |flux| <= irradiance is restored. docs/light_volume.md says what it does
/// to a reader. Cost: three passes over the leaves with light; beside the field, two rows of leaves with all channels a
/// thread.
void prefilterForTrilinear(LightField& field);

}  // namespace photic
