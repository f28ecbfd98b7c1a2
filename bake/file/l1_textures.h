// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "bake/file/texture_3d.h"

namespace photic {

/// What a face gets of light, by its harmonics of order 0 and 1: E(n) = L0 + dot(L1, n).
///
/// The light that arrives from the directions -w has the mean phi / (4 pi) and the first moment F. A face's cosine,
/// max(0, c), is 1/4 + c/2 and terms of higher order, so that
///     E(n) = phi / 4 - dot(F, n) / 2,
/// with phi the scalar irradiance and F the flux: the least squares over all normals. For light of one direction it is
/// off by phi / sqrt(48) in the root mean square; a look-up of flux and irradiance is exact there
/// (docs/light_volume.md), and better where an engine can make one.
struct L1Irradiance {
    float l0 = 0;
    std::array<float, 3> l1{};
};
inline L1Irradiance l1Irradiance(float irradiance, const glm::vec3& flux) {
    return {0.25f * irradiance, {0 - 0.5f * flux.x, 0 - 0.5f * flux.y, 0 - 0.5f * flux.z}};  // 0, not -0, in the dark
}

/// Writes a volume as three RGBA16F 3D textures, NAME_0, NAME_1 and NAME_2, as light volumes of VRChat and of Bakery
/// have them: (L0 r, g, b, L1 r z), (L1 r x, g x, b x, L1 g z), (L1 r y, g y, b y, L1 b z), along Unity's axes (y up,
/// left-handed), in units of the reference: a sun of intensity 1 lights a white face to 1. The metadata are
/// NAME.EXT.json.
/// @param format  Ktx2 or Dds
/// @throws as writeTextures()
DenseWritten writeL1Textures(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                             TextureFormat format, const std::optional<VoxelBox>& box = {});

/// The three files' names.
std::array<std::string, 3> l1Paths(const std::string& path);

}  // namespace photic
