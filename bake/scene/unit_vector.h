// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace photic {

/// v / |v| for any finite v but 0, without overflow.
template <glm::length_t N>
glm::vec<N, double> unitVector(glm::vec<N, double> v) {
    double largest = 0;
    for (glm::length_t i = 0; i < N; ++i) largest = std::max(largest, std::fabs(v[i]));
    return glm::normalize(v / largest);
}

}  // namespace photic
