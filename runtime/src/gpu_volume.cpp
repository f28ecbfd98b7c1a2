// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "runtime/src/brick_plan.h"
#include "runtime/src/gl_state.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

constexpr double kDenseFill = 0.7;        // above it one dense texture is smaller and faster than bricks (measured)
constexpr int kMostBricksASide = 255;     // a byte in an entry
constexpr std::uint64_t kTexelBytes = 8;  // four halves

struct Limits {
    int texture_3d;
    std::uint64_t storage_block;
};

/// How many bricks lie along each axis of the atlas.
Int3 atlasShape(std::uint32_t bricks, int largest_side) {
    const int most = std::min(kMostBricksASide, largest_side / BrickPlan::kSide);
    const auto count = static_cast<std::int64_t>(bricks);
    const auto side = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(count))));
    const int x = std::min(side, most);
    const int y = std::min(static_cast<int>((count + x - 1) / x), std::min(side, most));
    return {x, y, static_cast<int>((count + std::int64_t{x} * y - 1) / (std::int64_t{x} * y))};
}

Int3 denseSize(const VolumeData& data, const BrickPlan& plan) {
    Int3 size;
    for (std::size_t a = 0; a < 3; ++a) {
        // One voxel more than cells on axes that end: the last cell reads the dark voxel beyond it.
        size[a] = std::max(1, plan.cell_max[a] - plan.cell_min[a] + 1 + (data.period[a] == 0));
    }
    return size;
}

std::uint64_t product(const Int3& v) {
    return static_cast<std::uint64_t>(v[0]) * static_cast<std::uint64_t>(v[1]) * static_cast<std::uint64_t>(v[2]);
}

bool fits(const Int3& size, int largest) { return *std::max_element(size.begin(), size.end()) <= largest; }

/// What one layout would take: its bytes, and why GL would not have it, or nothing.
struct Need {
    std::uint64_t bytes;
    std::string obstacle;
};

class Uploader {
public:
    Uploader(const GpuContext& context, const VolumeData& data, const Limits& limits, std::uint64_t budget)
        : context_(context), gl_(context.gl()), data_(data), limits_(limits), plan_(planBricks(data, budget)) {}

    double fill() const { return plan_.fill(); }

    Need need(Layout layout) const {
        const std::uint64_t textures = data_.coloured ? 2 : 1, pages = plan_.entries.size() * sizeof(std::uint32_t);
        const auto tooLarge = [](const char* what, std::uint64_t size, std::uint64_t limit) {
            return std::string(what) + " would be " + std::to_string(size) + ", and the limit is " +
                   std::to_string(limit);
        };
        if (!fits(plan_.page_count, limits_.texture_3d)) {
            return {
                0, tooLarge("the longest side of the page table", static_cast<std::uint64_t>(longest(plan_.page_count)),
                            static_cast<std::uint64_t>(limits_.texture_3d))};
        }
        const auto sideOf = [&](const Int3& size) {
            if (fits(size, limits_.texture_3d)) return std::string();
            return tooLarge("the longest side of the 3D texture", static_cast<std::uint64_t>(longest(size)),
                            static_cast<std::uint64_t>(limits_.texture_3d));
        };
        if (layout == Layout::Dense) {
            const Int3 size = denseSize(data_, plan_);
            return {pages + textures * product(size) * kTexelBytes, sideOf(size)};
        }
        if (layout == Layout::Atlas) {
            if (limits_.texture_3d < BrickPlan::kSide) return {0, sideOf({BrickPlan::kSide, 0, 0})};
            Int3 size = atlasShape(plan_.brickCount(), limits_.texture_3d);
            const bool numbered = size[2] <= kMostBricksASide;
            for (int& side : size) side *= BrickPlan::kSide;
            return {pages + textures * product(size) * kTexelBytes,
                    numbered ? sideOf(size) : std::string("there are more bricks than an atlas numbers")};
        }
        const std::uint64_t bytes = std::uint64_t{plan_.brickCount()} * BrickPlan::kVoxels * textures * kTexelBytes;
        return {pages + bytes,
                bytes <= limits_.storage_block ? "" : tooLarge("the bricks' bytes", bytes, limits_.storage_block)};
    }

