// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"

namespace photic {

/// a * max(0, s v)^b on a `caustic` grid [Mercier 2014, section 4.1]: with b > 1 high values stand out, with b < 1 low
/// ones.
/// @param sign  s: -1 where light converges at negative values, as for a front's curvature; 1 otherwise
void sharpenCaustic(LightField& caustic, double a, double b, double sign);

/// Speeds [voxels a layer] of a dissipating wave end here: below 1 / sqrt 2 the explicit scheme in two dimensions is
/// stable.
inline constexpr double kFastestDissipation = 0.7;

/// The paper's height threshold [Mercier 2014, section 3.3]: where first arrivals have met, light cannot spread again.
/// Below the plane z = `threshold` [m] each layer of a `caustic` grid is a step of a wave equation u_tt = c^2 lap u in
/// x and y that starts at rest from the layer above it, and what is negative is cut. That layer is smoothed first (a
/// deviation: its lines of one voxel would leave ripples).
///
/// @param speed  c [voxels a layer], at most 0.7 (stability: 1 / sqrt 2)
/// @throws Error{Input} for a sheared grid or a speed that is not stable
void dissipateCaustic(LightField& caustic, double threshold, double speed);

}  // namespace photic
