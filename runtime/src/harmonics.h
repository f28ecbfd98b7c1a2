// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace photic::runtime {

/// What each of nine harmonics of the radiance adds to irradiance over pi, as a factor on the polynomials 1, y, z, x,
/// xy, yz, 3 z^2 - 1, xz, x^2 - y^2 of the direction that a face looks in (Ramamoorthi and Hanrahan 2001, eqs. 3, 8 and
/// 11).
std::array<double, 9> ambientFactors();

}  // namespace photic::runtime
