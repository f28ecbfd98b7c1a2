// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "bake/file/vdb.h"

namespace photic {

/// Voxels from min to max, both inside, of the grid that an atlas is laid out from: the volume's own, or the straight one
/// that a sheared volume is resampled to.
struct AtlasBox {
    glm::ivec3 min{0}, max{-1};
};

/// The voxels of `volume` with light; nothing when it is dark.
std::optional<AtlasBox> litBox(const LightVolume& volume);

/// The smallest box around both; nothing when neither is there.
std::optional<AtlasBox> together(const std::optional<AtlasBox>& a, const std::optional<AtlasBox>& b);

/// Lays the z slices of a volume out in one half-float EXR (flux.xyz + irradiance in RGBA; coloured: a second
/// EXR `NAME_rgb.exr` with irradiance per channel), cropped to the active voxels, and writes the JSON sidecar
/// `NAME.json` (docs/schemas/atlas.md). Sheared grids are resampled to an axis-aligned one first.
/// @param path  of the EXR
/// @param box   to lay out instead of the voxels with light: one for all frames of a sequence, whose readers then need one
///              sidecar. What lies beyond the volume is dark.
/// @throws Error{Input} when it would exceed 16384 texels a side, with the voxel size that fits; Error{Failed}
void writeSliceAtlas(const std::string& path, const LightVolume& volume, const std::optional<AtlasBox>& box = {});

}  // namespace photic
