// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "runtime/src/gl_functions.h"

namespace photic::runtime {

/// What the library's calls may change, saved when made and put back when destroyed: programs, vertex arrays,
/// framebuffers, the first viewport, the first texture units and buffer bindings, blending and masks of each colour
/// buffer, tests, clip control, pixel storage.
///
/// The constructor also sets what a full-screen pass needs and no game's leftover may break: no depth, stencil, scissor
/// or discarding, no culling or clip distances, filled polygons, all colours written, GL's own clip space, pixels
/// unpacked from client memory, tightly. Costs some hundred and fifty glGet calls: one guard per pass, not per draw.
class GlStateGuard {
public:
    static constexpr int kTextureUnits = 13;   ///< units 0 to 12 are put back; the library uses no other
    static constexpr int kBufferBindings = 6;  ///< uniform and storage bindings 0 to 5 likewise

    /// @throws Failure{Lost} as GlFunctions::lost says
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
    using IndexedBuffers = std::array<BufferBinding, kBufferBindings>;
    struct DrawBuffer {
        GLboolean blends = GL_FALSE;
        std::array<GLboolean, 4> mask{};
        std::array<GLint, 6> blending{};
    };
    static constexpr std::size_t kItems = 22, kFloatItems = 2,
                                 kCapabilities = 22;  ///< rows of the tables in gl_state.cpp

    void saveTextureUnits();
    void restoreTextureUnits() const;
    void saveBuffers(IndexedBuffers& bindings, GLenum buffer, GLenum start, GLenum size) const;
    void restoreBuffers(const IndexedBuffers& bindings, GLenum target) const;
    void saveDrawBuffers();
    void restoreDrawBuffers() const;
    void saveViewport();
    void restoreViewport() const;
    void setForPasses() const;

    const GlFunctions& gl_;
    GLint active_texture_ = 0;
    std::array<TextureUnit, kTextureUnits> units_;
    IndexedBuffers uniforms_, storage_;
    std::array<std::array<GLint, 4>, kItems> items_{};
    std::array<std::array<GLfloat, 4>, kFloatItems> float_items_{};
    std::array<GLboolean, kCapabilities> enabled_{};
    std::array<DrawBuffer, 8> draw_buffers_{};  ///< as many as GlFunctions::draw_buffers
    std::array<GLfloat, 4> viewport_{};         ///< the first
    std::array<GLint, 4> scissor_{};            ///< of the first viewport
    GLboolean scissors_ = GL_FALSE;
    std::array<GLint, 2> clip_{};  ///< control
};

}  // namespace photic::runtime
