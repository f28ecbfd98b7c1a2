// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <vector>

#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

/// How GL is told of texels.
struct GlFormat {
    GLenum internal, format, type;
};
constexpr GlFormat kFourHalves{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT};
constexpr GLenum kUnsignedBlocks = GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT;

/// A texture of bricks, or a dense one, of any texels: made, and filled slab by slab from a source (brick_layout.h).
/// @param texture  set at once, so that its owner deletes it when something is thrown. @throws Failure{Memory}
template <class Texel, class Source>
void uploadTexture(const GlFunctions& gl, const BrickLayout& bricks, const GlFormat& format, const Source& source,
                   GLuint& texture) {
    const Int3& size = bricks.textureSize();
    texture = makeTexture3d(gl, format.internal, size, "a volume");
    std::vector<Texel> slab(bricks.slabTexels());
    for (int z = 0; z < size[2]; z += bricks.slabDepth()) {
        const int count = std::min(bricks.slabDepth(), size[2] - z);
        bricks.fillSlab(z, count, source, slab.data());
        gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, size[0], size[1], count, format.format, format.type, slab.data());
    }
    requireMemory(gl, "a volume");
}

/// The same of BC6H blocks.
/// @param of  the file's: flux or colour
void uploadBlocks(const GlFunctions& gl, const BrickLayout& bricks, GLenum internal,
                  const std::vector<unsigned char>& of, GLuint& texture) {
    const Int3& size = bricks.textureSize();
    texture = makeTexture3d(gl, internal, size, "a volume");
    std::vector<unsigned char> slab(bricks.blockLayerBytes() * static_cast<std::size_t>(bricks.slabDepth()));
    for (int z = 0; z < size[2]; z += bricks.slabDepth()) {
        const int count = std::min(bricks.slabDepth(), size[2] - z);
        bricks.fillBlocks(z, count, of, slab.data());
        gl.CompressedTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, size[0], size[1], count, internal,
                                   static_cast<GLsizei>(bricks.blockLayerBytes() * static_cast<std::size_t>(count)),
                                   slab.data());
    }
    requireMemory(gl, "a volume");
}

void uploadPages(const GlFunctions& gl, const VolumeLayout& layout, GLuint& texture) {
    const Int3& size = layout.pageCount();
    const std::vector<std::uint32_t> entries = layout.bricks().pageEntries();
    texture = makeTexture3d(gl, GL_R32UI, size, "the page table");
    gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, size[0], size[1], size[2], GL_RED_INTEGER, GL_UNSIGNED_INT,
                     entries.data());
    requireMemory(gl, "the page table");
}

/// @throws Failure{Memory} when GL has none left
std::unique_ptr<GpuVolume::Impl> uploadLayout(const GpuContext& context, const VolumeLayout& layout,
                                              const UploadInfo& info, Filter filter) {
    const GlFunctions& gl = context.gl();
    auto impl = std::make_unique<GpuVolume::Impl>(context);
    impl->info = info;
    impl->filter = filter;
    impl->parameters = layout.parameters();
    const BrickLayout& bricks = layout.bricks();
    if (bricks.layout() == Layout::Buffer) {
        const std::vector<Half4> texels = layout.bufferTexels();
        uploadBuffer(gl, GL_SHADER_STORAGE_BUFFER, texels.data(), texels.size() * sizeof(Half4), GL_STATIC_DRAW,
                     impl->bricks);
    } else if (const BlockTexels* blocks = layout.blocks()) {
        const GLenum flux = blocks->signed_flux ? GL_COMPRESSED_RGB_BPTC_SIGNED_FLOAT : kUnsignedBlocks;
        uploadBlocks(gl, bricks, flux, blocks->flux, impl->light);
        uploadBlocks(gl, bricks, kUnsignedBlocks, blocks->colour, impl->rgb);
    } else {
        uploadTexture<Half4>(gl, bricks, kFourHalves, layout.lightSource(), impl->light);
        if (layout.coloured()) uploadTexture<Half4>(gl, bricks, kFourHalves, layout.colourSource(), impl->rgb);
    }
    uploadPages(gl, layout, impl->pages);
    impl->makeSmallParts({layout.repeats(0), layout.repeats(1), layout.repeats(2)});
    return impl;
}

}  // namespace

GpuLimits limitsOf(const GlFunctions& gl, const UploadOptions& options) {
    GpuLimits limits{gl.largest_texture_3d, gl.bc6h,
                     static_cast<std::uint64_t>(std::max<GLint64>(0, gl.largest_storage_block))};
    if (options.largest_texture_3d > 0) limits.texture_3d = std::min(limits.texture_3d, options.largest_texture_3d);
    if (options.largest_storage_block > 0)
        limits.storage_block = std::min(limits.storage_block, options.largest_storage_block);
    return limits;
}

std::uint64_t secondLobeBudget(const Volume& volume, const Volume& lobe, std::uint64_t budget) {
    return static_cast<std::uint64_t>(static_cast<double>(budget) * static_cast<double>(lobe.bytes()) /
                                      static_cast<double>(volume.bytes()));
}

void requireMemory(const GlFunctions& gl, const char* of) {
    const GLenum error = gl.firstError();
    if (error == GL_NO_ERROR) return;
    char code[16];
    std::snprintf(code, sizeof(code), "0x%04x", static_cast<unsigned>(error));
    if (error == GL_OUT_OF_MEMORY) fail(ErrorCode::Memory, std::string("the GPU has no memory left for ") + of);
    fail(ErrorCode::Memory, std::string("GL refuses ") + of + " with error " + code);
}

void fillBuffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t size, GLenum use, const char* of) {
    gl.clearErrors();
    gl.BufferData(target, static_cast<GLsizeiptr>(size), data, use);
    requireMemory(gl, of);
}

