// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_state.h"

namespace photic::runtime {
namespace {

GLint integer(const GlFunctions& gl, GLenum name) {
    GLint value = 0;
    gl.GetIntegerv(name, &value);
    return value;
}

void setEnabled(const GlFunctions& gl, GLenum capability, bool on) {
    if (on) {
        gl.Enable(capability);
    } else {
        gl.Disable(capability);
    }
}

}  // namespace

void GlStateGuard::saveBindings() {
    active_texture_ = integer(gl_, GL_ACTIVE_TEXTURE);
    for (int i = 0; i < kTextureUnits; ++i) {
        gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
        TextureUnit& unit = units_[static_cast<std::size_t>(i)];
        unit.texture_2d = integer(gl_, GL_TEXTURE_BINDING_2D);
        unit.texture_2d_array = integer(gl_, GL_TEXTURE_BINDING_2D_ARRAY);
        unit.texture_3d = integer(gl_, GL_TEXTURE_BINDING_3D);
        unit.sampler = integer(gl_, GL_SAMPLER_BINDING);
        gl_.BindSampler(static_cast<GLuint>(i), 0);
    }
    const auto save = [&](std::array<BufferBinding, kBufferBindings>& bindings, GLenum buffer, GLenum start,
                          GLenum size) {
        for (GLuint i = 0; i < kBufferBindings; ++i) {
            gl_.GetIntegeri_v(buffer, i, &bindings[i].buffer);
            gl_.GetInteger64i_v(start, i, &bindings[i].start);
            gl_.GetInteger64i_v(size, i, &bindings[i].size);
        }
    };
    save(uniforms_, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
    save(storage_, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE);
    program_ = integer(gl_, GL_CURRENT_PROGRAM);
    vertex_array_ = integer(gl_, GL_VERTEX_ARRAY_BINDING);
    draw_framebuffer_ = integer(gl_, GL_DRAW_FRAMEBUFFER_BINDING);
    read_framebuffer_ = integer(gl_, GL_READ_FRAMEBUFFER_BINDING);
    array_buffer_ = integer(gl_, GL_ARRAY_BUFFER_BINDING);
    uniform_buffer_ = integer(gl_, GL_UNIFORM_BUFFER_BINDING);
    storage_buffer_ = integer(gl_, GL_SHADER_STORAGE_BUFFER_BINDING);
    unpack_buffer_ = integer(gl_, GL_PIXEL_UNPACK_BUFFER_BINDING);
    pack_buffer_ = integer(gl_, GL_PIXEL_PACK_BUFFER_BINDING);
}

void GlStateGuard::restoreBindings() const {
    for (int i = 0; i < kTextureUnits; ++i) {
        gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
        const TextureUnit& unit = units_[static_cast<std::size_t>(i)];
        gl_.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(unit.texture_2d));
        gl_.BindTexture(GL_TEXTURE_2D_ARRAY, static_cast<GLuint>(unit.texture_2d_array));
        gl_.BindTexture(GL_TEXTURE_3D, static_cast<GLuint>(unit.texture_3d));
        gl_.BindSampler(static_cast<GLuint>(i), static_cast<GLuint>(unit.sampler));
    }
    gl_.ActiveTexture(static_cast<GLenum>(active_texture_));
    const auto restore = [&](const std::array<BufferBinding, kBufferBindings>& bindings, GLenum target) {
        for (GLuint i = 0; i < kBufferBindings; ++i) {
            const BufferBinding& b = bindings[i];
            const auto buffer = static_cast<GLuint>(b.buffer);
            if (b.size == 0) {
                gl_.BindBufferBase(target, i, buffer);
            } else {
                gl_.BindBufferRange(target, i, buffer, static_cast<GLintptr>(b.start), static_cast<GLsizeiptr>(b.size));
            }
        }
    };
    // The indexed bindings first: setting them changes the generic ones.
    restore(uniforms_, GL_UNIFORM_BUFFER);
    restore(storage_, GL_SHADER_STORAGE_BUFFER);
    gl_.BindVertexArray(static_cast<GLuint>(vertex_array_));
    gl_.BindBuffer(GL_ARRAY_BUFFER, static_cast<GLuint>(array_buffer_));
    gl_.BindBuffer(GL_UNIFORM_BUFFER, static_cast<GLuint>(uniform_buffer_));
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(storage_buffer_));
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(unpack_buffer_));
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack_buffer_));
    gl_.UseProgram(static_cast<GLuint>(program_));
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
}

