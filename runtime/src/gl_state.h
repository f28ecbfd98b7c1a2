// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "runtime/src/gl_functions.h"

namespace photic::runtime {

/// What the library's calls may change, saved when made and put back when destroyed: programs, vertex arrays,
/// framebuffers, viewport, the first texture units and buffer bindings, blending, masks, tests, pixel storage.
///
/// The constructor also sets what a full-screen pass needs and no game's leftover may break: no depth, stencil, scissor
/// or discarding, no culling, filled polygons, all colours written, pixels unpacked from client memory, tightly.
/// Costs some eighty glGet calls: one guard per pass, not per draw.
class GlStateGuard {
public:
    static constexpr int kTextureUnits = 10;   ///< units 0 to 9 are put back; the library uses no other
    static constexpr int kBufferBindings = 6;  ///< uniform and storage bindings 0 to 5 likewise

    explicit GlStateGuard(const GlFunctions& gl);
    ~GlStateGuard();
    GlStateGuard(const GlStateGuard&) = delete;
    GlStateGuard& operator=(const GlStateGuard&) = delete;

private:
    struct TextureUnit {
        GLint texture_2d = 0, texture_2d_array = 0, texture_3d = 0, sampler = 0;
    };
    struct BufferBinding {
        GLint buffer = 0;
        GLint64 start = 0, size = 0;
    };
    /// The capabilities that are saved; not all are in ES.
    static constexpr std::array<GLenum, 12> kCapabilities = {
        GL_BLEND,          GL_DEPTH_TEST,         GL_STENCIL_TEST,        GL_SCISSOR_TEST,
        GL_CULL_FACE,      GL_RASTERIZER_DISCARD, GL_POLYGON_OFFSET_FILL, GL_SAMPLE_ALPHA_TO_COVERAGE,
        GL_COLOR_LOGIC_OP, GL_FRAMEBUFFER_SRGB,   GL_DEPTH_CLAMP,         GL_PROGRAM_POINT_SIZE};
    static constexpr std::size_t kCapabilitiesOfEs = 8;  ///< the first so many are in ES too

    std::size_t capabilities() const { return gl_.es ? kCapabilitiesOfEs : kCapabilities.size(); }
    void saveBindings();
    void restoreBindings() const;

    const GlFunctions& gl_;
    std::array<TextureUnit, kTextureUnits> units_;
    std::array<BufferBinding, kBufferBindings> uniforms_, storage_;
    std::array<GLboolean, kCapabilities.size()> enabled_{};
    GLint active_texture_ = 0, program_ = 0, vertex_array_ = 0, draw_framebuffer_ = 0, read_framebuffer_ = 0;
    GLint array_buffer_ = 0, uniform_buffer_ = 0, storage_buffer_ = 0, unpack_buffer_ = 0, pack_buffer_ = 0;
    GLint viewport_[4] = {}, scissor_[4] = {};
    GLint blend_equation_rgb_ = 0, blend_equation_alpha_ = 0;
    GLint blend_source_rgb_ = 0, blend_source_alpha_ = 0, blend_target_rgb_ = 0, blend_target_alpha_ = 0;
    GLfloat blend_color_[4] = {}, clear_color_[4] = {};
    GLboolean color_mask_[4] = {}, depth_mask_ = GL_TRUE;
    GLint depth_function_ = 0, cull_face_ = 0, front_face_ = 0, polygon_mode_[2] = {};
    GLint unpack_alignment_ = 0, unpack_row_length_ = 0, unpack_image_height_ = 0, unpack_skip_pixels_ = 0,
          unpack_skip_rows_ = 0, unpack_skip_images_ = 0, pack_alignment_ = 0, pack_row_length_ = 0;
};

}  // namespace photic::runtime
