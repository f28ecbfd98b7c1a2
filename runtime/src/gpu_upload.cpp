// SPDX-License-Identifier: Apache-2.0
#include "photic/gpu_upload.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

/// Bytes on their way: layers of a 3D texture, or of a buffer, whose layer is one byte.
struct Part {
    const unsigned char* bytes = nullptr;
    std::uint64_t layers = 0, layer_bytes = 1, sent = 0;  ///< [layers] but the second
    GLenum internal = 0, format = 0, type = 0;            ///< 0: the storage buffer; without a format: blocks
    Int3 size{0, 0, 0};                                   ///< [texels]
    GLuint* name = nullptr;
};

Part partOf(const TextureBytes& texture, GLenum internal, GLenum format, GLenum type, GLuint& name) {
    Part part;
    part.bytes = texture.texels.data(), part.layers = texture.size[2];
    part.layer_bytes = texture.size[2] == 0 ? 1 : texture.texels.size() / texture.size[2];
    part.internal = internal, part.format = format, part.type = type, part.name = &name;
    for (std::size_t a = 0; a < 3; ++a) part.size[a] = static_cast<int>(texture.size[a]);
    return part;
}

/// One lobe: its bytes, and the names that they go to.
struct Lobe {
    VolumeBytes bytes;
    std::unique_ptr<GpuVolume::Impl> impl;
    std::vector<Part> parts;
};

}  // namespace

struct GpuUpload::Impl {
    Impl(const GpuContext& c, Volume v, const UploadOptions& o) : context(c), volume(std::move(v)), options(o) {}
    ~Impl() {
        if (thread.joinable()) thread.join();
    }
    void lay();
    void begin(Lobe& lobe) const;
    std::uint64_t send(Part& part, std::uint64_t most) const;
    void step(std::uint64_t bytes);
    bool finished() const { return outcome.has_value(); }

    GpuContext context;
    Volume volume;
    UploadOptions options;
    std::vector<Lobe> lobes;     ///< the second before the first; the thread's until `laid`
    std::optional<Error> error;  ///< of the thread
    std::atomic<bool> laid{false};
    std::optional<Result<GpuVolume>> outcome;
    std::thread thread;  ///< last: it uses all of the above
};

/// As GpuVolume::upload() shares a budget.
void GpuUpload::Impl::lay() {
    const Status done = guarded([&]() -> Status {
        UploadOptions first = options;
        const auto pack = [&](const Volume& one, const UploadOptions& with) {
            Result<VolumeBytes> packed = packVolume(one, with);
            if (!packed) throw Failure{packed.error()};
            lobes.push_back({std::move(*packed), nullptr, {}});
        };
        if (volume.hasSecondLobe()) {
            const Volume second = volume.secondLobe();
            UploadOptions rest = options;
            rest.budget = secondLobeBudget(volume, second, options.budget);
            pack(second, rest);
            first.budget -= std::min(first.budget, lobes.back().bytes.info.bytes);
        }
        pack(volume, first);
        return Done{};
    });
    if (!done) error = done.error();
    laid.store(true, std::memory_order_release);
}

void GpuUpload::Impl::begin(Lobe& lobe) const {
    lobe.impl = std::make_unique<GpuVolume::Impl>(context);
    GpuVolume::Impl& to = *lobe.impl;
    const VolumeBytes& bytes = lobe.bytes;
    to.info = bytes.info, to.filter = options.filter;
    std::memcpy(&to.parameters, bytes.parameters.data(), sizeof(to.parameters));
    to.makeSmallParts(bytes.sampler_repeats);
    const auto light = [&](const TextureBytes& texture, GLuint& name) {
        if (texture.size[0] == 0) return;
        if (texture.format == TexelFormat::Rgba16Float) {
            lobe.parts.push_back(partOf(texture, GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, name));
        } else {
            const bool with_sign = texture.format == TexelFormat::Bc6hSigned;
            lobe.parts.push_back(
                partOf(texture, with_sign ? GL_COMPRESSED_RGB_BPTC_SIGNED_FLOAT : GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT,
                       0, 0, name));
        }
    };
    light(bytes.light, to.light);
    light(bytes.colour, to.rgb);
    if (!bytes.bricks.empty()) {
        Part part;
        part.bytes = bytes.bricks.data(), part.layers = bytes.bricks.size(), part.name = &to.bricks;
        lobe.parts.push_back(part);
    }
    lobe.parts.push_back(partOf(bytes.pages, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, to.pages));
}

