// SPDX-License-Identifier: Apache-2.0
// Every public call of the GPU half leaves GL as it was, whatever that is, and is not disturbed by it.
#include <map>

#include "tests/runtime/every_call.h"
#include "tests/runtime/wrapped_gl.h"

namespace photic::runtime {
namespace {

using test::Call;

using EveryCall = test::EveryCall;

/// All of GL's state that a call could change, by name.
class State {
public:
    State(const GlFunctions& gl, const test::WrappedGl& driver) : gl_(gl) {
        driver.real("glIsEnabledi", is_enabled_);
        driver.real("glGetBooleani_v", get_boolean_);
        driver.real("glGetFloati_v", get_float_);
    }

    std::map<std::string, std::array<double, 4>> read() const {
        std::map<std::string, std::array<double, 4>> out;
        const auto integers = [&](const std::string& name, GLenum what) {
            GLint v[16] = {};
            gl_.GetIntegerv(what, v);
            out[name] = {double(v[0]), double(v[1]), double(v[2]), double(v[3])};
        };
        for (const auto& [name, what] : kIntegers) integers(name, what);
        for (const auto& [name, what] : kFloats) {
            GLfloat v[16] = {};
            gl_.GetFloatv(what, v);
            out[name] = {double(v[0]), double(v[1]), double(v[2]), double(v[3])};
        }
        for (const auto& [name, what] : kCapabilities) out[name] = {double(gl_.IsEnabled(what)), 0, 0, 0};
        const auto indexed = [&](const std::string& name, GLenum what, GLuint index) {
            GLint v[4] = {};
            gl_.GetIntegeri_v(what, index, v);
            out[name + " " + std::to_string(index)] = {double(v[0]), double(v[1]), double(v[2]), double(v[3])};
        };
        for (GLuint i = 0; i < 8; ++i) {
            for (const auto& [name, what] : kIndexed) indexed(name, what, i);
            out["blend " + std::to_string(i)] = {double(is_enabled_(GL_BLEND, i)), 0, 0, 0};
            GLboolean mask[4];
            get_boolean_(GL_COLOR_WRITEMASK, i, mask);
            out["colour mask " + std::to_string(i)] = {double(mask[0]), double(mask[1]), double(mask[2]),
                                                       double(mask[3])};
            GLfloat viewport[4];
            get_float_(GL_VIEWPORT, i, viewport);
            out["viewport " + std::to_string(i)] = {double(viewport[0]), double(viewport[1]), double(viewport[2]),
                                                    double(viewport[3])};
            out["scissor test " + std::to_string(i)] = {double(is_enabled_(GL_SCISSOR_TEST, i)), 0, 0, 0};
        }
        GLint active = 0;
        gl_.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
        for (GLenum unit = 0; unit < 32; ++unit) {
            gl_.ActiveTexture(GL_TEXTURE0 + unit);
            for (const auto& [name, what] : kTextures) integers(name + std::string(" ") + std::to_string(unit), what);
        }
        gl_.ActiveTexture(static_cast<GLenum>(active));
        return out;
    }

private:
    static inline const std::vector<std::pair<const char*, GLenum>> kIntegers{
        {"active texture", GL_ACTIVE_TEXTURE},
        {"program", GL_CURRENT_PROGRAM},
        {"program pipeline", GL_PROGRAM_PIPELINE_BINDING},
        {"vertex array", GL_VERTEX_ARRAY_BINDING},
        {"array buffer", GL_ARRAY_BUFFER_BINDING},
        {"element buffer", GL_ELEMENT_ARRAY_BUFFER_BINDING},
        {"uniform buffer", GL_UNIFORM_BUFFER_BINDING},
        {"storage buffer", GL_SHADER_STORAGE_BUFFER_BINDING},
        {"counter buffer", GL_ATOMIC_COUNTER_BUFFER_BINDING},
        {"indirect dispatch", GL_DISPATCH_INDIRECT_BUFFER_BINDING},
        {"indirect draw", GL_DRAW_INDIRECT_BUFFER_BINDING},
        {"copied from", GL_COPY_READ_BUFFER_BINDING},
        {"copied to", GL_COPY_WRITE_BUFFER_BINDING},
        {"pixels packed", GL_PIXEL_PACK_BUFFER_BINDING},
        {"pixels unpacked", GL_PIXEL_UNPACK_BUFFER_BINDING},
        {"draw framebuffer", GL_DRAW_FRAMEBUFFER_BINDING},
        {"read framebuffer", GL_READ_FRAMEBUFFER_BINDING},
        {"renderbuffer", GL_RENDERBUFFER_BINDING},
        {"transform feedback", GL_TRANSFORM_FEEDBACK_BINDING},
        {"viewport", GL_VIEWPORT},
        {"scissor box", GL_SCISSOR_BOX},
        {"depth function", GL_DEPTH_FUNC},
        {"depth mask", GL_DEPTH_WRITEMASK},
        {"stencil function", GL_STENCIL_FUNC},
        {"stencil reference", GL_STENCIL_REF},
        {"stencil mask", GL_STENCIL_WRITEMASK},
        {"stencil pass", GL_STENCIL_PASS_DEPTH_PASS},
        {"cull mode", GL_CULL_FACE_MODE},
        {"front face", GL_FRONT_FACE},
        {"polygon mode", GL_POLYGON_MODE},
        {"provoking vertex", GL_PROVOKING_VERTEX},
        {"logic operation", GL_LOGIC_OP_MODE},
        {"restart index", GL_PRIMITIVE_RESTART_INDEX},
        {"clip origin", GL_CLIP_ORIGIN},
        {"clip depth", GL_CLIP_DEPTH_MODE},
        {"cleared stencil", GL_STENCIL_CLEAR_VALUE},
        {"unpack alignment", GL_UNPACK_ALIGNMENT},
        {"unpack rows", GL_UNPACK_ROW_LENGTH},
        {"unpack images", GL_UNPACK_IMAGE_HEIGHT},
        {"unpack skips pixels", GL_UNPACK_SKIP_PIXELS},
        {"unpack skips rows", GL_UNPACK_SKIP_ROWS},
        {"unpack skips images", GL_UNPACK_SKIP_IMAGES},
        {"unpack swaps", GL_UNPACK_SWAP_BYTES},
        {"pack alignment", GL_PACK_ALIGNMENT},
        {"pack rows", GL_PACK_ROW_LENGTH}};
    static inline const std::vector<std::pair<const char*, GLenum>> kFloats{
        {"blend colour", GL_BLEND_COLOR},
        {"cleared colour", GL_COLOR_CLEAR_VALUE},
        {"cleared depth", GL_DEPTH_CLEAR_VALUE},
        {"depth range", GL_DEPTH_RANGE},
        {"line width", GL_LINE_WIDTH},
        {"point size", GL_POINT_SIZE},
        {"polygon offset", GL_POLYGON_OFFSET_FACTOR}};
    static inline const std::vector<std::pair<const char*, GLenum>> kCapabilities{
        {"depth test", GL_DEPTH_TEST},
        {"stencil test", GL_STENCIL_TEST},
        {"cull face", GL_CULL_FACE},
        {"discards", GL_RASTERIZER_DISCARD},
        {"offset", GL_POLYGON_OFFSET_FILL},
        {"alpha to coverage", GL_SAMPLE_ALPHA_TO_COVERAGE},
        {"logic", GL_COLOR_LOGIC_OP},
        {"sRGB", GL_FRAMEBUFFER_SRGB},
        {"depth clamp", GL_DEPTH_CLAMP},
        {"point sizes", GL_PROGRAM_POINT_SIZE},
        {"restart", GL_PRIMITIVE_RESTART},
        {"fixed restart", GL_PRIMITIVE_RESTART_FIXED_INDEX},
        {"clip distance 0", GL_CLIP_DISTANCE0},
        {"multisample", GL_MULTISAMPLE},
        {"dither", GL_DITHER}};
    static inline const std::vector<std::pair<const char*, GLenum>> kIndexed{
        {"uniforms", GL_UNIFORM_BUFFER_BINDING},
        {"uniforms from", GL_UNIFORM_BUFFER_START},
        {"uniforms long", GL_UNIFORM_BUFFER_SIZE},
        {"storage", GL_SHADER_STORAGE_BUFFER_BINDING},
        {"image", GL_IMAGE_BINDING_NAME},
        {"image access", GL_IMAGE_BINDING_ACCESS},
        {"image format", GL_IMAGE_BINDING_FORMAT},
        {"blend source", GL_BLEND_SRC_RGB},
        {"blend target", GL_BLEND_DST_RGB},
        {"blend source alpha", GL_BLEND_SRC_ALPHA},
        {"blend target alpha", GL_BLEND_DST_ALPHA},
        {"blend equation", GL_BLEND_EQUATION_RGB},
        {"blend equation alpha", GL_BLEND_EQUATION_ALPHA},
        {"scissors", GL_SCISSOR_BOX}};
    static inline const std::vector<std::pair<const char*, GLenum>> kTextures{{"2D", GL_TEXTURE_BINDING_2D},
                                                                              {"3D", GL_TEXTURE_BINDING_3D},
                                                                              {"2D array", GL_TEXTURE_BINDING_2D_ARRAY},
                                                                              {"cube", GL_TEXTURE_BINDING_CUBE_MAP},
                                                                              {"buffer", GL_TEXTURE_BINDING_BUFFER},
                                                                              {"sampler", GL_SAMPLER_BINDING}};

