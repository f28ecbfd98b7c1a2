// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/vec2.hpp>

namespace photic {

/// The i-th point of Roberts' R2 sequence (M. Roberts 2018, the plastic number) in the unit square: any number of them
/// from 0 on is spread evenly, and so are those a step apart from any place of it.
inline glm::dvec2 scatteredPoint(double i) {
    const double x = 0.5 + 0.7548776662466927 * i, y = 0.5 + 0.5698402909980532 * i;
    return {x - std::floor(x), y - std::floor(y)};
}

}  // namespace photic
