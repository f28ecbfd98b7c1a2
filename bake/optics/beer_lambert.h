// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace photic {

/// Mean of exp(-x') over x' in [0, x]: (1 - exp(-x)) / x, to full precision for every x >= 0, 0 included.
///
/// exp(-x) = 1 - x * meanTransmittance(x), so a walk in small steps needs no exponential.
inline double meanTransmittance(double optical_depth) {
    const double x = optical_depth;
    // Taylor up to x^6 / 7!: the next term, x^7 / 8!, is below 1e-16 here.
    if (x < 0.02)
        return 1.0 - x * (1.0 / 2 - x * (1.0 / 6 - x * (1.0 / 24 - x * (1.0 / 120 - x * (1.0 / 720 - x / 5040)))));
    return -std::expm1(-x) / x;
}

/// Mean transmittance of a homogeneous medium over [start, start + length] of a ray (Beer-Lambert):
/// exp(-sigma_t start) (1 - exp(-sigma_t length)) / (sigma_t length).
///
/// @param sigma_t  extinction [1/m], >= 0
/// @param start    distance already travelled in the medium [m]
/// @param length   of the segment [m], >= 0
inline double meanTransmittance(double sigma_t, double start, double length) {
    return std::exp(-sigma_t * start) * meanTransmittance(sigma_t * length);
}

}  // namespace photic
