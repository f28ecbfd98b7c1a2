// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/affine.h"
#include "runtime/src/bent_parameters.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_index_volumes.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"
#include "runtime/src/pass.h"

namespace photic::runtime {

struct BentRayPass::Impl {
    explicit Impl(const GpuContext& context) : pass(context, "bent_rays.frag.glsl") {}
    ~Impl() {
        if (buffer) pass.gl().DeleteBuffers(1, &buffer);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    /// The parameters, to uniform buffer 1.
    template <class Block>
    void upload(const Block& block) {
        const GlFunctions& gl = pass.gl();
        if (!buffer) gl.GenBuffers(1, &buffer);
        gl.BindBuffer(GL_UNIFORM_BUFFER, buffer);
        fillBuffer(gl, GL_UNIFORM_BUFFER, &block, sizeof(block), GL_STREAM_DRAW, "the objects' parameters");
        gl.BindBufferBase(GL_UNIFORM_BUFFER, 1, buffer);
    }
    FullScreenPass pass;
    GLuint buffer = 0;
};

namespace {

/// What the passes of one draw have in common.
struct BentDraw {
    const GBuffer& surfaces;
    const Surroundings& surroundings;
    ClipMatrices clip;
    bool disperses;
    bool lit;  ///< there is light that scatters
};

std::vector<Define> definesOf(const BentRayOptions& options, bool lit, bool shapes) {
    std::vector<Define> defines;
    if (shapes) defines.push_back({"PHOTIC_BENT_SHAPES", "1"});
    if (options.lookup == IndexLookup::Gradients) defines.push_back({"PHOTIC_BENT_GRADIENTS", "1"});
    if (options.integrator == BentIntegrator::Euler) defines.push_back({"PHOTIC_EULER", "1"});
    if (lit) defines.push_back({"PHOTIC_LIT", "1"});
    return defines;
}

/// Binds what one pass reads, and sets its uniforms. All but the first add only what is scattered.
void bindPass(const BentDraw& draw, bool first, GLuint program, FullScreenPass& pass) {
    const GlFunctions& gl = pass.gl();
    const GBuffer& surfaces = draw.surfaces;
    const Surroundings& surroundings = draw.surroundings;
    gl.ActiveTexture(GL_TEXTURE0 + 3);
    gl.BindSampler(3, 0);
    gl.BindTexture(GL_TEXTURE_2D, surroundings.environment);
    pass.bindNearest(4, surfaces.depth);
    pass.bindNearest(11, surroundings.radiance);
    const Uniforms uniforms(gl, program);
    uniforms.setMatrix("photic_place_from_clip", draw.clip.place_from_clip.data());
    uniforms.setMatrix("photic_clip_from_place", draw.clip.clip_from_place.data());
    const float factor = first ? 1.0F : 0.0F;
    uniforms.set("photic_bent_surroundings", factor * surroundings.colour[0], factor * surroundings.colour[1],
                 factor * surroundings.colour[2], surroundings.turn);
    uniforms.set("photic_bent_has", surroundings.environment != 0 && first ? 1 : 0, surfaces.depth != 0 ? 1 : 0,
                 surroundings.radiance != 0 ? (first ? 1 : 2) : 0, surfaces.clip_depth == ClipDepth::ZeroToOne ? 1 : 0);
    uniforms.set("photic_empty_depth", surfaces.empty_depth);
    uniforms.set("photic_bent_disperses", draw.disperses ? 1 : 0);
}

}  // namespace

BentRayPass::BentRayPass(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BentRayPass::BentRayPass(BentRayPass&&) noexcept = default;
BentRayPass& BentRayPass::operator=(BentRayPass&&) noexcept = default;
BentRayPass::~BentRayPass() = default;
void BentRayPass::abandon() {
    impl_->pass.abandon();
    impl_->buffer = 0;
}

Result<BentRayPass> BentRayPass::create(const GpuContext& context) {
    return guarded([&]() -> Result<BentRayPass> {
        auto impl = std::make_unique<Impl>(context);
        impl->pass.program();
        return BentRayPass(std::move(impl));
    });
}

Status BentRayPass::draw(const GBuffer& surfaces, const Target& target, const GpuIndexVolumes& objects,
                         const std::vector<PlacedObject>& placed, const Surroundings& surroundings,
                         const std::vector<LitVolume>& light, const BentRayOptions& options) {
    return guarded([&]() -> Status {
        const std::vector<LitVolume> lobes = allLobes(light);
        FullScreenPass& pass = impl_->pass;
        const GlFunctions& gl = pass.gl();
        const GpuIndexVolumes::Impl& volumes = objects.impl();
        const Double3 origin{double(surfaces.camera[0]), double(surfaces.camera[1]), double(surfaces.camera[2])};
        BentBlock block = bentBlock(volumes.placed, placed, origin, options, surroundings);
        bool scatters = false, disperses = false;
        for (const PlacedObject& p : placed) {
            const IndexObjects::Object& object = volumes.placed.objects[p.object];
            scatters = scatters || object.scatters || object.reflects;
            if (object.matte && surroundings.environment != 0 && !surroundings.harmonics)
                fail(ErrorCode::Usage,
                     "a face of a placed object reflects the surroundings evenly, which needs "
                     "Surroundings::harmonics: environmentHarmonics() makes them of the environment's texels");
            disperses = disperses || object.disperses;
        }
        const std::optional<ClipMatrices> clip = clipMatrices(surfaces.world_from_clip, origin);
        if (!clip) fail(ErrorCode::Usage, "the G-buffer's world_from_clip has no inverse");

        const GlStateGuard guard(gl);
        bindTarget(gl, target);
        gl.Disable(GL_BLEND);
        std::vector<LitVolume> shown;
        for (const LitVolume& l : lobes)
            if (scatters && l.weight != 0) shown.push_back(l);
        const BentDraw shared{surfaces, surroundings, *clip, disperses && options.disperses, !shown.empty()};
        for (std::size_t i = 0; i == 0 || i < shown.size(); ++i) {
            std::vector<Define> defines = definesOf(options, shared.lit, volumes.placed.haveShapes(placed));
            const GLuint program =
                shared.lit ? pass.programFor(*shown[i].volume, std::move(defines)) : pass.program(defines);
            block.origin[3] = i == 0 ? 0.0F : 1.0F;
            Surroundings around = surroundings;
            for (float& c : around.colour) c = i == 0 ? c : 0;
            layAmbient(around, block);
            impl_->upload(block);
            volumes.bind();
            bindPass(shared, i == 0, program, pass);
            if (shared.lit) shown[i].volume->impl().bind(0, 0, shown[i].weight);
            pass.drawTriangle();
            gl.Enable(GL_BLEND);
            gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ZERO, GL_ONE);
        }
        return Done{};
    });
}

Status BentRayPass::bind(const float* origin, const GpuIndexVolumes& objects, const std::vector<PlacedObject>& placed,
                         const BentRayOptions& options, const Surroundings& surroundings) {
    return guarded([&]() -> Status {
        const Double3 place{double(origin[0]), double(origin[1]), double(origin[2])};
        impl_->upload(bentBlock(objects.impl().placed, placed, place, options, surroundings));
        objects.impl().bind();
        return Done{};
    });
}

std::string bentGlsl(const BentGlslOptions& options) {
    const BentBindings& at = options.bindings;
    std::string out;
    const auto define = [&](const char* name, unsigned value) {
        out += std::string("#define ") + name + " " + std::to_string(value) + "\n";
    };
    define("PHOTIC_BENT_BUFFER", at.parameters);
    define("PHOTIC_BENT_FACES", at.faces);
    define("PHOTIC_BENT_GRADIENTS_AT", at.gradients);
    define("PHOTIC_BENT_SPLINE", at.spline);
    define("PHOTIC_BENT_ATTENUATION", at.attenuation);
    define("PHOTIC_BENT_GLOW", at.glow);
    define("PHOTIC_BENT_BLOCKS", at.blocks);
    if (options.vulkan_set) define("PHOTIC_BENT_SET", *options.vulkan_set);
    if (options.lookup == IndexLookup::Gradients) define("PHOTIC_BENT_GRADIENTS", 1);
    if (options.scatters) define("PHOTIC_LIT", 1);
    define("PHOTIC_BENT_SHAPES_AT", at.shapes);
    if (options.shapes) define("PHOTIC_BENT_SHAPES", 1);
    out +=
        "vec3 photicEnvironment(vec3 direction);\n"
        "bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance);\n";
    for (const char* file : {"photic_bent.glsl", "photic_bent_trace.glsl"}) {
        const Result<std::string> text = resolveIncludes(file);
        if (text) out += *text;  // both are built in
    }
    return out;
}

}  // namespace photic::runtime
