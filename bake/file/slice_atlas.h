// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "bake/file/voxel_box.h"

namespace photic {

/// Lays the z slices of a volume out in one half-float EXR (flux.xyz + irradiance in RGBA; coloured: a second
/// EXR `NAME_rgb.exr` with irradiance per channel), cropped to the active voxels, and writes the JSON sidecar
/// `NAME.exr.json` (docs/schemas/atlas.md). Sheared grids are resampled to an axis-aligned one first.
/// @param path  of the EXR
/// @param box   to lay out instead of the voxels with light: one for all frames of a sequence, whose readers then need
/// one
///              sidecar. What lies beyond the volume is dark.
/// @throws Error{Input} when it would exceed 16384 texels a side, with the voxel size that fits; Error{Failed}
DenseWritten writeSliceAtlas(const std::string& path, const LightVolume& volume,
                             const std::optional<VoxelBox>& box = {});
/// The same as files of a set, which OutputSet::commit() renames.
DenseWritten writeSliceAtlas(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                             const std::optional<VoxelBox>& box = {});

}  // namespace photic
