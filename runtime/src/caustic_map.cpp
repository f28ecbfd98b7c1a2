// SPDX-License-Identifier: Apache-2.0
// The water's mesh along its refracted rays: traced once, then drawn to each layer of the caustic map.
#include <cmath>
#include <string>

#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"

namespace photic::runtime {
namespace {

/// Vertices beyond the rectangle of water that is flat outside: its light leans in by this much [samples].
constexpr int kRim = 8;

Status checkFramebuffer(const GlFunctions& gl, const char* what) {
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Done{};
    return Error{ErrorCode::Unsupported, "'" + gl.renderer + "' cannot draw to " + what};
}

}  // namespace

Status LiveWater::Impl::traceRays(Retired& retired) {
    if (rays_current) return Done{};
    if (!map) return Error{ErrorCode::Usage, "the water has no heights; call setHeights() first"};
    const bool periodic = water.outside == WaterOutside::Periodic;
    // A periodic mesh is closed by its first column and row again.
    const int wanted_columns = columns + (periodic ? 1 : 2 * kRim), wanted_rows = rows + (periodic ? 1 : 2 * kRim);
    if (wanted_columns != mesh_columns || wanted_rows != mesh_rows) {
        for (GLuint* texture : {&ray_starts, &ray_directions}) {
            const auto made = makeTexture(gl, {GL_TEXTURE_2D, GL_RGBA32F, wanted_columns, wanted_rows, 1}, GL_NEAREST,
                                          GL_CLAMP_TO_EDGE);
            if (!made) return made.error();
            retired.texture(*texture);
            *texture = *made;
        }
        mesh_columns = wanted_columns, mesh_rows = wanted_rows;
        retired.buffer(volume_indices);
        volume_indices = 0;
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, ray_starts, 0);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, ray_directions, 0);
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1}, one[] = {GL_COLOR_ATTACHMENT0};
    gl.DrawBuffers(2, both);
    if (const Status status = checkFramebuffer(gl, "32-bit float textures"); !status) return status;
    gl.setViewport(0, 0, mesh_columns, mesh_rows);
    gl.Disable(GL_BLEND);
    const Uniforms uniforms(gl, ray_program);
    setWater(uniforms, 0);
    const float dx = water.size[0] / static_cast<float>(columns), dy = water.size[1] / static_cast<float>(rows);
    const float rim = periodic ? 0.5f : 0.5f - static_cast<float>(kRim);
    uniforms.set("photic_mesh", water.corner[0] + rim * dx, water.corner[1] + rim * dy, dx, dy);
    gl.BindVertexArray(vertex_array);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, 0, 0);
    gl.DrawBuffers(1, one);
    rays_current = true;
    return Done{};
}

Status LiveWater::updateCausticMap(const CausticMapOptions& o) {
    return guarded([&]() -> Status {
        Impl& w = *impl_;
        const GlFunctions& gl = w.gl;
        if (o.layers < 1 || o.layers > 256 || o.resolution < 16 || !std::isfinite(o.bottom) || !std::isfinite(o.top) ||
            (o.layers > 1 && !(o.top > o.bottom))) {
            return Error{ErrorCode::Usage, "a caustic map takes 1 to 256 layers (" + std::to_string(o.layers) +
                                               "), from 16 texels a side (" + std::to_string(o.resolution) +
                                               "), and a top above its bottom"};
        }
        Retired retired(gl);
        const GlStateGuard guard(gl);
        gl.ActiveTexture(GL_TEXTURE0);
        if (const Status traced = w.traceRays(retired); !traced) return traced;
        const bool periodic = w.water.outside == WaterOutside::Periodic;
        if (o.layers != w.layers || o.resolution != w.resolution || o.full_precision != w.full_precision ||
            periodic != w.periodic_map || !w.caustics) {
            const auto made = makeTexture(gl,
                                          {GL_TEXTURE_2D_ARRAY, GLenum(o.full_precision ? GL_RGBA32F : GL_RGBA16F),
                                           o.resolution, o.resolution, o.layers},
                                          GL_LINEAR, periodic ? GL_REPEAT : GL_CLAMP_TO_EDGE);
            if (!made) return made.error();
            retired.texture(w.caustics);
            w.caustics = *made, w.layers = o.layers, w.resolution = o.resolution, w.full_precision = o.full_precision;
            w.periodic_map = periodic;
        }
        gl.BindVertexArray(w.vertex_array);
        w.map_options = o;

        gl.BindFramebuffer(GL_FRAMEBUFFER, w.framebuffer);
        gl.setViewport(0, 0, o.resolution, o.resolution);
        gl.Enable(GL_BLEND);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
        const Uniforms uniforms(gl, w.mesh_program);
        w.setCausticMap(uniforms, 0);
        uniforms.texture("photic_ray_starts", 2, GL_TEXTURE_2D, w.ray_starts);
        uniforms.texture("photic_ray_directions", 3, GL_TEXTURE_2D, w.ray_directions);
        // The map itself is drawn to: it must not be bound for reading.
        gl.ActiveTexture(GL_TEXTURE1);
        gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
        const auto side = static_cast<float>(o.resolution);
        uniforms.set("photic_caustic_size", side, side);
        uniforms.set("photic_caustic_period", periodic ? w.water.size[0] : 0, periodic ? w.water.size[1] : 0);
        const float dark[4] = {0, 0, 0, 0};
        for (int layer = 0; layer < o.layers; ++layer) {
            gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, w.caustics, 0, layer);
            if (layer == 0) {
                if (const Status status = checkFramebuffer(gl, "float texture arrays"); !status) return status;
            }
            gl.ClearBufferfv(GL_COLOR, 0, dark);
            const float part = o.layers > 1 ? static_cast<float>(layer) / static_cast<float>(o.layers - 1) : 0;
            uniforms.set("photic_layer_z", o.bottom + part * (o.top - o.bottom));
            // A periodic map gets the light of the eight neighbours too.
            gl.DrawArraysInstanced(GL_TRIANGLES, 0, 6 * w.triangles(), periodic ? 9 : 1);
        }
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
        return Done{};
    });
}

void LiveWater::Impl::setCausticMap(const Uniforms& u, int unit) const {
    setWater(u, unit);
    u.texture("photic_caustic_map", unit + 1, GL_TEXTURE_2D_ARRAY, caustics);
    u.set("photic_caustic_rect", water.corner[0], water.corner[1], 1 / water.size[0], 1 / water.size[1]);
    const float range = map_options.top - map_options.bottom, steps = static_cast<float>(map_options.layers - 1);
    u.set("photic_caustic_layers", map_options.bottom, layers > 1 ? steps / range : 0, steps,
          water.outside == WaterOutside::Periodic ? 1.0f : 0.0f);
}

}  // namespace photic::runtime
