// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/report/monitor.h"

namespace photic {

/// Where faces are in samples of an index: 255 around them, else 0; empty where there are none.
/// @param excess  (n^2 - 1) / 2 at nodes, x fastest
/// @param widened  faces were steps, and have all been made wider by a deviation of a node
std::vector<std::uint8_t> faceNodes(const glm::ivec3& count, const std::vector<double>& excess, bool widened,
                                    Monitor& monitor);

}  // namespace photic
