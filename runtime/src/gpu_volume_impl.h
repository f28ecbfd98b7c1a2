// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/volume_layout.h"

namespace photic::runtime {

struct GpuVolume::Impl {
    explicit Impl(const GpuContext& of) : context(of) {}
    ~Impl() { destroy(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void destroy();  ///< deletes the GL names

    /// Samplers and the buffer of `parameters`, which must be there, and the reference irradiance that they hold.
    /// @param repeats  axes along which `sampler` is to repeat. @throws Failure{Memory}
    void makeSmallParts(const std::array<bool, 3>& repeats);

    /// Textures to units, parameters and bricks to buffer bindings, as GpuVolume::bind() says.
    void bind(unsigned first_texture, unsigned first_buffer, float weight);

    GpuContext context;
    GLuint light = 0, rgb = 0, pages = 0;     ///< 3D textures
    GLuint bricks = 0, parameter_buffer = 0;  ///< buffers
    GLuint sampler = 0;                       ///< trilinear; an axis repeats where the light does, in a dense texture
    GLuint page_sampler = 0;                  ///< nearest
    VolumeParameters parameters{};
    float reference_irradiance = 1;
    std::unique_ptr<GpuVolume> second;  ///< lobe, or null
    UploadInfo info;
    Filter filter = Filter::Hardware;
};

/// A 3D texture without content.
/// @param of  for the message: what the GPU has no memory left for
/// @throws Failure{Memory}
GLuint makeTexture3d(const GlFunctions& gl, GLenum format, const Int3& size, const char* of);

/// @throws Failure{Memory} where a GL error is pending
/// @param of  for the message: what was being made
void requireMemory(const GlFunctions& gl, const char* of);

/// Gives the bound buffer its content; errors that were pending are forgotten. @throws Failure{Memory}
void fillBuffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t size, GLenum use, const char* of);

/// @param buffer  set at once, so that its owner deletes it when something is thrown. @throws Failure{Memory}
void uploadBuffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t size, GLenum use, GLuint& buffer);

/// GL's limits, or narrower ones that were asked for.
GpuLimits limitsOf(const GlFunctions& gl, const UploadOptions& options);

/// Each lobe has the share of a volume's budget [bytes] that it has of its bytes.
std::uint64_t secondLobeBudget(const Volume& volume, const Volume& lobe, std::uint64_t budget);

}  // namespace photic::runtime
