// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/eikonal_front.h"

namespace photic {

/// The light of a row of points, from their feet.
struct ShadedRow {
    float* share;                           ///< irradiance in units of the light's; below 0 above the surface
    float *wx, *wy, *wz;                    ///< direction of travel
    float *curvature, *arrival, *distance;  ///< null where nobody asks
};

/// What all points of a row have in common.
struct ShadeRow {
    double x0 = 0, step = 1, y = 0, z = 0;  ///< of the points [m]
    bool lit = true;                        ///< false: share is 1 below the surface
};

/// Shades `count` points from index `first` of a layer: T cos i / (cos t spread) of Fresnel's law at the feet. A voxel
/// is no point: its mean stays bounded where the rays of its centre meet.
void shadeRow(const EikonalFront& front, const FootPointLayer& layer, std::size_t first, int count, const ShadeRow& row,
              const ShadedRow& out);

}  // namespace photic
