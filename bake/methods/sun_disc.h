// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/mat2x2.hpp>
#include <string>

#include "bake/field/disc_blur.h"
#include "bake/scene/scene.h"

namespace photic {

/// Why one blur per layer cannot show a sun's disc in a scene; empty where it can: one height field that refracts or
/// reflects.
std::string blurRefusal(const Scene& scene);

/// Whether one blur per layer serves the light: one height field that refracts or reflects gently, and either nothing
/// that casts a silhouette or a disc that reaches at most one voxel anywhere in the frame. The blur is also laid over
/// shadows, whose penumbrae it makes as wide as those of a blocker at the surface: an error below its own reach.
bool blurServes(const Scene& scene, const Light& light, const GridFrame& frame);

/// How far the disc's image reaches in the grid along x and y, at most [voxels].
double blurReach(const Surface& surface, const Light& light, const GridFrame& frame);

/// How far the disc's rim moves where light lands, after one event at the surface's mean plane: the image of two of its
/// radii at right angles, in world x and y for each metre of depth.
glm::dmat2 discSlopes(const Surface& surface, const Light& light);

/// The disc's image in each z layer of the grid after one event at the surface's mean plane: depth x
/// d(slope)/d(direction).
std::function<LayerKernel(int)> discKernels(const Surface& surface, const Light& light, const GridFrame& frame);

}  // namespace photic
