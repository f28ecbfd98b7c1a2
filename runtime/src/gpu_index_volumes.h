// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/bent_rays.h"
#include "runtime/src/bent_parameters.h"
#include "runtime/src/gl_functions.h"

namespace photic::runtime {

struct GpuIndexVolumes::Impl {
    explicit Impl(const GpuContext& of) : context(of) {}
    ~Impl() { destroy(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void destroy();  ///< deletes the GL names
    /// Makes the textures. @throws Failure{Memory}
    void make(const std::vector<IndexVolume>& volumes);
    /// Textures to units 5 to 10 and 12, as photic_bent.glsl has them.
    void bind() const;

    GpuContext context;
    GLuint spline = 0, gradients = 0, attenuation = 0, glow = 0, faces = 0, block_reach = 0, shapes = 0;
    IndexObjects placed;
    Info info;
};

}  // namespace photic::runtime