/// @return how many bytes were sent
std::uint64_t GpuUpload::Impl::send(Part& part, std::uint64_t most) const {
    const GlFunctions& gl = context.gl();
    const std::uint64_t layers = std::min(part.layers - part.sent, std::max<std::uint64_t>(1, most / part.layer_bytes));
    const unsigned char* from = part.bytes + part.sent * part.layer_bytes;
    if (part.internal == 0) {
        if (*part.name == 0)
            uploadBuffer(gl, GL_SHADER_STORAGE_BUFFER, nullptr, part.layers, GL_STATIC_DRAW, *part.name);
        gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, *part.name);
        gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(part.sent), static_cast<GLsizeiptr>(layers),
                         from);
    } else {
        if (*part.name == 0) *part.name = makeTexture3d(gl, part.internal, part.size, "a volume");
        gl.BindTexture(GL_TEXTURE_3D, *part.name);
        const auto first = static_cast<GLint>(part.sent);
        const auto count = static_cast<GLsizei>(layers);
        if (part.format == 0) {
            gl.CompressedTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, first, part.size[0], part.size[1], count, part.internal,
                                       static_cast<GLsizei>(layers * part.layer_bytes), from);
        } else {
            gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, first, part.size[0], part.size[1], count, part.format, part.type,
                             from);
        }
    }
    requireMemory(gl, "a volume");
    part.sent += layers;
    return layers * part.layer_bytes;
}

/// @throws Failure where the bytes do not fit, in this layout
void GpuUpload::Impl::step(std::uint64_t bytes) {
    if (error) throw Failure{*error};
    for (Lobe& lobe : lobes) {
        if (!lobe.impl) begin(lobe);
        for (Part& part : lobe.parts) {
            while (part.sent < part.layers) {
                if (bytes == 0) return;
                bytes -= std::min(bytes, send(part, bytes));
            }
        }
    }
    if (lobes.size() == 2) lobes[1].impl->second.reset(new GpuVolume(std::move(lobes[0].impl)));
    outcome.emplace(GpuVolume(std::move(lobes.back().impl)));
}

GpuUpload::GpuUpload(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpuUpload::GpuUpload(GpuUpload&&) noexcept = default;
GpuUpload& GpuUpload::operator=(GpuUpload&&) noexcept = default;
GpuUpload::~GpuUpload() = default;

Result<GpuUpload> GpuUpload::start(const GpuContext& context, Volume volume, const UploadOptions& options) {
    return guarded([&]() -> Result<GpuUpload> {
        UploadOptions with = options;
        const GpuLimits limits = limitsOf(context.gl(), options);
        if (!limits.bc6h) with.texels = Texels::Halves;
        with.largest_texture_3d = limits.texture_3d, with.largest_storage_block = limits.storage_block;
        auto impl = std::make_unique<Impl>(context, std::move(volume), with);
        try {
            impl->thread = std::thread([p = impl.get()] { p->lay(); });
        } catch (const std::system_error&) {
            return Error{ErrorCode::Memory, "the system has no thread left to lay a volume out with"};
        }
        return GpuUpload(std::move(impl));
    });
}

bool GpuUpload::step(std::uint64_t bytes) {
    Impl& impl = *impl_;
    if (impl.finished()) return true;
    if (!impl.laid.load(std::memory_order_acquire)) return false;
    const Status done = guarded([&]() -> Status {
        impl.context.gl().clearErrors();
        const GlStateGuard guard(impl.context.gl());
        impl.context.gl().ActiveTexture(GL_TEXTURE0);
        impl.step(std::max<std::uint64_t>(1, bytes));
        return Done{};
    });
    if (!done) {
        // GL had no room for this layout after all: all layouts are tried, as they would have been at once.
        impl.lobes.clear();
        impl.outcome.emplace(GpuVolume::upload(impl.context, impl.volume, impl.options));
    }
    return impl.finished();
}

Result<GpuVolume> GpuUpload::take() {
    if (impl_->thread.joinable()) impl_->thread.join();
    while (!step(~std::uint64_t{0})) {
    }
    return std::move(*impl_->outcome);
}

void GpuUpload::abandon() {
    if (impl_->thread.joinable()) impl_->thread.join();
    for (Lobe& lobe : impl_->lobes) {
        if (lobe.impl) GpuVolume(std::move(lobe.impl)).abandon();
    }
    impl_->lobes.clear();
    if (impl_->outcome && *impl_->outcome) (*impl_->outcome)->abandon();
    impl_->outcome.emplace(Error{ErrorCode::Usage, "the context was lost while a volume went to the GPU"});
}

}  // namespace photic::runtime
