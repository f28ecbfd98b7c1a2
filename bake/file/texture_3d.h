// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bake/file/voxel_box.h"

namespace photic {

/// Files that hold a dense 3D texture (docs/files.md).
enum class TextureFormat {
    Ktx2,    ///< RGBA16F: flux.xyz + irradiance; metadata inside
    Dds,     ///< the same texels, DX10 header; metadata in NAME.EXT.json
    UnityVf  ///< 32-bit floats, axes turned to Unity's: irradiance, and NAME_flux.vf; metadata in NAME.EXT.json
};

/// Writes a light volume as dense 3D textures, cropped to the voxels with light (or to `box`): flux and irradiance in
/// units of the reference, |flux| <= irradiance after rounding too; coloured volumes get a second texture NAME_rgb with
/// irradiance per channel and their mean. Sheared grids are resampled to straight cubic voxels first. Written slice by
/// slice: memory does not follow the size of the texture.
/// @throws Error{Input} for more than 2048 texels a side, with the voxel size that fits; Error{Failed}: nothing is left
/// half-written
DenseWritten writeTextures(const std::string& path, const LightVolume& volume, TextureFormat format,
                           const std::optional<VoxelBox>& box = {});
/// The same as files of a set, which OutputSet::commit() renames.
DenseWritten writeTextures(OutputSet& outputs, const std::string& path, const LightVolume& volume, TextureFormat format,
                           const std::optional<VoxelBox>& box = {});

/// The texels of one lobe, x fastest.
struct LobeTexels {
    std::vector<std::uint16_t> light;  ///< bits of RGBA16F: flux x, y, z and irradiance
    std::vector<std::uint16_t> rgb;    ///< of coloured volumes: irradiance per channel and their mean
};

/// The same texels in memory, for what carries them in files of its own.
struct DenseTexels {
    glm::ivec3 size{0};
    glm::dmat4 world_from_texture{1.0};  ///< from texture coordinates 0..1, texel (0, 0, 0) centred at half a texel
    LobeTexels first;
    std::optional<LobeTexels> second;
    std::int64_t clamped = 0;
};
/// @throws Error{Input} for more than 2048 texels a side
DenseTexels denseTexels(const LightVolume& volume, const std::optional<VoxelBox>& box = {});

}  // namespace photic
