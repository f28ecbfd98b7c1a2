// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <utility>

#include "runtime/src/gl_program.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"
#include "runtime/src/pass.h"
#include "runtime/src/water_slopes.h"

namespace photic::runtime {
namespace {

bool finite3(const float* v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

}  // namespace

Result<GLuint> makeTexture(const GlFunctions& gl, const TextureShape& shape, GLenum filter, GLenum wrap) {
    const auto& [target, format, width, height, layers] = shape;
    if (width > gl.largest_texture_2d || height > gl.largest_texture_2d) {
        return Error{ErrorCode::Limit, "a texture of " + std::to_string(width) + " x " + std::to_string(height) +
                                           " texels is larger than the GPU's " + std::to_string(gl.largest_texture_2d)};
    }
    gl.clearErrors();
    GLuint texture = 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(target, texture);
    if (target == GL_TEXTURE_2D_ARRAY) {
        gl.TexStorage3D(target, 1, format, width, height, layers);
    } else {
        gl.TexStorage2D(target, 1, format, width, height);
    }
    if (gl.firstError() != GL_NO_ERROR) {
        gl.DeleteTextures(1, &texture);
        return Error{ErrorCode::Memory, "the GPU has no room for a texture of " + std::to_string(width) + " x " +
                                            std::to_string(height) + " x " + std::to_string(layers) + " texels"};
    }
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
        gl.TexParameteri(target, name, static_cast<GLint>(filter));
    }
    for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) {
        gl.TexParameteri(target, name, static_cast<GLint>(wrap));
    }
    return texture;
}

LiveWater::Impl::~Impl() {
    for (GLuint* t : {&map, &ray_starts, &ray_directions, &caustics}) {
        if (*t) gl.DeleteTextures(1, t);
    }
    if (nearest) gl.DeleteSamplers(1, &nearest);
    if (volume_indices) gl.DeleteBuffers(1, &volume_indices);
    if (movers) gl.DeleteBuffers(1, &movers);
    for (const GLuint p : {ray_program, mesh_program, volume_program, god_ray_program, shadowed_volume_program,
                           shadowed_god_ray_program}) {
        if (p) gl.DeleteProgram(p);
    }
    if (framebuffer) gl.DeleteFramebuffers(1, &framebuffer);
    if (vertex_array) gl.DeleteVertexArrays(1, &vertex_array);
}

LiveWater::LiveWater(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveWater::LiveWater(LiveWater&&) noexcept = default;
LiveWater& LiveWater::operator=(LiveWater&&) noexcept = default;
LiveWater::~LiveWater() = default;

Result<LiveWater> LiveWater::create(const GpuContext& context) {
    return guarded([&]() -> Result<LiveWater> {
        auto impl = std::make_unique<Impl>(context);
        const GlStateGuard guard(impl->gl);
        using Stages = std::vector<ShaderStage>;
        const std::pair<GLuint*, Stages> programs[] = {
            {&impl->ray_program,
             {{GL_VERTEX_SHADER, "full_screen.vert.glsl"}, {GL_FRAGMENT_SHADER, "water_rays.frag.glsl"}}},
            {&impl->volume_program,
             {{GL_VERTEX_SHADER, "warped_volume.vert.glsl"}, {GL_FRAGMENT_SHADER, "warped_volume.frag.glsl"}}},
            {&impl->mesh_program,
             {{GL_VERTEX_SHADER, "caustic_mesh.vert.glsl"}, {GL_FRAGMENT_SHADER, "caustic_mesh.frag.glsl"}}}};
        for (const auto& [program, stages] : programs) {
            const Result<GLuint> made = makeProgram(impl->gl, stages);
            if (!made) return made.error();
            *program = *made;
        }
        impl->gl.GenFramebuffers(1, &impl->framebuffer);
        impl->gl.GenVertexArrays(1, &impl->vertex_array);
        return LiveWater(std::move(impl));
    });
}

Status LiveWater::setHeights(const WaterHeights& heights) {
    return guarded([&]() -> Status {
        const auto texels = waterTexels(heights);
        if (!texels) return texels.error();
        Impl& w = *impl_;
        Retired retired(w.gl);
        const GlStateGuard guard(w.gl);
        w.gl.ActiveTexture(GL_TEXTURE0);
        if (heights.columns != w.columns || heights.rows != w.rows || heights.outside != w.water.outside) {
            // Outside flat water the border's zeros are read: height and slopes of still water.
            const GLenum wrap = heights.outside == WaterOutside::Periodic ? GL_REPEAT : GL_CLAMP_TO_BORDER;
            const auto made =
                makeTexture(w.gl, {GL_TEXTURE_2D, GL_RGBA32F, heights.columns, heights.rows, 1}, GL_LINEAR, wrap);
            if (!made) return made.error();
            retired.texture(w.map);
            w.map = *made, w.columns = heights.columns, w.rows = heights.rows;
        }
        w.gl.BindTexture(GL_TEXTURE_2D, w.map);
        w.gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, w.columns, w.rows, GL_RGBA, GL_FLOAT, texels->values.data());
        w.water = heights;
        w.water.heights = nullptr;
        for (int k = 0; k < 3; ++k) w.covariance[k] = texels->covariance[k];
        w.rays_current = false;
        return Done{};
    });
}