    const GlFunctions& gl_;
    PFNGLISENABLEDIPROC is_enabled_ = nullptr;
    PFNGLGETBOOLEANI_VPROC get_boolean_ = nullptr;
    PFNGLGETFLOATI_VPROC get_float_ = nullptr;
};

/// A game's state in the middle of its frame, as unlike GL's own as can be; its objects live as long as this.
class OddState {
public:
    OddState(const GlFunctions& gl, const test::WrappedGl& driver) : gl_(gl) {
        makeObjects();
        for (const GLenum c : {GL_DEPTH_TEST, GL_STENCIL_TEST, GL_SCISSOR_TEST, GL_CULL_FACE, GL_RASTERIZER_DISCARD,
                               GL_POLYGON_OFFSET_FILL, GL_DEPTH_CLAMP, GL_PRIMITIVE_RESTART, GL_COLOR_LOGIC_OP,
                               GL_PROGRAM_POINT_SIZE, GL_CLIP_DISTANCE0})
            gl.Enable(c);
        gl.Viewport(3, 5, 7, 2), gl.Scissor(1, 1, 2, 3);
        gl.BlendFuncSeparate(GL_DST_COLOR, GL_ZERO, GL_ONE_MINUS_SRC_ALPHA, GL_SRC_COLOR);
        gl.BlendEquationSeparate(GL_MIN, GL_FUNC_REVERSE_SUBTRACT);
        gl.BlendColor(0.1F, 0.2F, 0.3F, 0.4F), gl.ClearColor(0.5F, 0.6F, 0.7F, 0.8F), gl.ClearDepthf(0.3F);
        gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE), gl.DepthMask(GL_TRUE), gl.DepthFunc(GL_NEVER);
        gl.CullFace(GL_FRONT_AND_BACK), gl.FrontFace(GL_CW), gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        for (const GLenum p : {GL_UNPACK_ALIGNMENT, GL_PACK_ALIGNMENT}) gl.PixelStorei(p, 1);
        for (const GLenum p : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_PACK_ROW_LENGTH}) gl.PixelStorei(p, 77);
        for (const GLenum p : {GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES}) gl.PixelStorei(p, 2);
        each(driver);
    }
    ~OddState() {
        for (GLenum unit = 0; unit < 32; ++unit) gl_.BindSampler(unit, 0);
        gl_.UseProgram(0), gl_.BindFramebuffer(GL_FRAMEBUFFER, 0), gl_.BindVertexArray(0);
        gl_.DeleteTextures(4, textures_), gl_.DeleteBuffers(1, &buffer_), gl_.DeleteSamplers(1, &sampler_);
        gl_.DeleteFramebuffers(2, framebuffers_), gl_.DeleteVertexArrays(1, &array_);
    }
    OddState(const OddState&) = delete;
    OddState& operator=(const OddState&) = delete;

private:
    void makeObjects() {
        constexpr GLenum kTargets[4] = {GL_TEXTURE_2D, GL_TEXTURE_3D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_CUBE_MAP};
        gl_.GenTextures(4, textures_);
        gl_.GenSamplers(1, &sampler_);
        for (GLenum unit = 0; unit < 32; ++unit) {
            gl_.ActiveTexture(GL_TEXTURE0 + unit);
            for (int t = 0; t < 4; ++t) gl_.BindTexture(kTargets[t], textures_[t]);
            gl_.BindSampler(unit, sampler_);
        }
        gl_.TexStorage3D(GL_TEXTURE_3D, 1, GL_RGBA16F, 4, 4, 4);
        gl_.GenVertexArrays(1, &array_), gl_.BindVertexArray(array_);
        gl_.GenBuffers(1, &buffer_);
        for (const GLenum target :
             {GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER, GL_UNIFORM_BUFFER, GL_SHADER_STORAGE_BUFFER,
              GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER,
              GL_DRAW_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER})
            gl_.BindBuffer(target, buffer_);
        gl_.BufferData(GL_ARRAY_BUFFER, 4096, nullptr, GL_STATIC_DRAW);
        for (GLuint i = 0; i < 8; ++i) {
            gl_.BindBufferRange(GL_UNIFORM_BUFFER, i, buffer_, 256, 512);
            gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffer_);
            gl_.BindImageTexture(i, textures_[1], 0, GL_TRUE, 0, GL_READ_ONLY, GL_RGBA16F);
        }
        gl_.GenFramebuffers(2, framebuffers_);
        gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[0]);
        gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
        gl_.ActiveTexture(GL_TEXTURE17);
    }
    /// What differs from one colour buffer or viewport to the next, and what ES does not have.
    static void each(const test::WrappedGl& driver) {
        PFNGLENABLEIPROC enable = nullptr;
        PFNGLCOLORMASKIPROC mask = nullptr;
        PFNGLBLENDFUNCIPROC blend = nullptr;
        PFNGLBLENDEQUATIONIPROC equation = nullptr;
        PFNGLVIEWPORTINDEXEDFPROC viewport = nullptr;
        PFNGLSCISSORINDEXEDPROC scissor = nullptr;
        PFNGLPRIMITIVERESTARTINDEXPROC restart = nullptr;
        PFNGLLOGICOPPROC logic = nullptr;
        PFNGLSTENCILFUNCPROC stencil = nullptr;
        PFNGLCLIPCONTROLPROC clip = nullptr;
        driver.real("glEnablei", enable), driver.real("glColorMaski", mask), driver.real("glBlendFunci", blend);
        driver.real("glBlendEquationi", equation), driver.real("glViewportIndexedf", viewport);
        driver.real("glScissorIndexed", scissor), driver.real("glPrimitiveRestartIndex", restart);
        driver.real("glLogicOp", logic), driver.real("glStencilFunc", stencil), driver.real("glClipControl", clip);
        enable(GL_BLEND, 1), mask(2, GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE), blend(3, GL_ONE, GL_DST_ALPHA);
        equation(1, GL_MAX), viewport(1, 9, 8, 7, 6), scissor(2, 4, 4, 4, 4), enable(GL_SCISSOR_TEST, 3);
        restart(3), logic(GL_XOR), stencil(GL_NEVER, 5, 3);
        if (clip) clip(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    }

    const GlFunctions& gl_;
    GLuint textures_[4] = {}, framebuffers_[2] = {}, buffer_ = 0, sampler_ = 0, array_ = 0;
};

