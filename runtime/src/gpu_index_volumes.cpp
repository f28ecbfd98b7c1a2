// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gpu_index_volumes.h"

#include <algorithm>

#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"
#include "runtime/src/index_atlas_bytes.h"

namespace photic::runtime {
namespace {

/// How GL is told of texels.
struct TextureKind {
    GLenum internal, format, type;
    GLint filter;
};
TextureKind kindOf(TexelFormat format) {
    switch (format) {
        case TexelFormat::R32Float:
            return {GL_R32F, GL_RED, GL_FLOAT, GL_NEAREST};
        case TexelFormat::R8:
            return {GL_R8, GL_RED, GL_UNSIGNED_BYTE, GL_LINEAR};
        case TexelFormat::Rgba8:
            return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, GL_LINEAR};
        case TexelFormat::Rgba32Uint:
            return {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, GL_NEAREST};
        case TexelFormat::R8Uint:
            return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, GL_NEAREST};
        default:
            return {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, GL_LINEAR};
    }
}

void makeTexture(const GlFunctions& gl, GLenum target, const TextureBytes& texture, GLuint& name) {
    const TextureKind kind = kindOf(texture.format);
    const auto x = static_cast<GLsizei>(texture.size[0]), y = static_cast<GLsizei>(texture.size[1]),
               z = static_cast<GLsizei>(texture.size[2]);
    gl.GenTextures(1, &name);
    gl.BindTexture(target, name);
    const bool flat = target == GL_TEXTURE_2D;
    if (flat)
        gl.TexStorage2D(target, 1, kind.internal, x, y);
    else
        gl.TexStorage3D(target, 1, kind.internal, x, y, z);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl.TexParameteri(target, filter, kind.filter);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        if (!flat || wrap != GL_TEXTURE_WRAP_R) gl.TexParameteri(target, wrap, GL_CLAMP_TO_EDGE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (flat)
        gl.TexSubImage2D(target, 0, 0, 0, x, y, kind.format, kind.type, texture.texels.data());
    else
        gl.TexSubImage3D(target, 0, 0, 0, 0, x, y, z, kind.format, kind.type, texture.texels.data());
    if (gl.firstError() != GL_NO_ERROR)
        fail(ErrorCode::Memory, "no GPU memory is left for index volumes of " + std::to_string(x) + " x " +
                                    std::to_string(y) + " x " + std::to_string(z) + " texels");
}

}  // namespace

void GpuIndexVolumes::Impl::destroy() {
    for (GLuint* texture : {&spline, &gradients, &attenuation, &glow, &faces, &block_reach, &shapes}) {
        if (*texture) context.gl().DeleteTextures(1, texture);
        *texture = 0;
    }
}

void GpuIndexVolumes::Impl::make(const std::vector<IndexVolume>& volumes) {
    const GlFunctions& gl = context.gl();
    GLint layers = 0;
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    const IndexVolumeBytes bytes =
        atlasBytes(volumes, std::min(gl.largest_texture_3d, std::max(layers, 256)), gl.largest_texture_2d);
    makeTexture(gl, GL_TEXTURE_2D_ARRAY, bytes.spline, spline);
    makeTexture(gl, GL_TEXTURE_3D, bytes.gradients, gradients);
    makeTexture(gl, GL_TEXTURE_3D, bytes.attenuation, attenuation);
    makeTexture(gl, GL_TEXTURE_3D, bytes.glow, glow);
    makeTexture(gl, GL_TEXTURE_3D, bytes.faces, faces);
    makeTexture(gl, GL_TEXTURE_3D, bytes.blocks, block_reach);
    makeTexture(gl, GL_TEXTURE_2D, bytes.shapes, shapes);
    info = bytes.info;
    placed = *bytes.objects;
}

void GpuIndexVolumes::Impl::bind() const {
    const GlFunctions& gl = context.gl();
    const auto texture = [&](unsigned unit, GLenum target, GLuint name) {
        gl.ActiveTexture(GL_TEXTURE0 + unit);
        gl.BindSampler(unit, 0);
        gl.BindTexture(target, name);
    };
    texture(5, GL_TEXTURE_3D, faces);
    texture(6, GL_TEXTURE_3D, gradients);
    texture(7, GL_TEXTURE_2D_ARRAY, spline);
    texture(8, GL_TEXTURE_3D, attenuation);
    texture(9, GL_TEXTURE_3D, glow);
    texture(10, GL_TEXTURE_3D, block_reach);
    texture(12, GL_TEXTURE_2D, shapes);
}

GpuIndexVolumes::GpuIndexVolumes(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpuIndexVolumes::GpuIndexVolumes(GpuIndexVolumes&&) noexcept = default;
GpuIndexVolumes& GpuIndexVolumes::operator=(GpuIndexVolumes&&) noexcept = default;
GpuIndexVolumes::~GpuIndexVolumes() = default;

const GpuIndexVolumes::Info& GpuIndexVolumes::info() const { return impl_->info; }
void GpuIndexVolumes::abandon() {
    impl_->spline = impl_->gradients = impl_->attenuation = impl_->glow = impl_->faces = impl_->block_reach =
        impl_->shapes = 0;
}

Result<GpuIndexVolumes> GpuIndexVolumes::upload(const GpuContext& context, const std::vector<IndexVolume>& objects) {
    return guarded([&]() -> Result<GpuIndexVolumes> {
        const GlFunctions& gl = context.gl();
        gl.clearErrors();
        const GlStateGuard guard(gl);
        gl.ActiveTexture(GL_TEXTURE0);
        auto impl = std::make_unique<Impl>(context);
        impl->make(objects);
        return GpuIndexVolumes(std::move(impl));
    });
}

}  // namespace photic::runtime
