// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime/src/affine.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_index_volumes.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"
#include "runtime/src/harmonics.h"
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

/// As photic_bent.glsl has them, std140.
struct ObjectBlock {
    float rows[3][4], box_low[4], box_high[4], scattering[4], coat[4];
    std::int32_t count[4], corner[4], block[4];
};
struct BentBlock {
    float origin[4];
    std::int32_t counts[4];
    float march[4], texel[4], ambient[9][4];
    ObjectBlock objects[BentRayPass::kMostObjects];
};
static_assert(sizeof(ObjectBlock) == 160 && sizeof(BentBlock) == 208 + 16 * 160);

void require(const BentRayOptions& o, const Surroundings& s, std::size_t placed) {
    const auto wrong = [](const std::string& what) { fail(ErrorCode::Usage, what); };
    if (placed < 1 || placed > BentRayPass::kMostObjects)
        wrong(std::to_string(placed) + " objects are placed; 1 to 16 are drawn at a time");
    if (!(o.step > 0 && o.step <= 16)) wrong("a step of " + std::to_string(o.step) + " nodes; it must be up to 16");
    if (!(o.turn > 0 && o.turn <= 1)) wrong("a turn of " + std::to_string(o.turn) + "; it must be up to 1 radian");
    if (o.steps < 1 || o.steps > 65536) wrong(std::to_string(o.steps) + " steps are not between 1 and 65536");
    if (o.branches < 0 || o.branches > 4) wrong(std::to_string(o.branches) + " branches are not between 0 and 4");
    if (!(o.faintest >= 0 && o.faintest <= 1)) wrong("the faintest branch must be 0 to 1");
    for (const float c : s.colour)
        if (!(c >= 0 && std::isfinite(c))) wrong("the surroundings' colour must be 0 or more, and finite");
    if (!std::isfinite(s.turn)) wrong("the surroundings' turn is not finite");
    if (s.harmonics)
        for (const auto& harmonic : *s.harmonics)
            for (const float c : harmonic)
                if (!std::isfinite(c)) wrong("the surroundings' harmonics are not finite");
}

/// A box around an object in the world, for the question which of them overlap.
struct Bounds {
    Double3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    bool overlaps(const Bounds& other) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (low[a] > other.high[a] || other.low[a] > high[a]) return false;
        return true;
    }
};

/// One placed object's numbers; places in the shader are relative to `origin`.
Bounds layObject(const GpuIndexVolumes::Impl::Object& object, const PlacedObject& placed, const Double3& origin,
                 ObjectBlock& out) {
    const Affine world_from_node =
        Affine::of(placed.world_from_object) * Affine{object.transform.world_from_index, object.transform.origin_world};
    const std::optional<Affine> node_from_world = world_from_node.inverse();
    if (!node_from_world) fail(ErrorCode::Usage, "a PlacedObject's matrix has no inverse");
    const Double3 shift = node_from_world->apply(origin);
    double least = 1e300;
    for (std::size_t a = 0; a < 3; ++a) {
        double length = 0;
        for (std::size_t b = 0; b < 3; ++b) {
            out.rows[a][b] = static_cast<float>(node_from_world->matrix[3 * a + b]);
            length += world_from_node.matrix[3 * b + a] * world_from_node.matrix[3 * b + a];
        }
        out.rows[a][3] = static_cast<float>(shift[a]);
        least = std::min(least, std::sqrt(length));
        out.box_low[a] = static_cast<float>(object.box_low[a]),
        out.box_high[a] = static_cast<float>(object.box_high[a]);
        out.scattering[a] = object.scattering[a], out.coat[a] = object.albedo[a];
        out.count[a] = object.count[a], out.corner[a] = object.place.corner[a], out.block[a] = object.place.block[a];
    }
    out.box_low[3] = object.sharp ? 1.0F : 0.0F;
    out.box_high[3] = object.anisotropy;
    out.scattering[3] = static_cast<float>(least);
    // Narrower highlights than this would miss all pixels but some.
    out.coat[3] = object.roughness > 0 ? std::max(object.roughness * object.roughness, 1e-3F) : 0.0F;
    out.count[3] = object.place.flags, out.corner[3] = object.place.channel_layers;
    Bounds bounds;
    for (int corner = 0; corner < 8; ++corner) {
        Double3 node;
        for (std::size_t a = 0; a < 3; ++a) node[a] = (corner >> a & 1) != 0 ? object.box_high[a] : object.box_low[a];
        const Double3 p = world_from_node.apply(node);
        for (std::size_t a = 0; a < 3; ++a)
            bounds.low[a] = std::min(bounds.low[a], p[a]), bounds.high[a] = std::max(bounds.high[a], p[a]);
    }
    return bounds;
}

