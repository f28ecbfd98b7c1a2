// SPDX-License-Identifier: Apache-2.0
// The look-up's god rays over a G-buffer.
#include "runtime/src/gl_program.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"
#include "runtime/src/pass.h"

namespace photic::runtime {

Status LiveWater::drawGodRays(const GBuffer& surfaces, const Target& target) {
    return guarded([&]() -> Status {
        Impl& w = *impl_;
        const GlFunctions& gl = w.gl;
        if (!w.map) return Error{ErrorCode::Usage, "the water has no heights; call setHeights() first"};
        if (!surfaces.depth) return Error{ErrorCode::Usage, "the G-buffer lacks depth"};
        if (target.width <= 0 || target.height <= 0) {
            return Error{ErrorCode::Usage, "the target has no pixels; give it the size of its framebuffer"};
        }
        const GlStateGuard guard(gl);
        if (!w.god_ray_program) {
            const std::vector<ShaderStage> stages = {{GL_VERTEX_SHADER, "full_screen.vert.glsl"},
                                                     {GL_FRAGMENT_SHADER, "god_rays.frag.glsl"}};
            const Result<GLuint> made = makeProgram(gl, stages);
            if (!made) return made.error();
            w.god_ray_program = *made;
        }
        if (!w.nearest) w.nearest = makeNearestSampler(gl);
        bindTarget(gl, target);
        gl.Enable(GL_BLEND);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
        const Uniforms uniforms(gl, w.god_ray_program);
        w.setLookup(uniforms, 0);
        bindGBuffer(gl, uniforms, surfaces, w.nearest);
        gl.BindVertexArray(w.vertex_array);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        return Done{};
    });
}

}  // namespace photic::runtime