    /// @throws Failure{Memory} when GL has none left
    std::unique_ptr<GpuVolume::Impl> upload(Layout layout, Filter filter) {
        auto impl = std::make_unique<GpuVolume::Impl>(context_);
        impl->filter = filter;
        impl->info.layout = layout;
        impl->info.fill = plan_.fill();
        impl->info.bytes = need(layout).bytes;
        impl->info.bricks = layout == Layout::Dense ? 0 : plan_.brickCount() - 1;
        impl->reference_irradiance = static_cast<float>(data_.metadata.reference_irradiance);
        Int3 size = {1, 1, 1};
        if (layout == Layout::Dense) {
            size = uploadDense(*impl);
        } else if (layout == Layout::Atlas) {
            size = uploadAtlas(*impl);
        } else {
            uploadBuffer(*impl);
        }
        uploadPages(*impl, layout == Layout::Atlas ? placesInAtlas() : plan_.entries);
        makeSamplers(*impl, layout);
        setParameters(*impl, layout, size);
        requireMemory("the parameters");
        return impl;
    }

private:
    static int longest(const Int3& v) { return *std::max_element(v.begin(), v.end()); }

    void requireMemory(const char* of) const {
        const GLenum error = gl_.firstError();
        if (error == GL_NO_ERROR) return;
        char code[16];
        std::snprintf(code, sizeof(code), "0x%04x", static_cast<unsigned>(error));
        if (error == GL_OUT_OF_MEMORY) fail(ErrorCode::Memory, std::string("the GPU has no memory left for ") + of);
        fail(ErrorCode::Memory, std::string("GL refuses ") + of + " with error " + code);
    }

    GLuint makeTexture(GLenum format, const Int3& size, const char* of) const {
        GLuint texture = 0;
        gl_.GenTextures(1, &texture);
        gl_.BindTexture(GL_TEXTURE_3D, texture);
        gl_.TexStorage3D(GL_TEXTURE_3D, 1, format, size[0], size[1], size[2]);
        const GLenum error = gl_.GetError();
        if (error != GL_NO_ERROR) {
            gl_.DeleteTextures(1, &texture);
            fail(ErrorCode::Memory, std::string("the GPU has no memory left for ") + of + " of " +
                                        std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                                        std::to_string(size[2]) + " texels");
        }
        return texture;
    }

