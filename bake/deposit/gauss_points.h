// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace photic {

/// A plane in a layer of voxels, and what of the layer it stands for.
struct LayerPoint {
    double offset;  ///< 0 where light enters the layer, 1 where it leaves
    double weight;
};

/// Gauss and Legendre's points on [0, 1]. @param count  1, 2 or 4
inline std::vector<LayerPoint> gaussPoints(int count) {
    if (count == 1) return {{0.5, 1.0}};
    if (count == 2) return {{0.21132486540518712, 0.5}, {0.78867513459481288, 0.5}};
    return {{0.069431844202973712, 0.17392742256872693},
            {0.33000947820757187, 0.32607257743127307},
            {0.66999052179242813, 0.32607257743127307},
            {0.93056815579702629, 0.17392742256872693}};
}

}  // namespace photic
