// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_state.h"

#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

GLuint object(GLint value) { return static_cast<GLuint>(value); }
GLenum choice(GLint value) { return static_cast<GLenum>(value); }

enum class In { Both, Desktop };  ///< whether ES knows it too

/// A piece of state: what to ask GL for, one name with up to four values or several names with one each, and what puts
/// these values back.
struct Item {
    std::array<GLenum, 4> names;
    void (*restore)(const GlFunctions& gl, GLenum first_name, const GLint* v);
    In in = In::Both;
};

void restorePixelStorage(const GlFunctions& gl, GLenum parameter, const GLint* v) { gl.PixelStorei(parameter, v[0]); }

template <GLenum kTarget>
void restoreBuffer(const GlFunctions& gl, GLenum, const GLint* v) {
    gl.BindBuffer(kTarget, object(v[0]));
}

constexpr Item kItemTable[] = {
    {{GL_VERTEX_ARRAY_BINDING},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.BindVertexArray(object(v[0])); }},
    {{GL_ARRAY_BUFFER_BINDING}, restoreBuffer<GL_ARRAY_BUFFER>},
    {{GL_UNIFORM_BUFFER_BINDING}, restoreBuffer<GL_UNIFORM_BUFFER>},
    {{GL_SHADER_STORAGE_BUFFER_BINDING}, restoreBuffer<GL_SHADER_STORAGE_BUFFER>},
    {{GL_PIXEL_UNPACK_BUFFER_BINDING}, restoreBuffer<GL_PIXEL_UNPACK_BUFFER>},
    {{GL_PIXEL_PACK_BUFFER_BINDING}, restoreBuffer<GL_PIXEL_PACK_BUFFER>},
    {{GL_CURRENT_PROGRAM}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.UseProgram(object(v[0])); }},
    {{GL_DRAW_FRAMEBUFFER_BINDING},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, object(v[0])); }},
    {{GL_READ_FRAMEBUFFER_BINDING},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.BindFramebuffer(GL_READ_FRAMEBUFFER, object(v[0])); }},
    {{GL_DEPTH_WRITEMASK}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.DepthMask(v[0] != 0); }},
    {{GL_DEPTH_FUNC}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.DepthFunc(choice(v[0])); }},
    {{GL_CULL_FACE_MODE}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.CullFace(choice(v[0])); }},
    {{GL_FRONT_FACE}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.FrontFace(choice(v[0])); }},
    // Core contexts write one value, compatibility ones two (front, back).
    {{GL_POLYGON_MODE},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.PolygonMode(GL_FRONT_AND_BACK, choice(v[0])); },
     In::Desktop},
    {{GL_UNPACK_ALIGNMENT}, restorePixelStorage},
    {{GL_UNPACK_ROW_LENGTH}, restorePixelStorage},
    {{GL_UNPACK_IMAGE_HEIGHT}, restorePixelStorage},
    {{GL_UNPACK_SKIP_PIXELS}, restorePixelStorage},
    {{GL_UNPACK_SKIP_ROWS}, restorePixelStorage},
    {{GL_UNPACK_SKIP_IMAGES}, restorePixelStorage},
    {{GL_PACK_ALIGNMENT}, restorePixelStorage},
    {{GL_PACK_ROW_LENGTH}, restorePixelStorage},
};

struct FloatItem {
    GLenum name;
    void (*restore)(const GlFunctions& gl, const GLfloat* v);
};
constexpr FloatItem kFloatItemTable[] = {
    {GL_BLEND_COLOR, [](const GlFunctions& gl, const GLfloat* v) { gl.BlendColor(v[0], v[1], v[2], v[3]); }},
    {GL_COLOR_CLEAR_VALUE, [](const GlFunctions& gl, const GLfloat* v) { gl.ClearColor(v[0], v[1], v[2], v[3]); }},
};

struct Capability {
    GLenum name;
    In in = In::Both;
};
constexpr Capability kCapabilityTable[] = {
    {GL_DEPTH_TEST},
    {GL_STENCIL_TEST},
    {GL_CULL_FACE},
    {GL_RASTERIZER_DISCARD},
    {GL_POLYGON_OFFSET_FILL},
    {GL_SAMPLE_ALPHA_TO_COVERAGE},
    {GL_SAMPLE_COVERAGE},
    {GL_SAMPLE_MASK},
    {GL_PRIMITIVE_RESTART_FIXED_INDEX},
    {GL_COLOR_LOGIC_OP, In::Desktop},
    {GL_FRAMEBUFFER_SRGB, In::Desktop},
    {GL_DEPTH_CLAMP, In::Desktop},
    {GL_PROGRAM_POINT_SIZE, In::Desktop},
    {GL_PRIMITIVE_RESTART, In::Desktop},
    {GL_CLIP_DISTANCE0, In::Desktop},
    {GL_CLIP_DISTANCE1, In::Desktop},
    {GL_CLIP_DISTANCE2, In::Desktop},
    {GL_CLIP_DISTANCE3, In::Desktop},
    {GL_CLIP_DISTANCE4, In::Desktop},
    {GL_CLIP_DISTANCE5, In::Desktop},
    {GL_CLIP_DISTANCE6, In::Desktop},
    {GL_CLIP_DISTANCE7, In::Desktop},
};

