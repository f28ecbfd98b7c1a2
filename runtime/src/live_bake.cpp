// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/live_bake_impl.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "runtime/src/gl_program.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

constexpr int kWidestPad = 12;  // voxels that the sun's disc may reach
constexpr unsigned kGroup = 64;
constexpr unsigned kLayersAThread = 8;    // PHOTIC_LIVE_LAYERS of live_deposit.comp.glsl
constexpr unsigned kMeshOfAGroup = 8;     // live_deposit.comp.glsl: cells of the mesh a side
constexpr int kWidestWindow = 16;         // kWindow there
constexpr unsigned kRowOfGroups = 32768;  // live_clear.comp.glsl; GL promises 65535 a dimension

/// The two first image units, which a GlStateGuard does not know.
class ImageUnits {
public:
    explicit ImageUnits(const GlFunctions& gl) : gl_(gl) {
        constexpr GLenum kNames[6] = {GL_IMAGE_BINDING_NAME,  GL_IMAGE_BINDING_LEVEL,  GL_IMAGE_BINDING_LAYERED,
                                      GL_IMAGE_BINDING_LAYER, GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT};
        for (GLuint unit = 0; unit < 2; ++unit)
            for (std::size_t n = 0; n < 6; ++n) gl.GetIntegeri_v(kNames[n], unit, &saved_[unit][n]);
    }
    ~ImageUnits() {
        for (GLuint unit = 0; unit < 2; ++unit) {
            const auto& s = saved_[unit];
            gl_.BindImageTexture(unit, static_cast<GLuint>(s[0]), s[1], static_cast<GLboolean>(s[2] != 0), s[3],
                                 static_cast<GLenum>(s[4]), static_cast<GLenum>(s[5]));
        }
    }
    ImageUnits(const ImageUnits&) = delete;
    ImageUnits& operator=(const ImageUnits&) = delete;

private:
    const GlFunctions& gl_;
    std::array<std::array<GLint, 6>, 2> saved_{};
};

unsigned groups(std::uint64_t count, unsigned size) { return static_cast<unsigned>((count + size - 1) / size); }

/// Cells a side of the window that a group of threads sums in, for a group as wide as so many cells: waves bend light
/// by a few more. Where they bend it farther, or the group is wider, what lands outside is summed in main memory.
int windowOf(float cells) { return std::clamp(static_cast<int>(std::ceil(cells)) + 6, 8, kWidestWindow); }

struct Vec3f {
    double x, y, z;
};

/// Light in still water (Snell), unit, of travel.
Vec3f refracted(const Vec3f& d, double ior) {
    const double x = d.x / ior, y = d.y / ior;
    return {x, y, -std::sqrt(1 - x * x - y * y)};
}

/// Directions on the sun's disc, evenly (Vogel 1979), as refracted shifts: horizontal way per depth, less the middle's.
std::vector<std::array<double, 2>> discShifts(const WaterLight& light, double diameter_deg) {
    constexpr int kSamples = 1024;
    const Vec3f d = {light.direction[0], light.direction[1], light.direction[2]};
    const double s = d.z < 0 ? -1 : 1, a = -1 / (s + d.z), b = d.x * d.y * a;
    const Vec3f u = {1 + s * d.x * d.x * a, s * b, -s * d.x}, v = {b, s + d.y * d.y * a, -d.y};
    const double radius = std::tan(diameter_deg * 3.14159265358979 / 360);
    const auto shift = [&](double along_u, double along_v) {
        Vec3f w = {d.x + along_u * u.x + along_v * v.x, d.y + along_u * u.y + along_v * v.y,
                   d.z + along_u * u.z + along_v * v.z};
        const double length = std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z);
        w = {w.x / length, w.y / length, w.z / length};
        const Vec3f below = refracted(w, static_cast<double>(light.ior));
        return std::array{below.x / -below.z, below.y / -below.z};
    };
    const auto middle = shift(0, 0);
    std::vector<std::array<double, 2>> out;
    for (int i = 0; i < kSamples; ++i) {
        const double out_by = radius * std::sqrt((i + 0.5) / kSamples), turn = 2.399963229728653 * i;
        const auto at = shift(out_by * std::cos(turn), out_by * std::sin(turn));
        out.push_back({at[0] - middle[0], at[1] - middle[1]});
    }
    return out;
}