void uploadBuffer(const GlFunctions& gl, GLenum target, const void* data, std::size_t size, GLenum use,
                  GLuint& buffer) {
    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(target, buffer);
    fillBuffer(gl, target, data, size, use, "a buffer");
}

void GpuVolume::Impl::makeSmallParts(const std::array<bool, 3>& repeats) {
    const GlFunctions& gl = context.gl();
    gl.GenSamplers(1, &sampler);
    gl.GenSamplers(1, &page_sampler);
    constexpr GLenum kWraps[3] = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R};
    for (std::size_t a = 0; a < 3; ++a) {
        gl.SamplerParameteri(sampler, kWraps[a], repeats[a] ? GL_REPEAT : GL_CLAMP_TO_EDGE);
        gl.SamplerParameteri(page_sampler, kWraps[a], GL_CLAMP_TO_EDGE);
    }
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
        gl.SamplerParameteri(sampler, name, GL_LINEAR);
        gl.SamplerParameteri(page_sampler, name, GL_NEAREST);
    }
    reference_irradiance = parameters.scale;
    uploadBuffer(gl, GL_UNIFORM_BUFFER, &parameters, sizeof(parameters), GL_DYNAMIC_DRAW, parameter_buffer);
}

GLuint makeTexture3d(const GlFunctions& gl, GLenum format, const Int3& size, const char* of) {
    GLuint texture = 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_3D, texture);
    gl.TexStorage3D(GL_TEXTURE_3D, 1, format, size[0], size[1], size[2]);
    if (gl.firstError() != GL_NO_ERROR) {
        gl.DeleteTextures(1, &texture);
        fail(ErrorCode::Memory, std::string("the GPU has no memory left for ") + of + " of " + std::to_string(size[0]) +
                                    " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]) + " texels");
    }
    return texture;
}

void GpuVolume::Impl::destroy() {
    const GlFunctions& gl = context.gl();
    for (GLuint* texture : {&light, &rgb, &pages}) {
        if (*texture) gl.DeleteTextures(1, texture);
        *texture = 0;
    }
    for (GLuint* buffer : {&bricks, &parameter_buffer}) {
        if (*buffer) gl.DeleteBuffers(1, buffer);
        *buffer = 0;
    }
    for (GLuint* name : {&sampler, &page_sampler}) {
        if (*name) gl.DeleteSamplers(1, name);
        *name = 0;
    }
}

void GpuVolume::Impl::bind(unsigned first_texture, unsigned first_buffer, float weight) {
    const GlFunctions& gl = context.gl();
    const auto texture = [&](unsigned unit, GLuint name, GLuint with) {
        gl.ActiveTexture(GL_TEXTURE0 + unit);
        gl.BindTexture(GL_TEXTURE_3D, name);
        gl.BindSampler(unit, with);
    };
    texture(first_texture, light, sampler);
    texture(first_texture + 1, rgb ? rgb : light, sampler);  // never read when white, but must be complete
    texture(first_texture + 2, pages, page_sampler);
    const float scale = reference_irradiance * weight;
    if (parameters.scale != scale) {
        parameters.scale = scale;
        gl.BindBuffer(GL_UNIFORM_BUFFER, parameter_buffer);
        gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof(parameters), &parameters);  // takes no memory that may be gone
    }
    gl.BindBufferBase(GL_UNIFORM_BUFFER, first_buffer, parameter_buffer);
    if (bricks) gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, first_buffer, bricks);
}

GpuVolume::GpuVolume(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpuVolume::GpuVolume(GpuVolume&&) noexcept = default;
GpuVolume& GpuVolume::operator=(GpuVolume&&) noexcept = default;
GpuVolume::~GpuVolume() = default;

const UploadInfo& GpuVolume::info() const { return impl_->info; }
void GpuVolume::bind(unsigned first_texture, unsigned first_buffer, float weight) {
    impl_->bind(first_texture, first_buffer, weight);
}
GpuVolume* GpuVolume::secondLobe() { return impl_->second.get(); }
void GpuVolume::abandon() {
    if (impl_->second) impl_->second->abandon();
    impl_->light = impl_->rgb = impl_->pages = 0;
    impl_->bricks = impl_->parameter_buffer = 0;
    impl_->sampler = impl_->page_sampler = 0;
}

Result<GpuVolume> GpuVolume::upload(const GpuContext& context, const Volume& volume, const UploadOptions& options) {
    return guarded([&]() -> Result<GpuVolume> {
        const GlFunctions& gl = context.gl();
        gl.clearErrors();
        const GlStateGuard guard(gl);
        gl.ActiveTexture(GL_TEXTURE0);
        UploadOptions first = options;
        std::unique_ptr<GpuVolume> second;
        if (volume.hasSecondLobe()) {
            const Volume lobe = volume.secondLobe();
            UploadOptions rest = options;
            rest.budget = secondLobeBudget(volume, lobe, options.budget);
            Result<GpuVolume> uploaded = upload(context, lobe, rest);
            if (!uploaded) return uploaded.error();
            first.budget = options.budget - std::min(options.budget, uploaded->info().bytes);
            second = std::make_unique<GpuVolume>(std::move(*uploaded));
        }
        gl.ActiveTexture(GL_TEXTURE0);
        auto impl =
            fitLayout(volume, first, limitsOf(gl, options), [&](const VolumeLayout& layout, const UploadInfo& info) {
                return uploadLayout(context, layout, info, options.filter);
            });
        if (!impl) return impl.error();
        (*impl)->second = std::move(second);
        return GpuVolume(std::move(*impl));
    });
}

}  // namespace photic::runtime
