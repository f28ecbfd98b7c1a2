// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"

namespace photic {

/// Restores |flux| <= mean irradiance (rounding, filters).
void restoreFluxBound(LightField& field);

/// Turns leaves whose voxels agree within `relative` of their largest irradiance into Constant (their mean), and leaves
/// whose irradiance is everywhere at most `threshold` [W/m2] into Empty. Returns the number of leaves changed.
int collapseConstantLeaves(LightField& field, double relative, double threshold);

}  // namespace photic
