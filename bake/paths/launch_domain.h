// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <string>

#include "bake/field/grid_frame.h"
#include "bake/scene/scene.h"

namespace photic {

/// The rectangle of a height field's parameter plane that light is launched through.
struct LaunchDomain {
    glm::dvec2 min{0}, max{0};  ///< (u, v) [m]; max <= min when no light can reach the grid
    /// False when some light leaves the surface so close to the horizontal (steeper than 50 to 1) that the rectangle
    /// had to be cut off.
    bool complete = true;

    bool empty() const { return !(max.x > min.x && max.y > min.y); }
    double area() const { return empty() ? 0.0 : (max.x - min.x) * (max.y - min.y); }
};

/// The smallest rectangle that is sure to hold every (u, v) from which `light` can get into the box of `frame` after
/// one event at `surface`; within the patch when nothing lies outside of it. Emitted power is what crosses this
/// rectangle.
///
/// Slopes are bounded by sampling the height field about as finely as its features (at most 128 x 128 points, with a
/// margin of 12 %); directions by the surface's slopes and the sun's disc, or by the way from a lamp to
/// each part of the surface; positions by the sheared box and the surface's heights. For meshes, which are launched
/// whole, the result is empty. Cost: some 16,000 surface points.
LaunchDomain launchDomain(const Scene& scene, const Surface& surface, const Light& light, const GridFrame& frame);

/// Why the scene's surfaces cannot be baked by rays; empty when they can.
std::string specularRefusal(const Scene& scene);

}  // namespace photic
