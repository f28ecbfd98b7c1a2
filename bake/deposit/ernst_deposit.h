// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"
#include "bake/report/monitor.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// Adds the light of `tubes` as [Ernst et al. 2005, section 3.4] does: at each voxel's centre, intensities of the
/// tube's three corners are interpolated as (sum of beta_i P_i) / (sum of beta_i A_i), where P_i and A_i are the power
/// and the area in the layer's plane of the tubes around corner i, and beta_i the centre's barycentric weights.
///
/// For comparison with the paper: it is smoother than constant density on coarse meshes, but not exact in energy, and
/// its denominator passes through 0 inside the tubes that fold (docs/methods.md). Deviations: areas are taken in the
/// layers' plane for all tubes (the paper flattens each fan to its own triangle), and irradiance stands for the paper's
/// ratio of areas. Fans end at the border of a batch of tubes. Cost: one point-in-triangle test per voxel centre in
/// each tube's box, one thread a row of leaves.
void depositErnst(const TubeSet& tubes, LightField& field, Monitor& monitor);

}  // namespace photic
