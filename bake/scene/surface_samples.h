// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// A place on a surface that stands for a part of it.
struct SurfaceSample {
    glm::dvec3 position{0}, normal{0, 0, 1};  ///< world [m]; unit
    double area = 0;                          ///< [m2]
};

/// Parameters of a height field, evenly spread over its patch where it is over the domain's footprint: about `count`.
/// Empty when it is not.
std::vector<glm::dvec2> placesOn(const Surface& surface, const Domain& domain, int count);

/// Places on a surface: of a height field over placesOn(), of a mesh on its triangles by their area. The same ones at
/// every call.
std::vector<SurfaceSample> samplesOf(const Surface& surface, const Domain& domain, int count);

/// Of a sun, the mean of its channels [W/m2].
inline double meanIrradiance(const Light& light) {
    return (light.irradiance.x + light.irradiance.y + light.irradiance.z) / 3;
}

}  // namespace photic