GLint integer(const GlFunctions& gl, GLenum name) {
    GLint value = 0;
    gl.GetIntegerv(name, &value);
    return value;
}

/// Calls use(row, its number) for the rows of a table that the context knows.
template <class Row, std::size_t kRows, class Use>
void eachRow(const GlFunctions& gl, const Row (&table)[kRows], const Use& use) {
    for (std::size_t i = 0; i < kRows; ++i) {
        if (!gl.es || table[i].in == In::Both) use(table[i], i);
    }
}

}  // namespace

void GlStateGuard::saveTextureUnits() {
    active_texture_ = integer(gl_, GL_ACTIVE_TEXTURE);
    for (GLuint i = 0; i < kTextureUnits; ++i) {
        gl_.ActiveTexture(GL_TEXTURE0 + i);
        units_[i] = {integer(gl_, GL_TEXTURE_BINDING_2D), integer(gl_, GL_TEXTURE_BINDING_2D_ARRAY),
                     integer(gl_, GL_TEXTURE_BINDING_3D), integer(gl_, GL_SAMPLER_BINDING)};
        gl_.BindSampler(i, 0);
    }
}

void GlStateGuard::restoreTextureUnits() const {
    for (GLuint i = 0; i < kTextureUnits; ++i) {
        gl_.ActiveTexture(GL_TEXTURE0 + i);
        gl_.BindTexture(GL_TEXTURE_2D, object(units_[i].texture_2d));
        gl_.BindTexture(GL_TEXTURE_2D_ARRAY, object(units_[i].texture_2d_array));
        gl_.BindTexture(GL_TEXTURE_3D, object(units_[i].texture_3d));
        gl_.BindSampler(i, object(units_[i].sampler));
    }
    gl_.ActiveTexture(choice(active_texture_));
}

void GlStateGuard::saveBuffers(IndexedBuffers& bindings, GLenum buffer, GLenum start, GLenum size) const {
    for (GLuint i = 0; i < kBufferBindings; ++i) {
        gl_.GetIntegeri_v(buffer, i, &bindings[i].buffer);
        gl_.GetInteger64i_v(start, i, &bindings[i].start);
        gl_.GetInteger64i_v(size, i, &bindings[i].size);
    }
}

void GlStateGuard::restoreBuffers(const IndexedBuffers& bindings, GLenum target) const {
    for (GLuint i = 0; i < kBufferBindings; ++i) {
        const BufferBinding& b = bindings[i];
        if (b.size == 0) {
            gl_.BindBufferBase(target, i, object(b.buffer));
        } else {
            gl_.BindBufferRange(target, i, object(b.buffer), static_cast<GLintptr>(b.start),
                                static_cast<GLsizeiptr>(b.size));
        }
    }
}

void GlStateGuard::saveDrawBuffers() {
    constexpr GLenum kBlending[6] = {GL_BLEND_SRC_RGB,   GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,
                                     GL_BLEND_DST_ALPHA, GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA};
    for (GLuint i = 0; i < gl_.draw_buffers; ++i) {
        DrawBuffer& buffer = draw_buffers_[i];
        if (gl_.draw_buffers == 1) {
            buffer.blends = gl_.IsEnabled(GL_BLEND);
            gl_.GetBooleanv(GL_COLOR_WRITEMASK, buffer.mask.data());
            for (std::size_t n = 0; n < 6; ++n) gl_.GetIntegerv(kBlending[n], &buffer.blending[n]);
        } else {
            buffer.blends = gl_.IsEnabledi(GL_BLEND, i);
            gl_.GetBooleani_v(GL_COLOR_WRITEMASK, i, buffer.mask.data());
            for (std::size_t n = 0; n < 6; ++n) gl_.GetIntegeri_v(kBlending[n], i, &buffer.blending[n]);
        }
    }
}

void GlStateGuard::restoreDrawBuffers() const {
    for (GLuint i = 0; i < gl_.draw_buffers; ++i) {
        const DrawBuffer& buffer = draw_buffers_[i];
        const auto& b = buffer.blending;
        const auto& mask = buffer.mask;
        if (gl_.draw_buffers == 1) {
            buffer.blends ? gl_.Enable(GL_BLEND) : gl_.Disable(GL_BLEND);
            gl_.ColorMask(mask[0], mask[1], mask[2], mask[3]);
            gl_.BlendFuncSeparate(choice(b[0]), choice(b[1]), choice(b[2]), choice(b[3]));
            gl_.BlendEquationSeparate(choice(b[4]), choice(b[5]));
        } else {
            buffer.blends ? gl_.Enablei(GL_BLEND, i) : gl_.Disablei(GL_BLEND, i);
            gl_.ColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
            gl_.BlendFuncSeparatei(i, choice(b[0]), choice(b[1]), choice(b[2]), choice(b[3]));
            gl_.BlendEquationSeparatei(i, choice(b[4]), choice(b[5]));
        }
    }
}

