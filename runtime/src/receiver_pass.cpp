// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"
#include "runtime/src/live_water_impl.h"
#include "runtime/src/pass.h"

namespace photic::runtime {

namespace {

void setOptions(const Uniforms& uniforms, const GBuffer& surfaces, const ReceiverOptions& options) {
    uniforms.set("photic_scale", options.scale);
    uniforms.set("photic_has_albedo", surfaces.albedo ? 1 : 0);
    uniforms.set("photic_as_irradiance", options.output == ReceiverOutput::Irradiance ? 1 : 0);
}

void requireGBuffer(const GBuffer& surfaces) {
    if (!surfaces.depth || !surfaces.normals) fail(ErrorCode::Usage, "the G-buffer lacks depth or normals");
}

/// What is drawn next is added to the target.
void beginAdding(const GlFunctions& gl, const Target& target) {
    bindTarget(gl, target);
    gl.Enable(GL_BLEND);
    gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
}

}  // namespace

struct ReceiverPass::Impl {
    explicit Impl(const GpuContext& context) : pass(context, "receiver.frag.glsl") {}
    FullScreenPass pass;
};

ReceiverPass::ReceiverPass(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ReceiverPass::ReceiverPass(ReceiverPass&&) noexcept = default;
ReceiverPass& ReceiverPass::operator=(ReceiverPass&&) noexcept = default;
ReceiverPass::~ReceiverPass() = default;
void ReceiverPass::abandon() { impl_->pass.abandon(); }

Result<ReceiverPass> ReceiverPass::create(const GpuContext& context) {
    return guarded([&]() -> Result<ReceiverPass> {
        auto impl = std::make_unique<Impl>(context);
        impl->pass.program({{"PHOTIC_LAYOUT", "1"},
                            {"PHOTIC_COLOURED", "0"},
                            {"PHOTIC_REPEATS", "0"}});  // the usual one now, so that a driver's refusal shows here
        return ReceiverPass(std::move(impl));
    });
}

Status ReceiverPass::draw(const GBuffer& surfaces, const Target& target, const std::vector<LitVolume>& volumes,
                          const ReceiverOptions& options) {
    return guarded([&]() -> Status {
        requireGBuffer(surfaces);
        const std::vector<LitVolume> lobes = allLobes(volumes);
        FullScreenPass& pass = impl_->pass;
        const GlFunctions& gl = pass.gl();
        const GlStateGuard guard(gl);
        beginAdding(gl, target);
        for (const LitVolume& lit : lobes) {
            if (lit.weight == 0) continue;
            const Uniforms uniforms(gl, pass.programFor(*lit.volume, options.shadows));
            pass.bindGBuffer(uniforms, surfaces);
            setOptions(uniforms, surfaces, options);
            lit.volume->impl().bind(0, 0, lit.weight);
            pass.drawTriangle();
        }
        return Done{};
    });
}

Status ReceiverPass::drawLit(const GBuffer& surfaces, const Target& target, const Lighting& lighting,
                             const ReceiverOptions& options) {
    LightSource source = lighting.source;
    const LiveWater* water = lighting.water;
    const bool has_map = water && water->hasCausticMap();
    if (source == LightSource::Best) {
        source = !lighting.volumes.empty() ? LightSource::Baked
                 : has_map                 ? LightSource::CausticMap
                                           : LightSource::Lookup;
    }
    if (source == LightSource::Baked) return draw(surfaces, target, lighting.volumes, options);
    if (!water || !water->impl().map)
        return Error{ErrorCode::Usage, "there is no water with heights to light receivers"};
    if (source == LightSource::CausticMap && !has_map) {
        return Error{ErrorCode::Usage, "the water has no caustic map; call updateCausticMap() first"};
    }
    return guarded([&]() -> Status {
        requireGBuffer(surfaces);
        FullScreenPass& pass = impl_->pass;
        const GlFunctions& gl = pass.gl();
        const GlStateGuard guard(gl);
        beginAdding(gl, target);
        const bool mapped = source == LightSource::CausticMap;
        std::vector<Define> defines{{"PHOTIC_LIGHT_SOURCE", mapped ? "1" : "2"}};
        if (options.shadows.movers) defines.push_back({"PHOTIC_MOVERS", "1"});
        const Uniforms uniforms(gl, pass.program(defines));
        if (options.shadows.movers) pass.bindMovers(options.shadows);
        pass.bindGBuffer(uniforms, surfaces);
        setOptions(uniforms, surfaces, options);
        mapped ? water->impl().setCausticMap(uniforms, 0) : water->impl().setLookup(uniforms, 0);
        pass.drawTriangle();
        return Done{};
    });
}

}  // namespace photic::runtime
