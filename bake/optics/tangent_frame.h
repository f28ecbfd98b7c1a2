// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace photic {

/// Two unit vectors across a direction, and across one another.
struct TangentFrame {
    glm::dvec3 across{0}, up{0};
    /// @param direction  unit
    explicit TangentFrame(const glm::dvec3& direction)
        : across(glm::normalize(
              glm::cross(direction, std::fabs(direction.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)))),
          up(glm::cross(across, direction)) {}
};

}  // namespace photic