void GlStateGuard::saveViewport() {
    if (gl_.viewports) {
        gl_.GetFloati_v(GL_VIEWPORT, 0, viewport_.data());
        gl_.GetIntegeri_v(GL_SCISSOR_BOX, 0, scissor_.data());
        scissors_ = gl_.IsEnabledi(GL_SCISSOR_TEST, 0);
        gl_.Disablei(GL_SCISSOR_TEST, 0);
    } else {
        gl_.GetFloatv(GL_VIEWPORT, viewport_.data());
        gl_.GetIntegerv(GL_SCISSOR_BOX, scissor_.data());
        scissors_ = gl_.IsEnabled(GL_SCISSOR_TEST);
        gl_.Disable(GL_SCISSOR_TEST);
    }
    if (!gl_.clip_control) return;
    for (std::size_t n = 0; n < 2; ++n) gl_.GetIntegerv(n == 0 ? GL_CLIP_ORIGIN : GL_CLIP_DEPTH_MODE, &clip_[n]);
    gl_.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void GlStateGuard::restoreViewport() const {
    const auto& v = viewport_;
    const auto& s = scissor_;
    if (gl_.viewports) {
        gl_.ViewportIndexedf(0, v[0], v[1], v[2], v[3]);
        gl_.ScissorIndexed(0, s[0], s[1], s[2], s[3]);
        scissors_ ? gl_.Enablei(GL_SCISSOR_TEST, 0) : gl_.Disablei(GL_SCISSOR_TEST, 0);
    } else {
        gl_.Viewport(static_cast<GLint>(v[0]), static_cast<GLint>(v[1]), static_cast<GLsizei>(v[2]),
                     static_cast<GLsizei>(v[3]));
        gl_.Scissor(s[0], s[1], s[2], s[3]);
        scissors_ ? gl_.Enable(GL_SCISSOR_TEST) : gl_.Disable(GL_SCISSOR_TEST);
    }
    if (gl_.clip_control) gl_.ClipControl(choice(clip_[0]), choice(clip_[1]));
}

void GlStateGuard::setForPasses() const {
    eachRow(gl_, kCapabilityTable, [&](const Capability& capability, std::size_t) {
        // Whether the target's texels are sRGB is the game's to know.
        if (capability.name != GL_FRAMEBUFFER_SRGB) gl_.Disable(capability.name);
    });
    gl_.Disable(GL_BLEND);
    gl_.BlendEquationSeparate(GL_FUNC_ADD, GL_FUNC_ADD);
    gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl_.DepthMask(GL_FALSE);
    if (!gl_.es) gl_.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (const Item& item : kItemTable) {
        const GLenum parameter = item.names[0];
        if (item.restore != restorePixelStorage) continue;
        gl_.PixelStorei(parameter, parameter == GL_UNPACK_ALIGNMENT || parameter == GL_PACK_ALIGNMENT ? 4 : 0);
    }
}

GlStateGuard::GlStateGuard(const GlFunctions& gl) : gl_(gl) {
    static_assert(std::size(kItemTable) == kItems && std::size(kFloatItemTable) == kFloatItems &&
                  std::size(kCapabilityTable) == kCapabilities);
    if (const std::optional<Error> lost = gl.lost()) throw Failure{*lost};
    saveTextureUnits();
    saveBuffers(uniforms_, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
    saveBuffers(storage_, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                GL_SHADER_STORAGE_BUFFER_SIZE);
    saveDrawBuffers();
    saveViewport();
    eachRow(gl_, kItemTable, [&](const Item& item, std::size_t i) {
        for (std::size_t n = 0; n < item.names.size() && item.names[n] != 0; ++n)
            gl_.GetIntegerv(item.names[n], &items_[i][n]);
    });
    for (std::size_t i = 0; i < kFloatItems; ++i) gl_.GetFloatv(kFloatItemTable[i].name, float_items_[i].data());
    eachRow(gl_, kCapabilityTable,
            [&](const Capability& capability, std::size_t i) { enabled_[i] = gl_.IsEnabled(capability.name); });
    setForPasses();
}

GlStateGuard::~GlStateGuard() {
    restoreTextureUnits();
    // The indexed bindings before the items: setting them changes the generic ones.
    restoreBuffers(uniforms_, GL_UNIFORM_BUFFER);
    restoreBuffers(storage_, GL_SHADER_STORAGE_BUFFER);
    eachRow(gl_, kItemTable,
            [&](const Item& item, std::size_t i) { item.restore(gl_, item.names[0], items_[i].data()); });
    for (std::size_t i = 0; i < kFloatItems; ++i) kFloatItemTable[i].restore(gl_, float_items_[i].data());
    eachRow(gl_, kCapabilityTable, [&](const Capability& capability, std::size_t i) {
        enabled_[i] == GL_TRUE ? gl_.Enable(capability.name) : gl_.Disable(capability.name);
    });
    restoreDrawBuffers();
    restoreViewport();
}

}  // namespace photic::runtime
