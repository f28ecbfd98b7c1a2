// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/file/vdb.h"

namespace photic {

/// @throws Error{Usage} for what is no step, before any work
void checkPostSteps(const std::vector<std::string>& steps);

/// Applies steps to the `caustic` grid of a volume, in their order, and notes them in its metadata.
///   sharpen=A,B       a * max(0, v)^b
///   dissipate=Z,SPEED below the plane z = Z [m] each layer is a step of a wave of SPEED voxels a layer
/// A front's curvature, which is negative where light converges, is turned round first.
/// @throws Error{Usage} for what is no step; Error{Input} when the volume has no caustic grid
void applyPostSteps(const std::vector<std::string>& steps, LightVolume& volume);

/// Makes the caustic grid the light: irradiance = caustic * reference irradiance, directions kept.
/// @throws Error{Input} when the volume has no caustic grid or no direction
void causticAsLight(LightVolume& volume);

}  // namespace photic