    /// Makes both textures and fills them layer by layer of `depth` texels: fill(z, light, rgb).
    template <class Fill>
    void uploadLayers(GpuVolume::Impl& impl, const Int3& size, int depth, const Fill& fill) const {
        impl.light = makeTexture(GL_RGBA16F, size, "the light");
        if (data_.coloured) impl.rgb = makeTexture(GL_RGBA16F, size, "the colours");
        const std::size_t layer = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
        std::vector<Half4> light(layer * static_cast<std::size_t>(depth)), rgb(data_.coloured ? light.size() : 0);
        for (int z = 0; z < size[2]; z += depth) {
            const int count = std::min(depth, size[2] - z);
            fill(z, count, light.data(), data_.coloured ? rgb.data() : nullptr);
            const auto put = [&](GLuint texture, const std::vector<Half4>& texels) {
                gl_.BindTexture(GL_TEXTURE_3D, texture);
                gl_.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, size[0], size[1], count, GL_RGBA, GL_HALF_FLOAT,
                                  texels.data());
            };
            put(impl.light, light);
            if (data_.coloured) put(impl.rgb, rgb);
        }
        requireMemory("the light");
    }

    Int3 uploadDense(GpuVolume::Impl& impl) const {
        const Int3 size = denseSize(data_, plan_);
        uploadLayers(impl, size, 8, [&](int z, int count, Half4* light, Half4* rgb) {
            fillBox(data_, {plan_.cell_min[0], plan_.cell_min[1], plan_.cell_min[2] + z}, {size[0], size[1], count},
                    light, rgb);
        });
        return size;
    }

    Int3 uploadAtlas(GpuVolume::Impl& impl) const {
        constexpr int kSide = BrickPlan::kSide;
        const Int3 shape = atlasShape(plan_.brickCount(), limits_.texture_3d);
        const Int3 size = {shape[0] * kSide, shape[1] * kSide, shape[2] * kSide};
        std::vector<Half4> brick(BrickPlan::kVoxels), colours(data_.coloured ? brick.size() : 0);
        uploadLayers(impl, size, kSide, [&](int z, int, Half4* light, Half4* rgb) {
            const std::size_t count = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * kSide;
            std::fill_n(light, count, Half4{});
            if (rgb) std::fill_n(rgb, count, Half4{});
            for (int by = 0; by < shape[1]; ++by) {
                for (int bx = 0; bx < shape[0]; ++bx) {
                    const std::size_t number =
                        (static_cast<std::size_t>(z / kSide) * static_cast<std::size_t>(shape[1]) +
                         static_cast<std::size_t>(by)) *
                            static_cast<std::size_t>(shape[0]) +
                        static_cast<std::size_t>(bx);
                    if (number == 0 || number >= plan_.brickCount()) continue;
                    fillBrick(data_, plan_.bricks[number - 1], brick.data(), rgb ? colours.data() : nullptr);
                    for (int row = 0; row < kSide * kSide; ++row) {
                        const std::size_t to =
                            (static_cast<std::size_t>(row / kSide) * static_cast<std::size_t>(size[1]) +
                             static_cast<std::size_t>(by * kSide + row % kSide)) *
                                static_cast<std::size_t>(size[0]) +
                            static_cast<std::size_t>(bx * kSide);
                        std::copy_n(brick.data() + row * kSide, kSide, light + to);
                        if (rgb) std::copy_n(colours.data() + row * kSide, kSide, rgb + to);
                    }
                }
            }
        });
        return size;
    }

    /// The page table with each brick's place instead of its number.
    std::vector<std::uint32_t> placesInAtlas() const {
        const Int3 shape = atlasShape(plan_.brickCount(), limits_.texture_3d);
        const auto nx = static_cast<std::uint32_t>(shape[0]), ny = static_cast<std::uint32_t>(shape[1]);
        std::vector<std::uint32_t> entries = plan_.entries;
        for (std::uint32_t& entry : entries) {
            const std::uint32_t number = entry & BrickPlan::kNumberMask;
            if (number != 0) entry = number % nx | number / nx % ny << 8 | number / (nx * ny) << 16;
        }
        return entries;
    }

    void uploadBuffer(GpuVolume::Impl& impl) const {
        const std::size_t step = data_.coloured ? 2 : 1;
        std::vector<Half4> words(std::size_t{plan_.brickCount()} * BrickPlan::kVoxels * step);
        std::vector<Half4> light(BrickPlan::kVoxels), rgb(data_.coloured ? light.size() : 0);
        for (std::size_t number = 1; number < plan_.brickCount(); ++number) {
            fillBrick(data_, plan_.bricks[number - 1], light.data(), data_.coloured ? rgb.data() : nullptr);
            Half4* out = words.data() + number * BrickPlan::kVoxels * step;
            for (std::size_t v = 0; v < BrickPlan::kVoxels; ++v) {
                out[v * step] = light[v];
                if (data_.coloured) out[v * step + 1] = rgb[v];
            }
        }
        gl_.GenBuffers(1, &impl.bricks);
        gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, impl.bricks);
        gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(words.size() * sizeof(Half4)), words.data(),
                       GL_STATIC_DRAW);
        requireMemory("the bricks");
    }

    void uploadPages(GpuVolume::Impl& impl, const std::vector<std::uint32_t>& entries) const {
        const Int3& size = plan_.page_count;
        impl.pages = makeTexture(GL_R32UI, size, "the page table");
        gl_.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, size[0], size[1], size[2], GL_RED_INTEGER, GL_UNSIGNED_INT,
                          entries.data());
        requireMemory("the page table");
    }

    void makeSamplers(GpuVolume::Impl& impl, Layout layout) const {
        GLuint samplers[2];
        gl_.GenSamplers(2, samplers);
        impl.sampler = samplers[0], impl.page_sampler = samplers[1];
        constexpr GLenum kWraps[3] = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R};
        for (std::size_t a = 0; a < 3; ++a) {
            const bool repeats = layout == Layout::Dense && data_.period[a] != 0;
            gl_.SamplerParameteri(impl.sampler, kWraps[a], repeats ? GL_REPEAT : GL_CLAMP_TO_EDGE);
            gl_.SamplerParameteri(impl.page_sampler, kWraps[a], GL_CLAMP_TO_EDGE);
        }
        for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
            gl_.SamplerParameteri(impl.sampler, name, GL_LINEAR);
            gl_.SamplerParameteri(impl.page_sampler, name, GL_NEAREST);
        }
    }

    void setParameters(GpuVolume::Impl& impl, Layout layout, const Int3& texture_size) const {
        VolumeParameters& p = impl.parameters;
        // Local coordinates count from a voxel in the middle, and their centre is that voxel's, rounded to float: what
        // the rounding costs goes into the rows' fourth component.
        Double3 middle, world;
        for (std::size_t a = 0; a < 3; ++a) middle[a] = floorDivide(plan_.cell_min[a] + plan_.cell_max[a] + 1, 2);
        const Double3 offset = multiply(data_.transform.world_from_index, middle);
        for (std::size_t a = 0; a < 3; ++a) {
            p.centre[a] = static_cast<float>(data_.transform.origin_world[a] + offset[a]);
            world[a] = static_cast<double>(p.centre[a]);
        }
        p.centre[3] = impl.reference_irradiance;
        const Double3 index = data_.transform.indexOf(world);
        float* const rows[3] = {p.row_x, p.row_y, p.row_z};
        for (std::size_t a = 0; a < 3; ++a) {
            for (std::size_t c = 0; c < 3; ++c)
                rows[a][c] = static_cast<float>(data_.transform.index_from_world[3 * a + c]);
            rows[a][3] = static_cast<float>(index[a] - middle[a]);
            const int first = 8 * plan_.page_min[a], centre = static_cast<int>(middle[a]);
            p.offset[a] = centre - first;
            p.cell_min[a] = plan_.cell_min[a] - first;
            p.cell_max[a] = plan_.cell_max[a] - first;
            p.dense_min[a] = plan_.cell_min[a] - first;
            p.period[a] = data_.period[a];
            p.texel[a] = 1.0F / static_cast<float>(texture_size[a]);
            constexpr float kFar = std::numeric_limits<float>::max();
            const bool repeats = data_.period[a] != 0;
            p.lit_min[a] = repeats ? -kFar : static_cast<float>(plan_.cell_min[a] - centre);
            p.lit_max[a] = repeats ? kFar : static_cast<float>(plan_.cell_max[a] + 1 - centre);
        }
        p.offset[3] = layout == Layout::Dense ? 2 : 1;
        p.cell_min[3] = data_.coloured;
        p.cell_max[3] = data_.has_direction;
        p.period[3] = data_.period != Int3{0, 0, 0};
        gl_.GenBuffers(1, &impl.parameter_buffer);
        gl_.BindBuffer(GL_UNIFORM_BUFFER, impl.parameter_buffer);
        gl_.BufferData(GL_UNIFORM_BUFFER, sizeof(p), &p, GL_DYNAMIC_DRAW);
    }

    const GpuContext& context_;
    const GlFunctions& gl_;
    const VolumeData& data_;
    Limits limits_;
    BrickPlan plan_;
};

