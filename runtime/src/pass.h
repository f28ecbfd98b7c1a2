// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/shader_source.h"
#include "runtime/src/uniforms.h"

namespace photic::runtime {

/// A full-screen pass: one fragment shader of runtime/shaders in its variants, compiled when first needed.
class FullScreenPass {
public:
    FullScreenPass(const GpuContext& context, const char* fragment_file) : context_(context), file_(fragment_file) {}
    ~FullScreenPass();
    FullScreenPass(const FullScreenPass&) = delete;
    FullScreenPass& operator=(const FullScreenPass&) = delete;

    const GlFunctions& gl() const { return context_.gl(); }

    /// That for the layout and the filter of a volume with movers, whose parameters are bound too: uniform buffer 1 and
    /// texture unit 3. @throws Failure{Usage} for movers that make no sense
    GLuint programFor(const GpuVolume& volume, const MoverShadows& shadows);

    /// Movers' parameters to uniform buffer 1, and their map to texture unit 3, for a program with PHOTIC_MOVERS.
    /// @throws Failure{Usage} for movers that make no sense
    void bindMovers(const MoverShadows& shadows);

    /// The program with these defines. @throws Failure{Shader}
    GLuint program(const std::vector<Define>& defines = {});
    /// That for the layout and the filter of a volume, with more defines.
    GLuint programFor(const GpuVolume& volume, std::vector<Define> defines = {});

    /// Binds the G-buffer's textures to units 4 to 6, without filters of the game's, and sets the uniforms of
    /// g_buffer.glsl.
    void bindGBuffer(const Uniforms& uniforms, const GBuffer& surfaces);

    /// A 2D texture without filters of the game's.
    void bindNearest(unsigned unit, GLuint texture);

    /// Draws over the whole viewport with the program in use.
    void drawTriangle();

    /// The context is lost.
    void abandon();

private:
    GpuContext context_;
    const char* file_;
    std::map<std::string, GLuint> programs_;
    GLuint vertex_array_ = 0, nearest_ = 0;  ///< nearest_: a sampler
    GLuint movers_ = 0;                      ///< a uniform buffer
};

/// Binds the target and its viewport. @throws Failure{Usage} for a target without pixels
void bindTarget(const GlFunctions& gl, const Target& target);

/// A sampler without filters, for the textures of a G-buffer.
GLuint makeNearestSampler(const GlFunctions& gl);

/// What FullScreenPass::bindGBuffer does, for passes that draw something else.
void bindGBuffer(const GlFunctions& gl, const Uniforms& uniforms, const GBuffer& surfaces, GLuint nearest);

/// Movers' parameters to uniform buffer 1, in a buffer that is made when it is 0, and their map to texture unit 3, for
/// a program with PHOTIC_MOVERS. @throws Failure{Usage} for movers that make no sense
void bindMovers(const GlFunctions& gl, const MoverShadows& shadows, GLuint& buffer, GLuint nearest);

/// The volumes with their second lobes as volumes beside them.
/// @throws Failure{Usage} unless all volumes are there
std::vector<LitVolume> allLobes(const std::vector<LitVolume>& volumes);

}  // namespace photic::runtime