GlStateGuard::GlStateGuard(const GlFunctions& gl) : gl_(gl) {
    saveBindings();
    for (std::size_t i = 0; i < capabilities(); ++i) enabled_[i] = gl_.IsEnabled(kCapabilities[i]);
    gl_.GetIntegerv(GL_VIEWPORT, viewport_);
    gl_.GetIntegerv(GL_SCISSOR_BOX, scissor_);
    blend_equation_rgb_ = integer(gl_, GL_BLEND_EQUATION_RGB);
    blend_equation_alpha_ = integer(gl_, GL_BLEND_EQUATION_ALPHA);
    blend_source_rgb_ = integer(gl_, GL_BLEND_SRC_RGB);
    blend_source_alpha_ = integer(gl_, GL_BLEND_SRC_ALPHA);
    blend_target_rgb_ = integer(gl_, GL_BLEND_DST_RGB);
    blend_target_alpha_ = integer(gl_, GL_BLEND_DST_ALPHA);
    gl_.GetFloatv(GL_BLEND_COLOR, blend_color_);
    gl_.GetFloatv(GL_COLOR_CLEAR_VALUE, clear_color_);
    gl_.GetBooleanv(GL_COLOR_WRITEMASK, color_mask_);
    gl_.GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    depth_function_ = integer(gl_, GL_DEPTH_FUNC);
    cull_face_ = integer(gl_, GL_CULL_FACE_MODE);
    front_face_ = integer(gl_, GL_FRONT_FACE);
    // Core contexts write one value, compatibility ones two (front, back).
    if (!gl_.es) gl_.GetIntegerv(GL_POLYGON_MODE, polygon_mode_);
    unpack_alignment_ = integer(gl_, GL_UNPACK_ALIGNMENT);
    unpack_row_length_ = integer(gl_, GL_UNPACK_ROW_LENGTH);
    unpack_image_height_ = integer(gl_, GL_UNPACK_IMAGE_HEIGHT);
    unpack_skip_pixels_ = integer(gl_, GL_UNPACK_SKIP_PIXELS);
    unpack_skip_rows_ = integer(gl_, GL_UNPACK_SKIP_ROWS);
    unpack_skip_images_ = integer(gl_, GL_UNPACK_SKIP_IMAGES);
    pack_alignment_ = integer(gl_, GL_PACK_ALIGNMENT);
    pack_row_length_ = integer(gl_, GL_PACK_ROW_LENGTH);

    for (std::size_t i = 0; i < capabilities(); ++i) {
        // Whether the target's texels are sRGB is the game's to know.
        if (kCapabilities[i] != GL_FRAMEBUFFER_SRGB) gl_.Disable(kCapabilities[i]);
    }
    gl_.BlendEquationSeparate(GL_FUNC_ADD, GL_FUNC_ADD);
    gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl_.DepthMask(GL_FALSE);
    if (!gl_.es) gl_.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (const GLenum name : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS,
                              GL_UNPACK_SKIP_IMAGES, GL_PACK_ROW_LENGTH}) {
        gl_.PixelStorei(name, 0);
    }
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
}

GlStateGuard::~GlStateGuard() {
    restoreBindings();
    for (std::size_t i = 0; i < capabilities(); ++i) setEnabled(gl_, kCapabilities[i], enabled_[i] == GL_TRUE);
    gl_.Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    gl_.Scissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
    const auto asEnum = [](GLint value) { return static_cast<GLenum>(value); };
    gl_.BlendEquationSeparate(asEnum(blend_equation_rgb_), asEnum(blend_equation_alpha_));
    gl_.BlendFuncSeparate(asEnum(blend_source_rgb_), asEnum(blend_target_rgb_), asEnum(blend_source_alpha_),
                          asEnum(blend_target_alpha_));
    gl_.BlendColor(blend_color_[0], blend_color_[1], blend_color_[2], blend_color_[3]);
    gl_.ClearColor(clear_color_[0], clear_color_[1], clear_color_[2], clear_color_[3]);
    gl_.ColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
    gl_.DepthMask(depth_mask_);
    gl_.DepthFunc(asEnum(depth_function_));
    gl_.CullFace(asEnum(cull_face_));
    gl_.FrontFace(asEnum(front_face_));
    if (!gl_.es) gl_.PolygonMode(GL_FRONT_AND_BACK, asEnum(polygon_mode_[0]));
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, unpack_alignment_);
    gl_.PixelStorei(GL_UNPACK_ROW_LENGTH, unpack_row_length_);
    gl_.PixelStorei(GL_UNPACK_IMAGE_HEIGHT, unpack_image_height_);
    gl_.PixelStorei(GL_UNPACK_SKIP_PIXELS, unpack_skip_pixels_);
    gl_.PixelStorei(GL_UNPACK_SKIP_ROWS, unpack_skip_rows_);
    gl_.PixelStorei(GL_UNPACK_SKIP_IMAGES, unpack_skip_images_);
    gl_.PixelStorei(GL_PACK_ALIGNMENT, pack_alignment_);
    gl_.PixelStorei(GL_PACK_ROW_LENGTH, pack_row_length_);
}

}  // namespace photic::runtime