BentBlock blockOf(const GpuIndexVolumes::Impl& objects, const std::vector<PlacedObject>& placed, const Double3& origin,
                  const BentRayOptions& options) {
    BentBlock block{};
    std::vector<Bounds> bounds;
    for (std::size_t i = 0; i < placed.size(); ++i) {
        if (placed[i].object >= objects.objects.size())
            fail(ErrorCode::Usage, "there is no index volume " + std::to_string(placed[i].object) + "; " +
                                       std::to_string(objects.objects.size()) + " were uploaded");
        bounds.push_back(layObject(objects.objects[placed[i].object], placed[i], origin, block.objects[i]));
    }
    for (std::size_t i = 0; i < placed.size(); ++i)
        for (std::size_t k = 0; k < placed.size(); ++k)
            if (i != k && bounds[i].overlaps(bounds[k])) block.objects[i].block[3] |= 1 << k;
    for (std::size_t a = 0; a < 3; ++a) {
        block.origin[a] = static_cast<float>(origin[a]);
        block.texel[a] = 1.0F / static_cast<float>(objects.info.texels[a]);
    }
    block.counts[0] = static_cast<std::int32_t>(placed.size());
    block.counts[1] = options.steps, block.counts[2] = options.branches;
    block.counts[3] = options.skipping == BentSkipping::Even ? 1 : 0;
    block.march[0] = options.step, block.march[1] = options.turn, block.march[2] = options.faintest;
    block.march[3] = options.radiance == BentRadiance::Paper ? 1.0F : 0.0F;
    return block;
}

/// Irradiance over pi as a polynomial of the direction that a face looks in.
void layAmbient(const Surroundings& around, BentBlock& block) {
    const std::array<double, 9> factors = ambientFactors();
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const double even = i == 0 ? 1 : 0;  // the same from everywhere
            const double ambient = around.harmonics ? factors[i] * double((*around.harmonics)[i][c]) : even;
            block.ambient[i][c] = static_cast<float>(ambient * double(around.colour[c]));
        }
    block.ambient[0][3] = std::cos(around.turn), block.ambient[1][3] = std::sin(around.turn);
}

/// What the passes of one draw have in common.
struct BentDraw {
    const GBuffer& surfaces;
    const Surroundings& surroundings;
    ClipMatrices clip;
    bool disperses;
    bool lit;  ///< there is light that scatters
};

std::vector<Define> definesOf(const BentRayOptions& options, bool lit) {
    std::vector<Define> defines;
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
        require(options, surroundings, placed.size());
        const std::vector<LitVolume> lobes = allLobes(light);
        FullScreenPass& pass = impl_->pass;
        const GlFunctions& gl = pass.gl();
        const GpuIndexVolumes::Impl& volumes = objects.impl();
        const Double3 origin{double(surfaces.camera[0]), double(surfaces.camera[1]), double(surfaces.camera[2])};
        BentBlock block = blockOf(volumes, placed, origin, options);
        bool scatters = false, disperses = false;
        for (const PlacedObject& p : placed) {
            const GpuIndexVolumes::Impl::Object& object = volumes.objects[p.object];
            scatters = scatters || object.scatters || object.reflects;
            if (object.matte && surroundings.environment != 0 && !surroundings.harmonics)
                fail(ErrorCode::Usage,
                     "a face of a placed object reflects the surroundings evenly, which needs "
                     "Surroundings::harmonics: environmentHarmonics() makes them of the environment's texels");
            disperses = disperses || volumes.objects[p.object].disperses;
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
            std::vector<Define> defines = definesOf(options, shared.lit);
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
        require(options, surroundings, placed.size());
        const Double3 place{double(origin[0]), double(origin[1]), double(origin[2])};
        BentBlock block = blockOf(objects.impl(), placed, place, options);
        layAmbient(surroundings, block);
        impl_->upload(block);
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
