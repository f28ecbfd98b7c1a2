// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/numerics/foot_point.h"

namespace photic {

/// A row of points of a layer.
struct FootRow {
    std::size_t first = 0;                  ///< index of its first point
    int count = 0;                          ///< rounded up to whole registers where it is worked on
    double x0 = 0, step = 1, y = 0, z = 0;  ///< of the points
    double apart = 1;                       ///< feet closer than this belong to the same sheet of rays [m]
};

struct FootKernels {
    /// Guesses feet in `here` from the layer above it and the feet of the layer above that, which `here` still holds.
    void (*guess)(const FrontOnSurface&, const FootRow&, const FootPointLayer& above, FootPointLayer& here);
    /// Newton's method from the guesses in foot_x, foot_y; fills the row.
    void (*solve)(const FrontOnSurface&, const FootRow&, FootPointLayer& here);
    /// Whether a neighbour in the layer knows a better foot for any point of the row.
    bool (*improvable)(const FrontOnSurface&, const FootRow&, double margin, const FootPointLayer& here);
};

/// The fastest that this processor can run (bestInstructionSet).
FootKernels footKernels();

}  // namespace photic
