// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "bake/field/light_field.h"

namespace photic {

/// All channels at a point in index space, interpolated trilinearly between voxel centres; voxels that are not needed
/// count as dark. Flux is what is interpolated, never direction.
std::array<float, 8> sampleTrilinear(const LightField& field, const glm::dvec3& point_index);

/// The same voxels in the same places, with `shift` added to their indices.
LightField reindexed(const LightField& field, const glm::ivec3& shift);

/// The field on cubic voxels along the world's axes, as wide as the field's narrower side across z, for readers that
/// take no sheared grid. Voxel (i,j,k) covers [i h, (i+1) h] x ...; the box is that of the needed voxels' cells. Looked
/// up trilinearly at the centres: sums are kept to second order in the voxel size, but for light at the border.
/// @throws Error{Input} for more voxels than a grid can have
LightField resampledToAxes(const LightField& field);

}  // namespace photic
