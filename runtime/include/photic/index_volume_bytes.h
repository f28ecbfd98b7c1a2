// SPDX-License-Identifier: Apache-2.0
#pragma once

// Index volumes as the bytes that a GPU takes, for games that are not GL: Vulkan, Direct3D 12, Metal, WebGPU.
//
//     auto bytes = photic::runtime::packIndexVolumes(*glass);
//     ...make seven textures of bytes->spline, ->gradients, ->attenuation, ->glow, ->faces, ->blocks, ->shapes...
//     auto block = photic::runtime::packBentParameters(camera, *bytes, {{0}});   // each frame: a uniform buffer
//     std::string glsl = "#version 450\n" + photic::runtime::bentGlsl({.vulkan_set = 0}) + my_shader;
//
// docs/index_volumes.md says what each byte means. Nothing here needs GL.

#include <array>
#include <memory>
#include <vector>

#include "photic/bent_rays.h"
#include "photic/index_volume.h"
#include "photic/volume_bytes.h"

namespace photic::runtime {

struct IndexObjects;

/// Several objects in one atlas. A texture that no object needs has one texel of zeros.
struct IndexVolumeBytes {
    GpuIndexVolumes::Info info;
    TextureBytes spline;       ///< R32Float, an array of 2D layers, gathered: for IndexLookup::Spline
    TextureBytes gradients;    ///< Rgba16Float, filtered linearly: for IndexLookup::Gradients
    TextureBytes attenuation;  ///< Rgba16Float, filtered
    TextureBytes glow;         ///< Rgba16Float, filtered
    TextureBytes faces;        ///< R8 or, with coats, Rgba8, filtered
    TextureBytes blocks;       ///< R8Uint, not filtered
    TextureBytes shapes;       ///< Rgba32Uint, 2D, not filtered: sharp faces, for BentGlslOptions::shapes
    std::shared_ptr<const IndexObjects> objects;  ///< what packBentParameters() must know of them
};

/// Packs as GpuIndexVolumes::upload does.
/// @param largest_texture  [texels a side, or layers]
/// @return Error{Usage} without objects, Error{Limit} when no texture holds them, Error{Memory}
Result<IndexVolumeBytes> packIndexVolumes(const std::vector<IndexVolume>& objects, int largest_texture = 2048);

/// The uniform block of bentGlsl()'s shaders, std140: where the objects stand and how rays are followed.
/// @param origin  of the places that photicBentRadiance() takes [m], three numbers: the camera as a rule
/// @param surroundings  of which only what matte faces see of it counts
/// @return Error{Usage}
Result<std::vector<unsigned char>> packBentParameters(const float* origin, const IndexVolumeBytes& bytes,
                                                      const std::vector<PlacedObject>& placed,
                                                      const BentRayOptions& options = {},
                                                      const Surroundings& surroundings = {});

}  // namespace photic::runtime
