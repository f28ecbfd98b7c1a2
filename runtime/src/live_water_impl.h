// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "photic/runtime_water.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/uniforms.h"

namespace photic::runtime {

/// Textures and buffers that are deleted only when the GlStateGuard made after this has put the game's bindings back:
/// it would otherwise bind names that are no more.
class Retired {
public:
    explicit Retired(const GlFunctions& gl) : gl_(gl) {}
    ~Retired() {
        if (!textures_.empty()) gl_.DeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
        if (!buffers_.empty()) gl_.DeleteBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
    }
    Retired(const Retired&) = delete;
    Retired& operator=(const Retired&) = delete;
    void texture(GLuint name) { textures_.push_back(name); }
    void buffer(GLuint name) { buffers_.push_back(name); }

private:
    const GlFunctions& gl_;
    std::vector<GLuint> textures_, buffers_;
};

/// What a LiveWater holds, for the passes that draw with it.
struct LiveWater::Impl {
    explicit Impl(const GpuContext& gpu) : context(gpu) {}
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    GpuContext context;
    const GlFunctions& gl = context.gl();
    // Textures and buffers; 0 while there are none.
    GLuint map = 0;                             ///< photic_water_map
    GLuint ray_starts = 0, ray_directions = 0;  ///< water_rays.frag.glsl
    GLuint caustics = 0;                        ///< photic_caustic_map
    GLuint volume_indices = 0, nearest = 0;     ///< nearest: a sampler
    GLuint framebuffer = 0, vertex_array = 0;
    GLuint ray_program = 0, mesh_program = 0, volume_program = 0, god_ray_program = 0;
    GLuint shadowed_volume_program = 0, shadowed_god_ray_program = 0;  ///< with PHOTIC_MOVERS; made when needed
    GLuint movers = 0;                                                 ///< a uniform buffer

    // What the textures were made for.
    int columns = 0, rows = 0;            ///< of the map
    int mesh_columns = 0, mesh_rows = 0;  ///< vertices
    int volume_step = 0;                  ///< that volume_indices are for
    std::size_t volume_index_count = 0;
    int layers = 0, resolution = 0;
    bool full_precision = false, periodic_map = false;
    bool rays_current = false;  ///< traced since heights or light changed

    WaterHeights water;                ///< `heights` is null: only where they lie
    double covariance[3] = {0, 0, 0};  ///< of the slopes
    WaterLight light;
    LookupOptions lookup;
    CausticMapOptions map_options;

    /// Uniforms of photic_water.glsl; takes one texture unit.
    void setWater(const Uniforms& uniforms, int unit) const;
    /// Those of photic_water_lookup.glsl, the water's included; one unit.
    void setLookup(const Uniforms& uniforms, int unit) const;
    /// Those of photic_caustic_map.glsl, the water's included; two units.
    void setCausticMap(const Uniforms& uniforms, int unit) const;

    /// A program, made when it is not there; with PHOTIC_MOVERS and what movers need bound where there are any.
    /// Inside a GlStateGuard. @throws Failure{Shader}, Failure{Usage} for movers that make no sense
    GLuint programFor(GLuint& plain, GLuint& shadowed, const char* vertex_file, const char* fragment_file,
                      const MoverShadows& shadows);
    /// Traces the mesh's vertices where heights or light have changed. Inside a GlStateGuard.
    Status traceRays(Retired& retired);
    /// Binds the indices of so many prisms, of a mesh of every `step`th vertex. Inside a GlStateGuard.
    Status bindVolumeIndices(int volumes, int step, Retired& retired);
    /// Number of triangles of the mesh.
    int triangles() const { return 2 * (mesh_columns - 1) * (mesh_rows - 1); }
};

/// What a texture holds.
struct TextureShape {
    GLenum target, format;
    int width, height, layers;
};

/// The name of a new texture, or Error{Memory} when GL says that its storage was not to be had.
Result<GLuint> makeTexture(const GlFunctions& gl, const TextureShape& shape, GLenum filter, GLenum wrap);

}  // namespace photic::runtime
