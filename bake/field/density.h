// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <memory>

#include "bake/field/light_field.h"
#include "bake/scene/scene.h"

namespace photic {

/// The point of a height field that lies above or below a world position: undoes horizontal displacement.
/// @param xy  world [m]
SurfacePoint surfaceAbove(const HeightField& surface, const glm::dvec2& xy);

/// The `density` grid: 1 in voxels inside the medium, 0 above the surface; in the voxels that the surface crosses the
/// filled fraction, clamp((h - z) / layer height + 1/2). Zero without a refracting surface.
///
/// Inside is where the nearest crossing of the voxel's column above is a surface seen from its `ior_below` side
/// (meshes: the side away from the normal); an open mesh fills only the columns that it covers.
/// Cost: one surface evaluation a voxel between the lowest and the highest point of a height field; one visit a column
/// and covering triangle for meshes.
LightField mediumDensity(const Scene& scene, std::shared_ptr<const NeededVoxels> needed);

}  // namespace photic