/// The layouts to try, best first.
std::vector<Layout> candidates(const UploadOptions& options, double fill) {
    if (options.layout != Layout::Automatic) return {options.layout};
    if (fill > kDenseFill) return {Layout::Dense, Layout::Atlas, Layout::Buffer};
    return {Layout::Atlas, Layout::Dense, Layout::Buffer};
}

const char* nameOf(Layout layout) {
    switch (layout) {
        case Layout::Atlas:
            return "atlas";
        case Layout::Dense:
            return "dense";
        case Layout::Buffer:
            return "buffer";
        case Layout::Automatic:
            break;
    }
    return "automatic";
}

/// Uploads `volume` as it is in the first layout that works; null, with the reasons, when none does.
std::unique_ptr<GpuVolume::Impl> uploadOnce(const GpuContext& context, const Volume& volume,
                                            const UploadOptions& options, Error& why) {
    const GlFunctions& gl = context.gl();
    Limits limits{gl.largest_texture_3d, static_cast<std::uint64_t>(std::max<GLint64>(0, gl.largest_storage_block))};
    if (options.largest_texture_3d > 0) limits.texture_3d = std::min(limits.texture_3d, options.largest_texture_3d);
    if (options.largest_storage_block > 0)
        limits.storage_block = std::min(limits.storage_block, options.largest_storage_block);
    std::optional<Uploader> planned;
    try {
        planned.emplace(context, volume.data(), limits, options.budget);
    } catch (const Failure& failure) {
        why = failure.error;
        return nullptr;
    }
    Uploader& uploader = *planned;
    std::string reasons;
    why.code = ErrorCode::Limit;
    for (const Layout layout : candidates(options, uploader.fill())) {
        const Need need = uploader.need(layout);
        std::string reason = need.obstacle;
        if (reason.empty() && need.bytes > options.budget) {
            reason = std::to_string(need.bytes) + " bytes, and the budget is " + std::to_string(options.budget);
        }
        if (reason.empty()) {
            try {
                return uploader.upload(layout, options.filter);
            } catch (const Failure& failure) {
                why.code = failure.error.code;
                reason = failure.error.message;
            }
        }
        reasons += std::string(reasons.empty() ? "" : "; ") + nameOf(layout) + ": " + reason;
    }
    why.message = "the volume fits in no layout: " + reasons + "; raise the budget, or export with a smaller one";
    return nullptr;
}

}  // namespace

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
    if (parameters.centre[3] != scale) {
        parameters.centre[3] = scale;
        gl.BindBuffer(GL_UNIFORM_BUFFER, parameter_buffer);
        gl.BufferData(GL_UNIFORM_BUFFER, sizeof(parameters), &parameters, GL_DYNAMIC_DRAW);
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
void GpuVolume::abandon() {
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
        Error why;
        Volume level = volume;
        for (int coarsened = 0;; ++coarsened) {
            auto impl = uploadOnce(context, level, options, why);
            if (impl) {
                impl->info.coarsened = coarsened;
                return GpuVolume(std::move(impl));
            }
            // A handful of voxels that does not fit will not fit when it is coarser.
            if (options.when_too_large == WhenTooLarge::Refuse || level.litVoxelCount() < 64) return why;
            level = halfResolution(level.data());
        }
    });
}

Result<GpuContext> GpuContext::create(const GlLoader& loader) {
    return guarded([&]() -> Result<GpuContext> {
        Result<GlFunctions> gl = loadGlFunctions(loader);
        if (!gl) return gl.error();
        return GpuContext(std::make_shared<const GlFunctions>(std::move(*gl)));
    });
}

std::string GpuContext::renderer() const { return gl_->renderer; }

}  // namespace photic::runtime
