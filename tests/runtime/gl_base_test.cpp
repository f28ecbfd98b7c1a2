// SPDX-License-Identifier: Apache-2.0
// The ground that the GPU half stands on: loading GL, compiling programs, leaving the game's state alone.
#include <cstring>
#include <functional>
#include <map>

#include "runtime/src/gl_program.h"
#include "runtime/src/gl_state.h"
#include "tests/runtime/gl_fixture.h"

namespace photic::runtime {
namespace {

using GlBase = test::WithGl;

TEST(GlLoading, NullLoaderIsAnError) {
    const auto gl = loadGlFunctions({});
    ASSERT_FALSE(gl.ok());
    EXPECT_EQ(gl.error().code, ErrorCode::Usage);
}

TEST(GlLoading, LoaderThatFindsNothingIsAnError) {
    const auto gl = loadGlFunctions({[](void*, const char*) -> void* { return nullptr; }, nullptr});
    ASSERT_FALSE(gl.ok());
    EXPECT_EQ(gl.error().code, ErrorCode::Unsupported);
}

TEST_F(GlBase, MissingFunctionIsNamed) {
    GlLoader real = context_->loader();
    const GlLoader holed{[](void* user, const char* name) -> void* {
                             if (!std::strcmp(name, "glTexStorage3D")) return nullptr;
                             const auto* inner = static_cast<const GlLoader*>(user);
                             return inner->get_proc_address(inner->user, name);
                         },
                         &real};
    const auto gl = loadGlFunctions(holed);
    ASSERT_FALSE(gl.ok());
    EXPECT_NE(gl.error().message.find("glTexStorage3D"), std::string::npos) << gl.error().message;
}

TEST_F(GlBase, LimitsAreRead) {
    EXPECT_GE(gl_.major * 10 + gl_.minor, 43);
    EXPECT_GE(gl_.largest_texture_3d, 2048);
    EXPECT_GT(gl_.largest_storage_block, 0);
    EXPECT_FALSE(gl_.renderer.empty());
}

TEST_F(GlBase, EsContextsLoadToo) {
    open(test::GlApi::Es31);
    if (IsSkipped() || HasFatalFailure()) return;
    EXPECT_TRUE(gl_.es);
}

ShaderSourceText stage(GLenum kind, const std::string& body) {
    return {kind, {"#version 430 core\n" + body, {"made_up.glsl"}}};
}

TEST_F(GlBase, ProgramsCompile) {
    const auto program = makeProgram(
        gl_,
        {stage(GL_COMPUTE_SHADER,
               "layout(local_size_x = 1) in;\nlayout(binding = 0) buffer B { uint a; };\nvoid main() { a = 1u; }\n")});
    ASSERT_TRUE(program.ok()) << program.error().message;
    gl_.DeleteProgram(*program);
}

TEST_F(GlBase, CompileErrorNamesStageFileAndReason) {
    const auto program = makeProgram(gl_, {stage(GL_FRAGMENT_SHADER, "void main() { nonsense(); }\n")});
    ASSERT_FALSE(program.ok());
    EXPECT_EQ(program.error().code, ErrorCode::Shader);
    for (const char* part : {"fragment", "made_up.glsl", "nonsense"}) {
        EXPECT_NE(program.error().message.find(part), std::string::npos) << program.error().message;
    }
}

TEST_F(GlBase, LinkErrorIsReported) {
    const auto program = makeProgram(gl_, {stage(GL_VERTEX_SHADER, "vec4 f();\nvoid main() { gl_Position = f(); }\n")});
    ASSERT_FALSE(program.ok());
    EXPECT_NE(program.error().message.find("link"), std::string::npos) << program.error().message;
}

TEST(ShaderSource, MissingFileIsNamed) {
    const auto text = assembleShader("no_such.glsl", GlslTarget::Gl430, {});
    ASSERT_FALSE(text.ok());
    EXPECT_NE(text.error().message.find("no_such.glsl"), std::string::npos);
}

TEST(ShaderSource, VersionAndDefinesComeFirst) {
    const auto text = assembleShader("full_screen.vert.glsl", GlslTarget::Gl460, {{"PHOTIC_X", "3"}});
    ASSERT_TRUE(text.ok());
    EXPECT_EQ(text->text.rfind("#version 460 core\n#define PHOTIC_X 3\n#line 1 0\n", 0), 0u);
}

/// A state that a guard must bring back: how to set it (to two different values), and how to read it.
struct Probe {
    std::function<void(const GlFunctions&, bool second)> set;
    std::function<double(const GlFunctions&)> read;
};

double readInteger(const GlFunctions& gl, GLenum name) {
    GLint values[4] = {};
    gl.GetIntegerv(name, values);
    return values[0] + 8.0 * values[1] + 64.0 * values[2] + 512.0 * values[3];
}

double readIndexed(const GlFunctions& gl, GLenum name, GLuint index) {
    GLint value = 0;
    gl.GetIntegeri_v(name, index, &value);
    return value;
}

std::map<std::string, Probe> probes() {
    std::map<std::string, Probe> all;
    const auto capability = [&](const char* name, GLenum c) {
        all[name] = {[c](const GlFunctions& gl, bool second) { second ? gl.Disable(c) : gl.Enable(c); },
                     [c](const GlFunctions& gl) { return gl.IsEnabled(c) ? 1.0 : 0.0; }};
    };
    capability("blend", GL_BLEND);
    capability("depth test", GL_DEPTH_TEST);
    capability("stencil test", GL_STENCIL_TEST);
    capability("scissor test", GL_SCISSOR_TEST);
    capability("cull face", GL_CULL_FACE);
    capability("rasterizer discard", GL_RASTERIZER_DISCARD);
    capability("depth clamp", GL_DEPTH_CLAMP);
    const auto integers = [&](const char* name, GLenum value, std::function<void(const GlFunctions&, bool)> set) {
        all[name] = {std::move(set), [value](const GlFunctions& gl) { return readInteger(gl, value); }};
    };
    integers("viewport", GL_VIEWPORT, [](const GlFunctions& gl, bool b) { gl.Viewport(1, 2, 3, 4 + b); });
    integers("scissor box", GL_SCISSOR_BOX, [](const GlFunctions& gl, bool b) { gl.Scissor(1, 2, 3, 4 + b); });
    integers("blend source", GL_BLEND_SRC_RGB, [](const GlFunctions& gl, bool b) {
        gl.BlendFuncSeparate(b ? GL_ZERO : GL_DST_COLOR, GL_ONE, GL_ZERO, GL_ONE);
    });
    integers("blend target", GL_BLEND_DST_ALPHA, [](const GlFunctions& gl, bool b) {
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ZERO, b ? GL_ZERO : GL_ONE);
    });
    integers("blend equation", GL_BLEND_EQUATION_ALPHA,
             [](const GlFunctions& gl, bool b) { gl.BlendEquationSeparate(GL_FUNC_ADD, b ? GL_MIN : GL_MAX); });
    integers("depth function", GL_DEPTH_FUNC,
             [](const GlFunctions& gl, bool b) { gl.DepthFunc(b ? GL_LESS : GL_GREATER); });
    integers("cull mode", GL_CULL_FACE_MODE,
             [](const GlFunctions& gl, bool b) { gl.CullFace(b ? GL_BACK : GL_FRONT); });
    integers("front face", GL_FRONT_FACE, [](const GlFunctions& gl, bool b) { gl.FrontFace(b ? GL_CCW : GL_CW); });
    integers("polygon mode", GL_POLYGON_MODE,
             [](const GlFunctions& gl, bool b) { gl.PolygonMode(GL_FRONT_AND_BACK, b ? GL_FILL : GL_LINE); });
    const auto pixels = [&](const char* name, GLenum value) {
        integers(name, value, [value](const GlFunctions& gl, bool b) { gl.PixelStorei(value, b ? 2 : 1); });
    };
    pixels("unpack alignment", GL_UNPACK_ALIGNMENT);
    pixels("unpack row length", GL_UNPACK_ROW_LENGTH);
    pixels("unpack image height", GL_UNPACK_IMAGE_HEIGHT);
    pixels("unpack skipped images", GL_UNPACK_SKIP_IMAGES);
    integers("active texture", GL_ACTIVE_TEXTURE,
             [](const GlFunctions& gl, bool b) { gl.ActiveTexture(b ? GL_TEXTURE5 : GL_TEXTURE3); });
    integers("program", GL_CURRENT_PROGRAM, [](const GlFunctions& gl, bool) {
        const auto program =
            makeProgram(gl, {stage(GL_COMPUTE_SHADER, "layout(local_size_x = 1) in;\nvoid main() {}\n")});
        ASSERT_TRUE(program.ok());
        gl.UseProgram(*program);
    });
    integers("vertex array", GL_VERTEX_ARRAY_BINDING, [](const GlFunctions& gl, bool) {
        GLuint name = 0;
        gl.GenVertexArrays(1, &name);
        gl.BindVertexArray(name);
    });
    integers("draw framebuffer", GL_DRAW_FRAMEBUFFER_BINDING, [](const GlFunctions& gl, bool) {
        GLuint name = 0;
        gl.GenFramebuffers(1, &name);
        gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, name);
    });
    const auto texture = [&](const char* name, GLenum target, GLenum binding) {
        integers(name, binding, [target](const GlFunctions& gl, bool) {
            GLuint made = 0;
            gl.GenTextures(1, &made);
            gl.BindTexture(target, made);
        });
    };
    texture("2D texture", GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D);
    texture("3D texture", GL_TEXTURE_3D, GL_TEXTURE_BINDING_3D);
    integers("sampler", GL_SAMPLER_BINDING, [](const GlFunctions& gl, bool) {
        GLuint name = 0;
        GLint unit = 0;
        gl.GenSamplers(1, &name);
        gl.GetIntegerv(GL_ACTIVE_TEXTURE, &unit);
        gl.BindSampler(static_cast<GLuint>(unit - GL_TEXTURE0), name);
    });
    const auto indexed = [&](const char* name, GLenum target, GLenum binding, GLuint index) {
        all[name] = {[=](const GlFunctions& gl, bool) {
                         GLuint buffer = 0;
                         gl.GenBuffers(1, &buffer);
                         gl.BindBufferBase(target, index, buffer);
                     },
                     [=](const GlFunctions& gl) { return readIndexed(gl, binding, index); }};
    };
    indexed("uniform buffer 2", GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, 2);
    indexed("storage buffer 3", GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING, 3);
    all["colour mask"] = {[](const GlFunctions& gl, bool b) { gl.ColorMask(GL_FALSE, GL_TRUE, b, GL_TRUE); },
                          [](const GlFunctions& gl) {
                              GLboolean mask[4];
                              gl.GetBooleanv(GL_COLOR_WRITEMASK, mask);
                              return mask[0] + 2.0 * mask[1] + 4.0 * mask[2] + 8.0 * mask[3];
                          }};
    all["depth mask"] = {[](const GlFunctions& gl, bool b) { gl.DepthMask(!b); },
                         [](const GlFunctions& gl) {
                             GLboolean mask = GL_TRUE;
                             gl.GetBooleanv(GL_DEPTH_WRITEMASK, &mask);
                             return static_cast<double>(mask);
                         }};
    return all;
}

TEST_F(GlBase, GuardBringsStateBack) {
    for (const auto& [name, probe] : probes()) {
        probe.set(gl_, false);  // the game's own odd state, not GL's default, is what must come back
        const double before = probe.read(gl_);
        {
            const GlStateGuard guard(gl_);
            probe.set(gl_, true);
            EXPECT_NE(probe.read(gl_), before) << name << ": nothing to bring back";
        }
        EXPECT_EQ(probe.read(gl_), before) << name;
    }
}

}  // namespace
}  // namespace photic::runtime
