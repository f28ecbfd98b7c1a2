// SPDX-License-Identifier: Apache-2.0
#pragma once

// A light volume as the bytes that a GPU takes, for games that are not GL: Vulkan, Direct3D 12, Metal, WebGPU.
//
//     auto bytes = photic::runtime::packVolume(volume);
//     ...make three 3D textures and a uniform buffer of bytes->light, ->colour, ->pages, ->parameters...
//     std::string glsl = "#version 450\n" + photic::runtime::volumeGlsl({.vulkan = VulkanBindings{}}) + my_shader;
//
// docs/volume_bytes.md says what each byte means. Nothing here needs GL.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "photic/result.h"
#include "photic/runtime.h"

namespace photic::runtime {

/// How a volume lies in GPU memory.
enum class Layout {
    Automatic,  ///< Dense where more than 70 % of the box's blocks have light, otherwise Atlas; Buffer when no texture
                ///< fits
    Atlas,      ///< a 3D texture of bricks and a table of pages
    Dense,      ///< one 3D texture of the whole box
    Buffer      ///< the bricks in a shader storage buffer: for 3D textures that are too small; always exact
};

enum class Filter {
    Hardware,  ///< one read; GPUs round weights to 1/256, which shows on spikes
    Exact      ///< eight reads, weighted in float
};

enum class Texels {
    AsInFile,  ///< blocks of BC6H where the file has them and the GPU reads them, else half floats
    Halves
};

enum class WhenTooLarge {
    Coarsen,  ///< double the voxels until it fits
    Refuse
};

struct UploadOptions {
    Layout layout = Layout::Automatic;
    Texels texels = Texels::AsInFile;
    Filter filter = Filter::Hardware;                 ///< of GL's programs; bytes are the same for both
    std::uint64_t budget = std::uint64_t{512} << 20;  ///< of GPU memory, for this volume [bytes]
    WhenTooLarge when_too_large = WhenTooLarge::Coarsen;
    int largest_texture_3d = 0;               ///< [texels a side]; 0: what GL says; 2048 for bytes
    std::uint64_t largest_storage_block = 0;  ///< [bytes]; 0: what GL says; 128 MiB for bytes
};

struct UploadInfo {
    Layout layout = Layout::Automatic;
    bool bc6h = false;                ///< compressed: two bytes a texel of flux and colour
    std::uint64_t bytes = 0;          ///< of GPU memory
    std::uint32_t bricks = 0;         ///< that hold light; 0 when dense
    std::uint32_t coarse_bricks = 0;  ///< of them, those whose voxels are twice as wide, where light is smooth
    double fill = 0;                  ///< part of the box's blocks of 8^3 that have light
    int coarsened = 0;                ///< how often the voxels were doubled
};

enum class TexelFormat { Rgba16Float, R32Float, R32Uint, R8, Rgba8, R8Uint, Rgba32Uint, Bc6hUnsigned, Bc6hSigned };

/// Texels of a 3D texture: x fastest, then y, then z, without padding. Of BC6H blocks of 4 x 4 texels in x and y, in
/// the same order.
struct TextureBytes {
    TexelFormat format = TexelFormat::Rgba16Float;
    std::array<std::uint32_t, 3> size{0, 0, 0};  ///< [texels]; 0: there is no such texture
    std::vector<unsigned char> texels;
};

/// A volume in one of the layouts. What the layout or a white volume does not need is empty.
struct VolumeBytes {
    UploadInfo info;
    TextureBytes light;   ///< flux.xyz, mean irradiance, over the reference irradiance; filtered linearly. BC6H: flux
    TextureBytes colour;  ///< red, green, blue, 0; of coloured volumes, and with BC6H of all
    TextureBytes pages;   ///< R32UI, read without a filter
    std::vector<unsigned char> bricks;          ///< Layout::Buffer: a storage buffer instead of the first two
    std::array<unsigned char, 208> parameters;  ///< the uniform block, std140
    /// Axes along which the light's and the colours' sampler is to repeat (of Layout::Dense only); else it clamps.
    std::array<bool, 3> sampler_repeats{false, false, false};
};

/// Packs as GpuVolume::upload does: tries layouts until one fits the budget and the limits, then coarser voxels.
/// @return Error{Limit}, Error{Memory}
Result<VolumeBytes> packVolume(const Volume& volume, const UploadOptions& options = {});

/// What a shader may take for granted of all volumes that are bound to it: saves tests.
enum class Known { Neither, No, Yes };

/// Where a Vulkan shader finds a volume: numbers within one descriptor set, no two alike.
struct VulkanBindings {
    unsigned set = 0;
    unsigned light = 0, colour = 1, pages = 2;  ///< combined image samplers; colour is declared for white volumes too
    unsigned parameters = 3;                    ///< uniform buffer
    unsigned bricks = 4;                        ///< storage buffer, for Layout::Buffer only
    unsigned movers = 5, mover_map = 6;         ///< uniform buffer and combined image sampler, with GlslOptions::movers
};

/// What volumeGlsl() is made for.
struct GlslOptions {
    std::string prefix = "photic";  ///< of every name, so that several volumes fit one shader: pondSample() ...
    unsigned first_texture = 0;     ///< as in GpuVolume::bind
    unsigned first_buffer = 0;
    /// Automatic: Atlas or Dense, whichever is bound. Buffer needs a shader of its own.
    Layout layout = Layout::Automatic;
    Filter filter = Filter::Hardware;
    std::optional<VulkanBindings> vulkan;  ///< for Vulkan, instead of first_texture and first_buffer
    Known coloured = Known::Neither;
    Known repeats = Known::Neither;  ///< along any axis
    /// What moves darkens the light (photic/movers.h): packMovers() bound to this uniform buffer, and Movers::map, or
    /// any 2D texture where there is none, to this unit. For Vulkan as VulkanBindings says.
    bool movers = false;
    unsigned mover_buffer = 1, mover_texture = 3;
};

/// GLSL for a game's own shader, to be put behind its #version: photicSample(), photicIrradiance(), photicInscatter(),
/// photicEmpty() and what they need (runtime/shaders/photic_volume.glsl, photic_medium.glsl).
std::string volumeGlsl(const GlslOptions& options = {});

}  // namespace photic::runtime
