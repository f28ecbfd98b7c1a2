// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace photic::runtime