/// Light that is moved by a part of a voxel goes to the voxel that it falls in. That alone moves all of it to the
/// middles of voxels: shifts are first made longer or shorter along each axis until their mean square there is what it
/// was, as the baker's blur has it (bake/field/disc_blur.h). To mix a voxel's mean from those of its neighbours instead
/// would widen the disc by 1/6 of a square voxel along each axis.
/// @param along  shifts along one axis [voxels]. @return the factor on them
double factorOnVoxels(const std::vector<double>& along) {
    double wanted = 0, reach = 0;
    for (const double x : along) wanted += x * x, reach = std::max(reach, std::fabs(x));
    constexpr double kSmallest = 0.02;  // [voxels] changes a voxel by less than 1e-4 of its neighbours' difference
    if (reach < kSmallest) return 0;
    const auto moment = [&](double factor) {
        double sum = 0;
        for (const double x : along) sum += std::pow(std::round(factor * x), 2);
        return sum;
    };
    double low = 0, high = 1 + 1 / reach;
    for (int i = 0; i < 30; ++i) (moment(0.5 * (low + high)) < wanted ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

}  // namespace

LiveBake::Impl::~Impl() {
    const GlFunctions& gl = context.gl();
    for (GLuint* buffer : {&sums, &kernel}) {
        if (*buffer) gl.DeleteBuffers(1, buffer);
    }
    for (GLuint program : {clear[0], clear[1], deposit[0], deposit[1], resolve[0], resolve[1]}) {
        if (program) gl.DeleteProgram(program);
    }
}

GLuint LiveBake::Impl::programOf(GLuint (&programs)[2], const char* file) {
    GLuint& program = programs[coloured ? 1 : 0];
    if (program) return program;
    const Result<GLuint> made = makeProgram(
        gl(), {{GL_COMPUTE_SHADER, file}},
        {{"PHOTIC_COLOURED", coloured ? "1" : "0"}, {"PHOTIC_LIVE_LAYERS", std::to_string(kLayersAThread)}});
    if (!made) throw Failure{made.error()};
    return program = *made;
}

/// The image of the sun's disc in each layer, as shares of voxels around.
void LiveBake::Impl::setKernel(const WaterLight& light, float level) {
    const float now[4] = {light.direction[0], light.direction[1], light.direction[2], light.ior};
    if (kernel && std::equal(now, now + 4, kernel_light) && level == kernel_level) return;
    const bool disc = options.angular_diameter_deg > 0;
    const auto shifts = disc ? discShifts(light, static_cast<double>(options.angular_diameter_deg))
                             : std::vector<std::array<double, 2>>(1);
    const auto layers = static_cast<std::size_t>(options.voxels[2]);
    // For each layer and shift the voxel that light falls in, from its own.
    std::vector<std::array<int, 2>> falls(layers * shifts.size());
    int reach = 0;
    for (std::size_t layer = 0; layer < layers; ++layer) {
        const double z = static_cast<double>(options.min[2]) + (static_cast<double>(layer) + 0.5) * double(voxel(2));
        const double depth = std::max(0.0, static_cast<double>(level) - z);
        for (std::size_t a = 0; a < 2; ++a) {
            std::vector<double> along;
            for (const auto& shift : shifts) along.push_back(depth * shift[a] / static_cast<double>(voxel(a)));
            const double factor = factorOnVoxels(along);
            for (std::size_t n = 0; n < along.size(); ++n) {
                const double by = std::clamp(std::round(factor * along[n]), -1e6, 1e6);
                falls[layer * shifts.size() + n][a] = static_cast<int>(by);
                reach = std::max(reach, static_cast<int>(std::fabs(by)));
            }
        }
    }
    pad = reach;
    if (pad > kWidestPad) {
        fail(ErrorCode::Limit, "the sun's disc reaches " + std::to_string(pad) + " voxels at the bottom, and at most " +
                                   std::to_string(kWidestPad) + " are blurred; take wider voxels or a narrower sun");
    }
    const int side = 2 * pad + 1;
    std::vector<float> weights(static_cast<std::size_t>(side * side) * layers, 0.0F);
    for (std::size_t n = 0; n < falls.size(); ++n) {
        float* of_layer = weights.data() + n / shifts.size() * static_cast<std::size_t>(side * side);
        of_layer[(falls[n][1] + pad) * side + falls[n][0] + pad] += 1 / static_cast<float>(shifts.size());
    }
    if (!kernel) gl().GenBuffers(1, &kernel);
    gl().BindBuffer(GL_SHADER_STORAGE_BUFFER, kernel);
    kernel_light[3] = 0;  // no water's index: until it is filled, the kernel is nobody's
    fillBuffer(gl(), GL_SHADER_STORAGE_BUFFER, weights.data(), weights.size() * sizeof(float), GL_STATIC_DRAW,
               "the image of the sun's disc");
    std::copy(now, now + 4, kernel_light);
    kernel_level = level;
}

namespace {

GLuint makeSampler3d(const GlFunctions& gl, GLenum filter, bool repeats) {
    GLuint sampler = 0;
    gl.GenSamplers(1, &sampler);
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl.SamplerParameteri(sampler, name, static_cast<GLint>(filter));
    for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        gl.SamplerParameteri(sampler, name, repeats ? GL_REPEAT : GL_CLAMP_TO_EDGE);
    gl.SamplerParameteri(sampler, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    return sampler;
}

}  // namespace

/// The volume that is baked into: dense, a dark voxel around the box where the light does not repeat.
void LiveBake::Impl::makeVolume() {
    gl().clearErrors();  // what the game left behind is no fault of the textures
    auto impl = std::make_unique<GpuVolume::Impl>(context);
    VolumeParameters& p = impl->parameters;
    Int3 size, pages;
    float* const rows[3] = {p.row_x, p.row_y, p.row_z};
    for (std::size_t a = 0; a < 3; ++a) {
        const bool repeats = periodic && a < 2;
        const int n = options.voxels[a], border = repeats ? 0 : 1;
        size[a] = n + 2 * border;
        pages[a] = (size[a] + 7) / 8;
        // Local coordinate 0 is the centre of the box's middle voxel.
        const int middle = n / 2;
        p.centre[a] = options.min[a] + (static_cast<float>(middle) + 0.5F) * voxel(a);
        rows[a][a] = 1 / voxel(a);
        p.offset[a] = middle + border;
        p.cell_max[a] = size[a] - 1 - border;
        p.period[a] = repeats ? n : 0;
        p.texel[a] = 1.0F / static_cast<float>(size[a]);
        constexpr float kFar = std::numeric_limits<float>::max();
        p.lit_min[a] = repeats ? -kFar : static_cast<float>(-1 - middle);
        p.lit_max[a] = repeats ? kFar : static_cast<float>(n - middle);
    }
    p.scale = 1, p.layout = 2, p.directed = 1;
    p.repeats = periodic ? 1 : 0;
    p.coloured = coloured ? 1 : 0;
    impl->light = makeTexture3d(gl(), GL_RGBA16F, size, "a live bake");
    if (coloured) impl->rgb = makeTexture3d(gl(), GL_RGBA16F, size, "a live bake");
    // No page is known to be dark.
    const std::vector<std::uint32_t> lit(BrickLayout::texelsOf(pages), 1);
    impl->pages = makeTexture3d(gl(), GL_R32UI, pages, "the page table of a live bake");
    gl().TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, pages[0], pages[1], pages[2], GL_RED_INTEGER, GL_UNSIGNED_INT,
                       lit.data());
    impl->sampler = makeSampler3d(gl(), GL_LINEAR, periodic);
    impl->page_sampler = makeSampler3d(gl(), GL_NEAREST, false);
    gl().GenBuffers(1, &impl->parameter_buffer);
    gl().BindBuffer(GL_UNIFORM_BUFFER, impl->parameter_buffer);
    fillBuffer(gl(), GL_UNIFORM_BUFFER, &p, sizeof(p), GL_DYNAMIC_DRAW, "the parameters of a live bake");
    impl->info.layout = Layout::Dense;
    impl->info.fill = 1;
    impl->info.bytes = BrickLayout::texelsOf(size) * (coloured ? 16 : 8);
    volume.reset(new GpuVolume(std::move(impl)));
}

/// What depends on the water and its light: colour, the blur, buffers and textures of their size.
void LiveBake::Impl::prepare(const LiveWater::Impl& water) {
    const WaterLight& light = water.light;
    const auto alike = [](const float* v) { return v[0] == v[1] && v[1] == v[2]; };
    const bool wants_colour = !alike(light.irradiance) || !alike(light.extinction);
    const bool repeats = water.water.outside == WaterOutside::Periodic;
    if (repeats) {
        for (std::size_t a = 0; a < 2; ++a) {
            const float tolerance = 1e-3F * voxel(a);
            if (std::fabs(options.min[a] - water.water.corner[a]) > tolerance ||
                std::fabs(options.max[a] - water.water.corner[a] - water.water.size[a]) > tolerance)
                fail(ErrorCode::Usage,
                     "the water repeats, and the box is not its rectangle; give LiveBakeOptions the water's corner and "
                     "size along x and y");
        }
    }
    const int old_pad = pad;
    setKernel(light, water.water.level);
    const bool remake = !sums || wants_colour != coloured || repeats != periodic || pad != old_pad;
    if (!remake) return;
    coloured = wants_colour, periodic = repeats;
    const std::uint64_t bytes = 4 * sumCount(coloured);
    if (bytes > static_cast<std::uint64_t>(std::max<GLint64>(0, gl().largest_storage_block))) {
        fail(ErrorCode::Limit,
             "the sums of " + std::to_string(options.voxels[0]) + " x " + std::to_string(options.voxels[1]) + " x " +
                 std::to_string(options.voxels[2]) + " voxels take " + std::to_string(bytes) +
                 " bytes, and the GPU's storage blocks hold " + std::to_string(gl().largest_storage_block) +
                 "; take fewer voxels, or LiveWater's caustic map");
    }
    if (!sums) gl().GenBuffers(1, &sums);
    gl().BindBuffer(GL_SHADER_STORAGE_BUFFER, sums);
    try {
        fillBuffer(gl(), GL_SHADER_STORAGE_BUFFER, nullptr, bytes, GL_DYNAMIC_COPY, "a live bake's sums");
    } catch (const Failure&) {
        gl().DeleteBuffers(1, &sums);
        sums = 0;  // made again when there may be room
        throw;
    }
    sums_bytes = bytes;
    makeVolume();
}

void LiveBake::Impl::dispatch(const LiveWater::Impl& water) {
    const GlFunctions& g = gl();
    GpuVolume::Impl& out = volume->impl();
    const WaterLight& light = water.light;
    out.reference_irradiance = std::max({light.irradiance[0], light.irradiance[1], light.irradiance[2]});
    g.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, sums);
    g.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, kernel);

    g.UseProgram(programOf(clear, "live_clear.comp.glsl"));
    const unsigned all = groups(sumCount(coloured), kGroup);
    g.DispatchCompute(std::min(all, kRowOfGroups), groups(all, kRowOfGroups), 1);
    g.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);

    {
        const Uniforms uniforms(g, programOf(deposit, "live_deposit.comp.glsl"));
        water.setWater(uniforms, 0);
        uniforms.texture("photic_ray_starts", 1, GL_TEXTURE_2D, water.ray_starts);
        uniforms.texture("photic_ray_directions", 2, GL_TEXTURE_2D, water.ray_directions);
        setGrid(uniforms, periodic);
        const float voxels[3] = {voxel(0), voxel(1), voxel(2)};
        uniforms.set3("photic_live_corner", options.min.data());
        uniforms.set3("photic_live_voxel", voxels);
        uniforms.set("photic_live_mesh", water.water.size[0] / static_cast<float>(water.columns),
                     water.water.size[1] / static_cast<float>(water.rows), 0.0F, 0.0F);
        float sun[3];
        for (int c = 0; c < 3; ++c)
            sun[c] = out.reference_irradiance > 0 ? light.irradiance[c] / out.reference_irradiance : 0;
        uniforms.set3("photic_live_sun", sun);
        const float mesh[2] = {water.water.size[0] / static_cast<float>(water.columns),
                               water.water.size[1] / static_cast<float>(water.rows)};
        uniforms.set("photic_live_window", windowOf(kMeshOfAGroup * std::max(mesh[0] / voxel(0), mesh[1] / voxel(1))));
        g.DispatchCompute(groups(static_cast<std::uint64_t>(water.mesh_columns - 1), kMeshOfAGroup),
                          groups(static_cast<std::uint64_t>(water.mesh_rows - 1), kMeshOfAGroup),
                          groups(static_cast<std::uint64_t>(options.voxels[2]), kLayersAThread));
    }
    g.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);

    const Uniforms uniforms(g, programOf(resolve, "live_resolve.comp.glsl"));
    setGrid(uniforms, periodic);
    g.BindImageTexture(0, out.light, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    if (coloured) g.BindImageTexture(1, out.rgb, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    uniforms.set("photic_live_border", periodic ? 0 : 1, 1, 0, 0);
    const auto along = [&](std::size_t a) { return static_cast<unsigned>(options.voxels[a] + 2); };
    g.DispatchCompute(groups(along(0), 8), groups(along(1), 8), along(2));
    g.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

LiveBake::LiveBake(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveBake::LiveBake(LiveBake&&) noexcept = default;
LiveBake& LiveBake::operator=(LiveBake&&) noexcept = default;
LiveBake::~LiveBake() = default;

Result<LiveBake> LiveBake::create(const GpuContext& context, const LiveBakeOptions& options) {
    return guarded([&]() -> Result<LiveBake> {
        if (!context.gl().computes)
            fail(ErrorCode::Unsupported,
                 "this GL has no compute shaders, which a live bake is made of; use LiveWater's caustic map");
        const int largest = context.gl().largest_texture_3d - 2;
        for (std::size_t a = 0; a < 3; ++a) {
            if (!(options.max[a] > options.min[a]) || !std::isfinite(options.max[a] - options.min[a]))
                fail(ErrorCode::Usage, "a live bake's box needs max above min along each axis, and finite numbers");
            if (options.voxels[a] < 1 || options.voxels[a] > largest)
                fail(ErrorCode::Limit, std::to_string(options.voxels[a]) +
                                           " voxels along an axis of a live bake are not "
                                           "between 1 and " +
                                           std::to_string(largest));
        }
        if (!(options.angular_diameter_deg >= 0 && options.angular_diameter_deg <= 20))
            fail(ErrorCode::Usage, "the sun's disc is " + std::to_string(options.angular_diameter_deg) +
                                       " degrees wide; 0 to 20 are blurred");
        auto impl = std::make_unique<Impl>(context, options);
        const GlStateGuard guard(context.gl());
        // Compiled now, so that a driver's refusal shows here.
        impl->programOf(impl->clear, "live_clear.comp.glsl");
        impl->programOf(impl->deposit, "live_deposit.comp.glsl");
        impl->programOf(impl->resolve, "live_resolve.comp.glsl");
        impl->makeVolume();
        return LiveBake(std::move(impl));
    });
}

Status LiveBake::update(LiveWater& water) {
    return guarded([&]() -> Status {
        Retired retired(impl_->gl());
        const GlStateGuard guard(impl_->gl());
        const ImageUnits images(impl_->gl());
        impl_->gl().ActiveTexture(GL_TEXTURE0);
        if (const Status traced = water.impl().traceRays(retired); !traced) return traced;
        impl_->prepare(water.impl());
        impl_->dispatch(water.impl());
        return Done{};
    });
}

GpuVolume& LiveBake::volume() { return *impl_->volume; }
std::uint64_t LiveBake::gpuBytes() const { return impl_->sums_bytes + impl_->volume->info().bytes; }

void LiveBake::abandon() {
    impl_->volume->abandon();
    impl_->sums = impl_->kernel = 0;
    for (GLuint* programs : {impl_->clear, impl_->deposit, impl_->resolve}) programs[0] = programs[1] = 0;
}

}  // namespace photic::runtime
