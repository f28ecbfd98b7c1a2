// SPDX-License-Identifier: Apache-2.0
// The look-up's god rays over a G-buffer.
#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"
#include "runtime/src/pass.h"

namespace photic::runtime {

Status LiveWater::drawGodRays(const GBuffer& surfaces, const Target& target, const MoverShadows& shadows) {
    return guarded([&]() -> Status {
        Impl& w = *impl_;
        const GlFunctions& gl = w.gl;
        if (!w.map) return Error{ErrorCode::Usage, "the water has no heights; call setHeights() first"};
        if (!surfaces.depth) return Error{ErrorCode::Usage, "the G-buffer lacks depth"};
        if (target.width <= 0 || target.height <= 0) {
            return Error{ErrorCode::Usage, "the target has no pixels; give it the size of its framebuffer"};
        }
        const GlStateGuard guard(gl);
        const GLuint program = w.programFor(w.god_ray_program, w.shadowed_god_ray_program, "full_screen.vert.glsl",
                                            "god_rays.frag.glsl", shadows);
        bindTarget(gl, target);
        gl.Enable(GL_BLEND);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
        const Uniforms uniforms(gl, program);
        w.setLookup(uniforms, 0);
        bindGBuffer(gl, uniforms, surfaces, w.nearest);
        gl.BindVertexArray(w.vertex_array);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        return Done{};
    });
}

}  // namespace photic::runtime
