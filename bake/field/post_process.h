// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"

namespace photic {

/// Inverts the blur of a trilinear look-up: [1/8, 3/4, 1/8]^-1 per axis (two-sided recursive filter on runs of needed
/// voxels, mirrored at their ends), irradiance clamped at 0, then |flux| <= irradiance restored. docs/light_volume.md.
void prefilterForTrilinear(LightField& field);

/// Restores |flux| <= mean irradiance (rounding, filters).
void restoreFluxBound(LightField& field);

/// Turns leaves whose voxels agree within `relative` into Constant, and leaves whose irradiance is everywhere below
/// `threshold` [W/m2] into Empty. Returns the number of leaves changed.
int collapseConstantLeaves(LightField& field, double relative, double threshold);

}  // namespace photic
