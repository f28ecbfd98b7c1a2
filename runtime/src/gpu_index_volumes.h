// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/bent_rays.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/index_atlas.h"

namespace photic::runtime {

struct GpuIndexVolumes::Impl {
    explicit Impl(const GpuContext& of) : context(of) {}
    ~Impl() { destroy(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void destroy();  ///< deletes the GL names
    /// Makes the textures. @throws Failure{Memory}
    void make(const std::vector<IndexVolume>& volumes);
    /// Textures to units 5 to 10, as photic_bent.glsl has them.
    void bind() const;

    GpuContext context;
    GLuint spline = 0, gradients = 0, attenuation = 0, glow = 0, faces = 0, block_reach = 0;
    /// Of each object, for its place in the world.
    struct Object {
        VoxelTransform transform;
        Double3 box_low, box_high;
        Int3 count;
        IndexAtlas::Place place;
        std::array<float, 3> scattering;
        float anisotropy = 0;
        std::array<float, 3> albedo;  ///< of faces
        float roughness = 0;
        bool reflects = false, matte = false, sharp = false, scatters = false, disperses = false;
    };
    std::vector<Object> objects;
    Info info;
};

}  // namespace photic::runtime
