// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gpu_index_volumes.h"

#include <algorithm>

#include "runtime/src/gl_state.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

struct TextureKind {
    GLenum target, internal, format, type;
    GLint filter;
};
constexpr TextureKind kSpline{GL_TEXTURE_2D_ARRAY, GL_R32F, GL_RED, GL_FLOAT, GL_NEAREST};
constexpr TextureKind kFourHalves{GL_TEXTURE_3D, GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, GL_LINEAR};
constexpr TextureKind kBytes{GL_TEXTURE_3D, GL_R8, GL_RED, GL_UNSIGNED_BYTE, GL_LINEAR};
constexpr TextureKind kFourBytes{GL_TEXTURE_3D, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, GL_LINEAR};
constexpr TextureKind kNumbers{GL_TEXTURE_3D, GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, GL_NEAREST};

void makeTexture(const GlFunctions& gl, const TextureKind& kind, const Int3& size, const void* texels, GLuint& name) {
    gl.GenTextures(1, &name);
    gl.BindTexture(kind.target, name);
    gl.TexStorage3D(kind.target, 1, kind.internal, size[0], size[1], size[2]);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl.TexParameteri(kind.target, filter, kind.filter);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        gl.TexParameteri(kind.target, wrap, GL_CLAMP_TO_EDGE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl.TexSubImage3D(kind.target, 0, 0, 0, 0, size[0], size[1], size[2], kind.format, kind.type, texels);
    if (gl.firstError() != GL_NO_ERROR)
        fail(ErrorCode::Memory, "no GPU memory is left for index volumes of " + std::to_string(size[0]) + " x " +
                                    std::to_string(size[1]) + " x " + std::to_string(size[2]) + " texels");
}

}  // namespace

void GpuIndexVolumes::Impl::destroy() {
    for (GLuint* texture : {&spline, &gradients, &attenuation, &glow, &faces, &block_reach}) {
        if (*texture) context.gl().DeleteTextures(1, texture);
        *texture = 0;
    }
}

void GpuIndexVolumes::Impl::make(const std::vector<IndexVolume>& volumes) {
    const GlFunctions& gl = context.gl();
    GLint layers = 0;
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    const IndexAtlas atlas(volumes, std::min(gl.largest_texture_3d, std::max(layers, 256)));
    const Int3 spline_size{atlas.texels[0], atlas.texels[1], atlas.spline_layers}, one{1, 1, 1};
    makeTexture(gl, kSpline, spline_size, atlas.spline(volumes).data(), spline);
    makeTexture(gl, kFourHalves, atlas.texels, atlas.gradients(volumes).data(), gradients);
    const Half4 none{};
    const std::uint8_t no_face = 0;
    if (atlas.attenuates)
        makeTexture(gl, kFourHalves, atlas.texels, atlas.attenuation(volumes).data(), attenuation);
    else
        makeTexture(gl, kFourHalves, one, &none, attenuation);
    if (atlas.glows)
        makeTexture(gl, kFourHalves, atlas.texels, atlas.glow(volumes).data(), glow);
    else
        makeTexture(gl, kFourHalves, one, &none, glow);
    if (atlas.has_coat)
        makeTexture(gl, kFourBytes, atlas.texels, atlas.coat(volumes).data(), faces);
    else if (atlas.has_faces)
        makeTexture(gl, kBytes, atlas.texels, atlas.faces(volumes).data(), faces);
    else
        makeTexture(gl, kBytes, one, &no_face, faces);
    makeTexture(gl, kNumbers, atlas.blocks, atlas.reach.data(), block_reach);

    const auto texels = [](const Int3& size) {
        return static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1]) *
               static_cast<std::uint64_t>(size[2]);
    };
    info.objects = static_cast<int>(volumes.size());
    info.texels = atlas.texels;
    info.even = atlas.even;
    info.bytes = texels(spline_size) * 4 + texels(atlas.blocks) +
                 texels(atlas.texels) * (8 + (atlas.attenuates ? 8 : 0) + (atlas.glows ? 8 : 0) +
                                         (atlas.has_coat    ? 4
                                          : atlas.has_faces ? 1
                                                            : 0));
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        const IndexVolumeData& data = volumes[i].data();
        const auto &s = data.scattering, &albedo = data.albedo;
        const bool matte = !data.coat.empty() || albedo[0] > 0 || albedo[1] > 0 || albedo[2] > 0;
        objects.push_back({data.transform, data.box_low, data.box_high, data.count, atlas.places[i], s, data.anisotropy,
                           albedo, data.roughness, volumes[i].reflects(), matte, data.sharp_sides,
                           s[0] > 0 || s[1] > 0 || s[2] > 0, volumes[i].disperses()});
    }
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
}

GpuIndexVolumes::GpuIndexVolumes(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpuIndexVolumes::GpuIndexVolumes(GpuIndexVolumes&&) noexcept = default;
GpuIndexVolumes& GpuIndexVolumes::operator=(GpuIndexVolumes&&) noexcept = default;
GpuIndexVolumes::~GpuIndexVolumes() = default;

const GpuIndexVolumes::Info& GpuIndexVolumes::info() const { return impl_->info; }
void GpuIndexVolumes::abandon() {
    impl_->spline = impl_->gradients = impl_->attenuation = impl_->glow = impl_->faces = impl_->block_reach = 0;
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
