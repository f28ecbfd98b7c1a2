// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/field/disc_blur.h"
#include "bake/scene/scene.h"

namespace photic {

/// Directions of equal weight on a light's disc, evenly spread (Vogel's spiral); the light's own direction for a point sun.
std::vector<glm::dvec3> discDirections(const Light& light, int count);

/// Whether one blur per layer serves the light: a height field that refracts or reflects gently, and nothing that casts
/// a silhouette.
bool blurServes(const Scene& scene);

/// The disc's image in each z layer of the grid after one event at the surface's mean plane: depth x d(slope)/d(direction).
std::function<LayerKernel(int)> discKernels(const Surface& surface, const Light& light, const GridFrame& frame);

}  // namespace photic
