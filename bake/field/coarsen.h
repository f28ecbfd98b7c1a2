// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/light_field.h"
#include "bake/report/monitor.h"

namespace photic {

enum class CoarseCentres {
    OfTheirCells,  ///< in the middle of the fine voxels that they cover
    OnFineOnes     ///< coarse voxel I at the centre of fine voxel factor * I, so that both levels share these
};

/// The field on voxels `factor` times as wide: those values whose trilinear look-up at the centres of the needed voxels
/// of `field` is nearest to what they hold, by least squares. Coarse voxel I covers the voxels factor * I ... factor *
/// I + factor - 1. Against means over cells this takes the look-up's own blur out, and where the needed voxels end
/// (below a floor) nothing dark is mixed in. Irradiance stays >= 0 and |flux| at most the mean irradiance.
///
/// The normal equations are solved by conjugate gradients with the diagonal as preconditioner; the matrix is as
/// well-conditioned as a mass matrix of trilinear elements, so that a dozen steps do.
/// @param factor  2, 4, 8 ...
/// @param centres  of the coarse voxels
/// @throws Error{Cancelled}
/// Cost: about 20 ns a voxel, channel and step; memory: four copies of the coarse field.
LightField coarsened(const LightField& field, int factor, const Monitor& monitor,
                     CoarseCentres centres = CoarseCentres::OfTheirCells);

}  // namespace photic