Status LiveWater::setLight(const WaterLight& light) {
    if (!finite3(light.direction) || !finite3(light.irradiance) || !finite3(light.extinction) ||
        !std::isfinite(light.ior)) {
        return Error{ErrorCode::Usage, "the light's direction, irradiance, extinction or index is not finite"};
    }
    const float length = std::hypot(light.direction[0], light.direction[1], light.direction[2]);
    if (!(light.direction[2] < -1e-3f * length)) {
        return Error{ErrorCode::Usage, "the light travels along z = " + std::to_string(light.direction[2]) +
                                           "; it must come down on the water, with z below -0.001 of its length"};
    }
    if (!(light.ior > 1)) {
        return Error{ErrorCode::Usage,
                     "the water's index is " + std::to_string(light.ior) + " of the air's; it must be above 1"};
    }
    impl_->light = light;
    for (float& x : impl_->light.direction) x /= length;
    impl_->rays_current = false;
    return Done{};
}

Status LiveWater::setLookup(const LookupOptions& o) {
    const bool good = o.tightening >= 0 && o.tightening_per_metre >= 0 && o.reflected >= 0 && o.reflected <= 1 &&
                      o.plane_distance > 0 && o.plane_fade > 0 && o.plane_samples >= 1 && o.plane_samples <= 4096 &&
                      std::isfinite(o.gain) && std::isfinite(o.ray_strength) && std::isfinite(o.tightening);
    if (!good) {
        return Error{ErrorCode::Usage,
                     "LookupOptions: tightening 0 or more, reflected 0 to 1, plane_distance and plane_fade "
                     "above 0 m, plane_samples 1 to 4096, the rest finite"};
    }
    impl_->lookup = o;
    return Done{};
}

GLuint LiveWater::Impl::programFor(GLuint& plain, GLuint& shadowed, const char* vertex_file, const char* fragment_file,
                                   const MoverShadows& shadows) {
    GLuint& program = shadows.movers ? shadowed : plain;
    if (!program) {
        std::vector<Define> defines;
        if (shadows.movers) defines.push_back({"PHOTIC_MOVERS", "1"});
        const Result<GLuint> made =
            makeProgram(gl, {{GL_VERTEX_SHADER, vertex_file}, {GL_FRAGMENT_SHADER, fragment_file}}, defines);
        if (!made) throw Failure{made.error()};
        program = *made;
    }
    if (!nearest) nearest = makeNearestSampler(gl);
    if (shadows.movers) bindMovers(gl, shadows, movers, nearest);
    return program;
}

void LiveWater::Impl::setWater(const Uniforms& u, int unit) const {
    u.texture("photic_water_map", unit, GL_TEXTURE_2D, map);
    u.set("photic_water_rect", water.corner[0], water.corner[1], 1 / water.size[0], 1 / water.size[1]);
    u.set("photic_water_level", water.level, light.ior);
    u.set3("photic_water_extinction", light.extinction);
    u.set3("photic_sun_direction", light.direction);
    u.set3("photic_sun_irradiance", light.irradiance);
}

void LiveWater::Impl::setLookup(const Uniforms& u, int unit) const {
    setWater(u, unit);
    u.set("photic_lookup_axes", static_cast<int>(lookup.axes));
    u.set("photic_lookup_projection", static_cast<int>(lookup.projection));
    u.set("photic_lookup_gain", static_cast<int>(lookup.gain_mode));
    u.set("photic_lookup_tightening", lookup.tightening, lookup.tightening_per_metre, lookup.reflected, lookup.gain);
    const LookupCovariance c = lookupCovariance(light.direction, light.ior, covariance, lookup.axes);
    u.set("photic_lookup_covariance", static_cast<float>(c.trace_below), static_cast<float>(c.determinant_below),
          static_cast<float>(c.trace_above), static_cast<float>(c.determinant_above));
    u.set("photic_god_rays", lookup.plane_distance, lookup.plane_fade, static_cast<float>(lookup.plane_samples),
          lookup.ray_strength);
}

void LiveWater::abandon() {
    Impl& w = *impl_;
    for (GLuint* name : {&w.map, &w.ray_starts, &w.ray_directions, &w.caustics, &w.volume_indices, &w.nearest,
                         &w.framebuffer, &w.vertex_array, &w.ray_program, &w.mesh_program, &w.volume_program,
                         &w.god_ray_program, &w.shadowed_volume_program, &w.shadowed_god_ray_program, &w.movers}) {
        *name = 0;
    }
    w.volume_index_count = 0;
    w.columns = w.rows = w.mesh_columns = w.mesh_rows = w.layers = w.resolution = 0;
}

bool LiveWater::hasCausticMap() const { return impl_->caustics != 0; }

std::size_t LiveWater::gpuBytes() const {
    const Impl& w = *impl_;
    const auto texels = [](int a, int b, int c) {
        return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c);
    };
    return texels(w.columns, w.rows, 16) + texels(w.mesh_columns, w.mesh_rows, 32) +
           texels(w.resolution, w.resolution, w.layers) * (w.full_precision ? 16 : 8) + w.volume_index_count * 4;
}

}  // namespace photic::runtime
