// SPDX-License-Identifier: Apache-2.0
// Bounding prisms of warped caustic volumes, drawn over a scene (Ernst et al. 2005).
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"
#include "runtime/src/pass.h"

namespace photic::runtime {
namespace {

constexpr int kIndicesPerVolume = 24;

/// The eight faces of each prism, outsides anticlockwise: corners 0 to 2 on top, 3 to 5 below them
/// (warped_volume.vert.glsl).
std::vector<GLuint> prismIndices(int volumes) {
    constexpr GLuint kFaces[kIndicesPerVolume] = {0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3,
                                                  1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5};
    std::vector<GLuint> out(static_cast<std::size_t>(volumes) * kIndicesPerVolume);
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = static_cast<GLuint>(i / kIndicesPerVolume * 6) + kFaces[i % kIndicesPerVolume];
    }
    return out;
}

/// Whether what is anticlockwise in the world, seen from outside, is so in clip space. A mirrored view (drawn upside
/// down into a texture) turns it.
bool keepsWinding(const float* m, const GBuffer& surfaces) {
    // Rows x, y and w of the matrix: for a view that is not mirrored, x cross y points against w (the way one looks).
    const auto row = [&](int r, int c) { return static_cast<double>(m[c * 4 + r]); };
    const auto determinant = [&](int last) {
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            sum += row(last, i) * (row(0, j) * row(1, k) - row(0, k) * row(1, j));
        }
        return sum;
    };
    const double perspective = determinant(3);
    if (perspective != 0) return perspective < 0;
    // A parallel view has no w: its z grows away from the eye, unless depth is reversed, which the eye's place tells.
    double eye_z = row(2, 3), eye_w = row(3, 3);
    for (int i = 0; i < 3; ++i) eye_z += row(2, i) * surfaces.camera[i];
    const double middle = surfaces.clip_depth == ClipDepth::ZeroToOne ? 0.5 : 0;
    const bool reversed = eye_z / eye_w > middle;
    return (determinant(2) < 0) != reversed;
}

/// What is wrong with what a caller gives, if anything.
std::optional<Error> refusal(const GBuffer& surfaces, const float* clip_from_world, const Target& target,
                             const WarpedVolumesOptions& o) {
    if (o.step < 1) return Error{ErrorCode::Usage, "step is " + std::to_string(o.step) + "; it must be 1 or more"};
    if (!(std::fabs(o.anisotropy) < 1)) {
        return Error{ErrorCode::Usage, "anisotropy " + std::to_string(o.anisotropy) + " is not between -1 and 1"};
    }
    if (!surfaces.depth || !surfaces.normals || !clip_from_world) {
        return Error{ErrorCode::Usage, "the G-buffer lacks depth or normals, or the view its matrix"};
    }
    if (target.width <= 0 || target.height <= 0) {
        return Error{ErrorCode::Usage, "the target has no pixels; give it the size of its framebuffer"};
    }
    return std::nullopt;
}

}  // namespace

Status LiveWater::Impl::bindVolumeIndices(int volumes, int step, Retired& retired) {
    if (!volume_indices || volume_step != step) {
        const std::vector<GLuint> indices = prismIndices(volumes);
        if (!volume_indices) gl.GenBuffers(1, &volume_indices);
        gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, volume_indices);
        gl.clearErrors();
        gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(GLuint)), indices.data(),
                      GL_STATIC_DRAW);
        if (gl.firstError() != GL_NO_ERROR) {
            retired.buffer(volume_indices);
            volume_indices = 0, volume_index_count = 0;
            return Error{ErrorCode::Memory, "the GPU has no room for " + std::to_string(volumes) +
                                                " volumes; use a larger step than " + std::to_string(step)};
        }
        volume_step = step, volume_index_count = indices.size();
    }
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, volume_indices);
    return Done{};
}

Status LiveWater::drawWarpedVolumes(const GBuffer& surfaces, const float* clip_from_world, const Target& target,
                                    const WarpedVolumesOptions& o) {
    return guarded([&]() -> Status {
        Impl& w = *impl_;
        const GlFunctions& gl = w.gl;
        if (std::optional<Error> wrong = refusal(surfaces, clip_from_world, target, o)) return *std::move(wrong);
        Retired retired(gl);
        {
            const GlStateGuard guard(gl);
            gl.ActiveTexture(GL_TEXTURE0);
            if (const Status traced = w.traceRays(retired); !traced) return traced;
        }
        const GlStateGuard guard(gl);
        bindTarget(gl, target);
        gl.BindVertexArray(w.vertex_array);
        const int volumes = 2 * ((w.mesh_columns - 1) / o.step) * ((w.mesh_rows - 1) / o.step);
        if (const Status bound = w.bindVolumeIndices(volumes, o.step, retired); !bound) return bound;
        gl.Enable(GL_BLEND);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
        // Far sides only: every line of sight leaves a prism once, wherever the eye is.
        gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_FRONT);
        gl.FrontFace(keepsWinding(clip_from_world, surfaces) ? GL_CCW : GL_CW);
        if (!gl.es) gl.Enable(GL_DEPTH_CLAMP);

        const GLuint program = w.programFor(w.volume_program, w.shadowed_volume_program, "warped_volume.vert.glsl",
                                            "warped_volume.frag.glsl", o.shadows);
        const Uniforms uniforms(gl, program);
        w.setWater(uniforms, 0);
        uniforms.texture("photic_ray_starts", 1, GL_TEXTURE_2D, w.ray_starts);
        uniforms.texture("photic_ray_directions", 2, GL_TEXTURE_2D, w.ray_directions);
        bindGBuffer(gl, uniforms, surfaces, w.nearest);
        uniforms.set("photic_has_albedo", surfaces.albedo ? 1 : 0);
        uniforms.set("photic_target", static_cast<float>(target.x), static_cast<float>(target.y),
                     static_cast<float>(target.width), static_cast<float>(target.height));
        uniforms.setMatrix("photic_clip_from_world", clip_from_world);
        uniforms.set("photic_mesh_step", o.step);
        uniforms.set("photic_volume_bottom", o.bottom);
        uniforms.set("photic_scattering", o.scattering[0], o.scattering[1], o.scattering[2], o.anisotropy);
        gl.DrawElements(GL_TRIANGLES, kIndicesPerVolume * volumes, GL_UNSIGNED_INT, nullptr);
        return Done{};
    });
}

}  // namespace photic::runtime
