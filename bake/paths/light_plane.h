// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "bake/paths/emission.h"
#include "bake/paths/optical_scene.h"

namespace photic {

/// The plane across an emission's light through the middle of its surface, as far as the surface reaches there; for
/// closed, smooth meshes whose triangles are finer than the grid or hide one another: what such a mesh launches is then
/// divided by what becomes of the light and not by how the mesh was made. Nothing for other surfaces, which are
/// launched by their own triangles, and for lamps that stand close to the surface or in it.
std::optional<LightPlane> lightPlane(const OpticalScene& optics, const Emission& emission);

}  // namespace photic
