// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_state.h"

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
    {{GL_VIEWPORT}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.Viewport(v[0], v[1], v[2], v[3]); }},
    {{GL_SCISSOR_BOX}, [](const GlFunctions& gl, GLenum, const GLint* v) { gl.Scissor(v[0], v[1], v[2], v[3]); }},
    {{GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.BlendEquationSeparate(choice(v[0]), choice(v[1])); }},
    {{GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA},
     [](const GlFunctions& gl, GLenum, const GLint* v) {
         gl.BlendFuncSeparate(choice(v[0]), choice(v[1]), choice(v[2]), choice(v[3]));
     }},
    {{GL_COLOR_WRITEMASK},
     [](const GlFunctions& gl, GLenum, const GLint* v) { gl.ColorMask(v[0] != 0, v[1] != 0, v[2] != 0, v[3] != 0); }},
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
constexpr Capability kCapabilityTable[] = {{GL_BLEND},
                                           {GL_DEPTH_TEST},
                                           {GL_STENCIL_TEST},
                                           {GL_SCISSOR_TEST},
                                           {GL_CULL_FACE},
                                           {GL_RASTERIZER_DISCARD},
                                           {GL_POLYGON_OFFSET_FILL},
                                           {GL_SAMPLE_ALPHA_TO_COVERAGE},
                                           {GL_COLOR_LOGIC_OP, In::Desktop},
                                           {GL_FRAMEBUFFER_SRGB, In::Desktop},
                                           {GL_DEPTH_CLAMP, In::Desktop},
                                           {GL_PROGRAM_POINT_SIZE, In::Desktop}};

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

void GlStateGuard::setForPasses() const {
    eachRow(gl_, kCapabilityTable, [&](const Capability& capability, std::size_t) {
        // Whether the target's texels are sRGB is the game's to know.
        if (capability.name != GL_FRAMEBUFFER_SRGB) gl_.Disable(capability.name);
    });
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
    saveTextureUnits();
    saveBuffers(uniforms_, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
    saveBuffers(storage_, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                GL_SHADER_STORAGE_BUFFER_SIZE);
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
}

}  // namespace photic::runtime
