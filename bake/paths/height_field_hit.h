// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <limits>

#include "bake/scene/scene.h"

namespace photic {

/// Where a ray meets a height field.
struct HeightFieldHit {
    double distance = std::numeric_limits<double>::infinity();  ///< [m]; infinity: nowhere
    glm::dvec3 position{0};                                     ///< on the surface [m]
    glm::dvec3 normal{0};                                       ///< unit, upwards
};

/// First crossing of a ray and a height field. The ray is walked through the layer between the field's lowest and
/// highest point by steps that the surface is smooth over, and the crossing found by bisection and secants to 1e-12 of
/// the step; crossings closer together than a step can be missed. A field with sideways displacement is found by
/// iteration of its parameter.
///
/// @param start         [m] crossings nearer than this are ignored: the surface that the ray leaves
/// @param max_distance  [m]
HeightFieldHit hitHeightField(const Surface& surface, const glm::dvec3& origin, const glm::dvec3& direction,
                              double start, double max_distance);

/// Whether a lamp stands below a height field: in the half-space below it, or, where nothing goes on beyond its patch,
/// under the patch. Suns shine from above.
bool standsBelow(const Light& light, const Surface& surface);

}  // namespace photic
