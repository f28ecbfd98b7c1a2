// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"
#include "runtime/src/pass.h"

namespace photic::runtime {

struct MediumPass::Impl {
    explicit Impl(const GpuContext& context)
        : scatter(context, "medium.frag.glsl"),
          transmit(context, "medium_transmittance.frag.glsl"),
          upsample(context, "medium_upsample.frag.glsl") {}
    ~Impl() { deleteHalf(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    const GlFunctions& gl() const { return scatter.gl(); }
    void deleteHalf();
    /// A framebuffer of half the G-buffer's size, made anew when that changes; returns it as a target, cleared.
    Target halfTarget(const GBuffer& surfaces);
    void scatterInto(const Target& target, const GBuffer& surfaces, const std::vector<LitVolume>& volumes,
                     const MediumOptions& options, int stride);

    FullScreenPass scatter, transmit, upsample;
    GLuint half_texture = 0, half_framebuffer = 0;
    int half_width = 0, half_height = 0;
};

namespace {

void require(const MediumOptions& options) {
    for (int c = 0; c < 3; ++c) {
        const float s = options.scattering[c], a = options.absorption[c];
        if (!(s >= 0 && a >= 0 && std::isfinite(s + a))) {
            fail(ErrorCode::Usage, "scattering " + std::to_string(s) + " and absorption " + std::to_string(a) +
                                       " 1/m: both must be 0 or more, and finite");
        }
    }
    if (!(std::fabs(options.anisotropy) < 1)) {
        fail(ErrorCode::Usage, "anisotropy " + std::to_string(options.anisotropy) + " is not between -1 and 1");
    }
    constexpr int kMostSteps = 65536;
    if (options.steps < 1 || options.steps > kMostSteps) {
        fail(ErrorCode::Usage,
             std::to_string(options.steps) + " steps are not between 1 and " + std::to_string(kMostSteps));
    }
}

/// Whether dark pages are looked for. Above the fill that dense textures are chosen at, a step seldom finds one.
bool skips(Skipping skipping, const UploadInfo& volume) {
    constexpr double kWorthwhile = 0.7;
    return skipping == Skipping::DarkPages || (skipping == Skipping::Automatic && volume.fill < kWorthwhile);
}

}  // namespace

void MediumPass::Impl::deleteHalf() {
    if (half_texture) gl().DeleteTextures(1, &half_texture);
    if (half_framebuffer) gl().DeleteFramebuffers(1, &half_framebuffer);
    half_texture = half_framebuffer = 0;
    half_width = half_height = 0;
}

Target MediumPass::Impl::halfTarget(const GBuffer& surfaces) {
    GLint width = 0, height = 0;
    gl().ActiveTexture(GL_TEXTURE4);
    gl().BindTexture(GL_TEXTURE_2D, surfaces.depth);
    gl().GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
    gl().GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
    width = (width + 1) / 2, height = (height + 1) / 2;
    if (width != half_width || height != half_height) {
        deleteHalf();
        gl().clearErrors();
        gl().GenTextures(1, &half_texture);
        gl().ActiveTexture(GL_TEXTURE3);
        gl().BindTexture(GL_TEXTURE_2D, half_texture);
        gl().TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA16F, width, height);
        gl().TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl().TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl().GenFramebuffers(1, &half_framebuffer);
        gl().BindFramebuffer(GL_DRAW_FRAMEBUFFER, half_framebuffer);
        gl().FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, half_texture, 0);
        if (gl().CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE ||
            gl().firstError() != GL_NO_ERROR) {
            deleteHalf();
            fail(ErrorCode::Memory, "no half-float framebuffer of " + std::to_string(width) + " x " +
                                        std::to_string(height) + " is to be had; draw at full resolution");
        }
        half_width = width, half_height = height;
    }
    return {half_framebuffer, 0, 0, half_width, half_height};
}

void MediumPass::Impl::scatterInto(const Target& target, const GBuffer& surfaces, const std::vector<LitVolume>& volumes,
                                   const MediumOptions& options, int stride) {
    bindTarget(gl(), target);
    for (const LitVolume& lit : volumes) {
        if (lit.weight == 0) continue;
        const Uniforms uniforms(gl(), scatter.programFor(*lit.volume, options.shadows));
        scatter.bindGBuffer(uniforms, surfaces);
        uniforms.set3("photic_scattering", options.scattering);
        uniforms.set3("photic_absorption", options.absorption);
        uniforms.set4("photic_medium_surface", options.surface);
        uniforms.set("photic_anisotropy", options.anisotropy);
        uniforms.set("photic_scale", options.scale);
        uniforms.set("photic_march", options.steps, options.jitter == StepJitter::PerPixel ? 1 : 0, options.frame,
                     skips(options.skipping, lit.volume->info()) ? 1 : 0);
        uniforms.set("photic_stride", stride);
        lit.volume->impl().bind(0, 0, lit.weight);
        scatter.drawTriangle();
    }
}

MediumPass::MediumPass(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MediumPass::MediumPass(MediumPass&&) noexcept = default;
MediumPass& MediumPass::operator=(MediumPass&&) noexcept = default;
MediumPass::~MediumPass() = default;

void MediumPass::abandon() {
    impl_->scatter.abandon();
    impl_->transmit.abandon();
    impl_->upsample.abandon();
    impl_->half_texture = impl_->half_framebuffer = 0;
    impl_->half_width = impl_->half_height = 0;
}

Result<MediumPass> MediumPass::create(const GpuContext& context) {
    return guarded([&]() -> Result<MediumPass> {
        auto impl = std::make_unique<Impl>(context);
        impl->scatter.program({{"PHOTIC_LAYOUT", "1"}, {"PHOTIC_COLOURED", "0"}, {"PHOTIC_REPEATS", "0"}});
        impl->transmit.program();
        return MediumPass(std::move(impl));
    });
}

Status MediumPass::draw(const GBuffer& surfaces, const Target& target, const std::vector<LitVolume>& volumes,
                        const MediumOptions& options) {
    return guarded([&]() -> Status {
        if (!surfaces.depth) fail(ErrorCode::Usage, "the G-buffer lacks depth");
        const std::vector<LitVolume> lobes = allLobes(volumes);
        require(options);
        Impl& impl = *impl_;
        const GlFunctions& gl = impl.gl();
        const GlStateGuard guard(gl);

        if (options.extinction == Extinction::Applied) {
            bindTarget(gl, target);
            gl.Enable(GL_BLEND);
            gl.BlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
            const Uniforms uniforms(gl, impl.transmit.program());
            impl.transmit.bindGBuffer(uniforms, surfaces);
            float extinction[3];
            for (int c = 0; c < 3; ++c) extinction[c] = options.scattering[c] + options.absorption[c];
            uniforms.set3("photic_extinction", extinction);
            uniforms.set4("photic_medium_surface", options.surface);
            impl.transmit.drawTriangle();
        }

        if (options.resolution == MediumResolution::Full) {
            gl.Enable(GL_BLEND);
            gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ZERO, GL_ONE);  // alpha stays the game's
            impl.scatterInto(target, surfaces, lobes, options, 1);
            return Done{};
        }
        const Target half = impl.halfTarget(surfaces);
        bindTarget(gl, half);
        const float nothing[4] = {0, 0, 0, 0};
        gl.ClearBufferfv(GL_COLOR, 0, nothing);
        gl.Enable(GL_BLEND);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ZERO);  // alpha is the depth, the same for all volumes
        impl.scatterInto(half, surfaces, lobes, options, 2);

        bindTarget(gl, target);
        gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ZERO, GL_ONE);
        const Uniforms uniforms(gl, impl.upsample.program());
        impl.upsample.bindGBuffer(uniforms, surfaces);
        uniforms.set4("photic_medium_surface", options.surface);
        uniforms.texture("photic_half", 3, GL_TEXTURE_2D, impl.half_texture);
        impl.upsample.drawTriangle();
        return Done{};
    });
}

MediumOptions mediumOf(const Metadata& metadata) {
    MediumOptions options;
    const auto copy = [](float* to, const Vec3& from) {
        to[0] = static_cast<float>(from.x), to[1] = static_cast<float>(from.y), to[2] = static_cast<float>(from.z);
    };
    copy(options.scattering, metadata.scattering);
    copy(options.absorption, metadata.absorption);
    options.anisotropy = static_cast<float>(metadata.anisotropy);
    if (std::isfinite(metadata.surface[3])) {
        for (int i = 0; i < 4; ++i) options.surface[i] = static_cast<float>(metadata.surface[i]);
    }
    return options;
}

}  // namespace photic::runtime
