// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "photic/runtime_water.h"

namespace photic::runtime {

/// What the water's texture holds: four floats a sample, height [m], slopes dh/dx and dh/dy, 0.
struct WaterTexels {
    std::vector<float> values;
    double covariance[3] = {0, 0, 0};  ///< means of sx sx, sx sy, sy sy of the slopes
};

/// Heights and their slopes by central differences, fourth order inside; at the rim of water that is flat outside,
/// second order and one-sided.
/// @return Error{Usage} for fewer than 4 samples a side, no size, or numbers that are not finite
Result<WaterTexels> waterTexels(const WaterHeights& heights);

/// Trace and determinant of the covariance of misalignment a (photic_water_lookup.glsl), to first order in the slopes:
/// of the refracted ray below the surface, then of the reflected one above it. One axis: variance and 0.
struct LookupCovariance {
    double trace_below = 0, determinant_below = 0, trace_above = 0, determinant_above = 0;
};
/// @param direction   unit, of the sun's travel
/// @param covariance  of the slopes, as in WaterTexels
LookupCovariance lookupCovariance(const float* direction, double ior, const double* covariance, LookupAxes axes);

}  // namespace photic::runtime
