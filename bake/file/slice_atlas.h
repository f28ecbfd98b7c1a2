// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/file/vdb.h"

namespace photic {

/// Lays the z slices of a volume out in one half-float EXR (flux.xyz + irradiance in RGBA; coloured: a second
/// EXR `NAME_rgb.exr` with irradiance per channel), cropped to the active voxels, and writes the JSON sidecar
/// `NAME.json` (docs/schemas/atlas.md). Sheared grids are resampled to an axis-aligned one first.
/// @param path  of the EXR
/// @throws Error{Input} when it would exceed 16384 texels a side, with the voxel size that fits; Error{Failed}
void writeSliceAtlas(const std::string& path, const LightVolume& volume);

}  // namespace photic
