// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace photic {

/// How the absorption of a body differs from place to place, in the body's own axes.
struct AbsorptionPattern {
    /// Absorption per channel [1/m] at heights along z [m], lowest first; straight between them, and as at the ends
    /// beyond. Empty: it is the same at all heights.
    std::vector<std::pair<double, glm::dvec3>> painted;
    double noise = 0;       ///< 0 to 1: absorption goes from 1 - noise to 1 + noise times what it would be
    double noise_size = 0;  ///< [m] of the largest lumps
    int octaves = 3;        ///< of lumps, each half as large as the one before, and half as strong
    std::uint32_t seed = 1;

    bool varies() const { return !painted.empty() || noise > 0; }
    /// @param even  absorption of the body where nothing is painted [1/m]
    glm::dvec3 at(const glm::dvec3& place, const glm::dvec3& even) const;
};

}  // namespace photic
