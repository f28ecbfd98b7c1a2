// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "bake/field/grid_frame.h"
#include "bake/scene/scene.h"

namespace photic {

/// Whether light can oppose itself in a scene: several lights, or light that is turned round.
bool lightCanOppose(const Scene& scene);

/// The axis that parts a scene's light best into two lobes, each with one direction (docs/light_volume.md): of the
/// thirteen that join opposite corners, edges and sides of a cube, the one along which directions differ most where
/// light of different directions meets. Few, so that frames and tiles of a scene agree. It points the way of most of
/// the light. Nothing where the directions that meet differ so little along it (a variance of 0.004 of the light) that
/// one lobe tells it all.
///
/// A few thousand photons are followed on cells of a coarse grid. Cost: milliseconds; the same for any thread count.
std::optional<glm::dvec3> lobeAxis(const Scene& scene, const GridFrame& frame);

}  // namespace photic