/// Names of what differs.
std::string differences(const std::map<std::string, std::array<double, 4>>& a,
                        const std::map<std::string, std::array<double, 4>>& b) {
    std::string out;
    for (const auto& [name, value] : a) {
        if (b.at(name) != value)
            out += name + " (" + std::to_string(value[0]) + ", now " + std::to_string(b.at(name)[0]) + "); ";
    }
    return out;
}

TEST_F(EveryCall, LeavesGlAsItWasAndIsNotDisturbedByIt) {
    for (const Call& call : inputs_->everyCall()) {
        open(test::GlApi::Core45);  // a context of its own for each: what one leaves does not hide another's
        if (IsSkipped()) return;
        makeContext();
        const std::vector<float> expected = drawn(call, *gpu_);
        const test::WrappedGl driver(context_->loader());
        const test::DrawnView view(gl_, inputs_->drawing);
        view.fill(0.25F, 0.5F, 0.75F);
        const State state(gl_, driver);
        std::string changed;
        {
            const OddState odd(gl_, driver);
            ASSERT_EQ(gl_.firstError(), GLenum(GL_NO_ERROR)) << "the state that was set makes sense";
            const auto before = state.read();
            const Status done = call.run(*gpu_, view);
            EXPECT_TRUE(done.ok()) << call.name << ": " << (done.ok() ? "" : done.error().message);
            changed = differences(before, state.read());
        }
        EXPECT_EQ(changed, "") << call.name;
        // Read with GL's own way to pack.
        gl_.PixelStorei(GL_PACK_ALIGNMENT, 4), gl_.PixelStorei(GL_PACK_ROW_LENGTH, 0);
        gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
        EXPECT_EQ(view.pixels(), expected) << call.name;
    }
}

}  // namespace
}  // namespace photic::runtime
