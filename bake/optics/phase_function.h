// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace photic {

/// Henyey-Greenstein phase function (Henyey and Greenstein 1941) [1/sr]; its integral over the sphere is 1 and the mean
/// of cos_angle is `anisotropy`.
///
/// @param cos_angle   between the directions of travel before and after scattering; 1 is straight on
/// @param anisotropy  g, -1 < g < 1; 0 is isotropic
inline double henyeyGreenstein(double cos_angle, double anisotropy) {
    const double g = anisotropy;
    // 1 + g^2 - 2 g cos, written so that it does not cancel for strongly forward scattering.
    const double base = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_angle);
    return (1.0 - g * g) / (4.0 * std::numbers::pi * base * std::sqrt(base));
}

}  // namespace photic
