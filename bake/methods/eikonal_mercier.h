// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/eikonal_grid.h"

namespace photic {

/// The paper's seeds [Mercier 2014, algorithm 1]: each vertex of a mesh of the surface gives the cell that it falls in
/// its distance to the cell's centre, or less. Cells above the surface are left out of the domain.
/// @param spacing  of the vertices [voxels]
void seedByVertices(const EikonalFront& front, double spacing, EikonalGrid& grid);

/// The paper's treatment of the four vertical sides [Mercier 2014, algorithm 2]: the front is first followed down the
/// edges, then over each side in two passes, one at cost 1 that carries the cost F from the surface to every cell, and
/// one at that cost. The paper's text gives F = alpha = 1 / cos(theta) while its figure has the front move alpha times
/// faster, which is a cost of F = cos(theta): that is used.
void costsAtSides(const EikonalFront& front, EikonalGrid& grid);

}  // namespace photic
