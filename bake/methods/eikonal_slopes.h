// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bake/methods/eikonal_grid.h"

namespace photic {

/// Slopes of the rays of a marched front, layer by layer from above, by differences of the arrivals; straight down
/// where nothing is known. Three layers of arrivals are kept in rows, since blocks are slow to ask cell by cell.
class RaySlopes {
public:
    explicit RaySlopes(const EikonalGrid& grid);

    /// Layer z of the grid's box, x fastest: run to the side per layer [cells], and the fall of the unit direction, at
    /// least 0.1. Layers are quickest in descending order.
    void layer(int z, std::vector<double>& slope_x, std::vector<double>& slope_y, std::vector<double>& fall);

private:
    const double* rows(int z);
    void fill(int z, std::vector<double>& out) const;

    const EikonalGrid& grid_;
    std::size_t pitch_;  // of rows with one cell more at either end
    std::vector<double> layers_[3];
    int held_[3];
};

}  // namespace photic
