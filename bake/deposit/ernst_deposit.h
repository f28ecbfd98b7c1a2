// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/deposit/ernst_fans.h"
#include "bake/field/light_field.h"
#include "bake/report/monitor.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// Adds the light of one set of tubes as [Ernst et al. 2005, sections 3.3 and 3.4] do: at each voxel's centre p, at the
/// depth alpha behind the tube's own triangle, where the plane parallel to the triangle cuts the tube's rays in a
/// triangle that holds p, the light through that plane is
///
///     I = sum of beta_i P_i / sum of beta_i A_i(alpha),  A_i(alpha) = a_i + alpha b_i + alpha^2 c_i
///
/// with the barycentric weights beta_i of p and the fan around corner i, flattened into the triangle's plane
/// (ErnstFans).
///
/// For comparison with the paper: it is smoother than constant density on coarse meshes, but not exact in energy, and
/// its denominator passes through 0 inside the tubes that fold (docs/methods.md). Deviations: P_i is the power of the
/// flattened fan, where the paper has its area a_i: the same where light falls evenly on the fan, and it keeps the
/// steps out that light of its own strength on each triangle would make. Fluence follows from the light through the
/// plane by the angle between them. Fans end at the border of a batch of tubes.
///
/// Cost: one point-in-triangle test per voxel centre in each tube's box, one thread a row of leaves.
/// @param tubes  number `set` of those that `fans` were made of
/// @throws Error{Cancelled}
void depositErnst(const TubeSet& tubes, const ErnstFans& fans, std::size_t set, LightField& field, Monitor& monitor);

}  // namespace photic
