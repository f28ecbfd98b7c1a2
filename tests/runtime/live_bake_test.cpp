// SPDX-License-Identifier: Apache-2.0
// Light baked on the GPU: the baker's own, its energy layer by layer, and the same look-ups.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "bake/image/colour_map.h"
#include "bake/image/image.h"
#include "runtime/src/live_bake_impl.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/gpu_fixture.h"

namespace photic::runtime {
namespace {

constexpr double kHalf = 0.6;  // of the water's rectangle [m]
constexpr int kSide = 48;      // voxels along x and y
constexpr double kVoxel = 2 * kHalf / kSide, kBottom = -0.9, kTop = 0.1;
constexpr int kLayers = 40;

double waves(double x, double y) {
    constexpr double kTurn = 2 * std::numbers::pi;
    return 0.02 * std::sin(kTurn / 0.6 * x + 0.4) + 0.012 * std::sin(kTurn / 0.4 * y + 1.7);
}

/// The same waves as a scene.
std::string sceneText(double disc, const std::string& irradiance, const std::string& medium, int mesh) {
    return R"(photic = 1
[domain]
min = [-0.6, -0.6, -0.9]
max = [0.6, 0.6, 0.1]
voxel_size = 0.025
[[light]]
type = "sun"
direction = [0.3, 0.2, -1]
angular_diameter = )" +
           std::to_string(disc) + "\nirradiance = " + irradiance + R"(
[[surface]]
name = "water"
kind = "height_field"
size = [1.2, 1.2]
outside = "periodic"
waves = [{ amplitude = 0.02, wavelength = 0.6, direction = 0, phase = 0.4 },
         { amplitude = 0.012, wavelength = 0.4, direction = 90, phase = 1.7 }]
)" + medium +
           "[bake]\nquadrature = 1\n[bake.beams]\nmesh = " + std::to_string(mesh) + "\n";
}

struct Water {
    Water(const GpuContext& gpu, int side, const WaterLight& light) : live(LiveWater::create(gpu).value()) {
        heights.corner[0] = heights.corner[1] = -kHalf;
        heights.size[0] = heights.size[1] = 2 * kHalf;
        heights.columns = heights.rows = side;
        heights.outside = WaterOutside::Periodic;
        EXPECT_TRUE(live.setLight(light).ok());
    }
    template <class Height>
    void set(const Height& height) {
        values.clear();
        for (int j = 0; j < heights.rows; ++j) {
            for (int i = 0; i < heights.columns; ++i) {
                const double step = 2 * kHalf / heights.columns;
                values.push_back(static_cast<float>(height(-kHalf + (i + 0.5) * step, -kHalf + (j + 0.5) * step)));
            }
        }
        heights.heights = values.data();
        const Status done = live.setHeights(heights);
        EXPECT_TRUE(done.ok()) << (done.ok() ? "" : done.error().message);
    }
    std::vector<float> values;
    WaterHeights heights;
    LiveWater live;
};

WaterLight sun() {
    WaterLight light;
    light.direction[0] = 0.3F, light.direction[1] = 0.2F, light.direction[2] = -1;
    return light;
}

LiveBakeOptions box(float disc) {
    LiveBakeOptions options;
    options.min = {-float(kHalf), -float(kHalf), float(kBottom)};
    options.max = {float(kHalf), float(kHalf), float(kTop)};
    options.voxels = {kSide, kSide, kLayers};
    options.angular_diameter_deg = disc;
    return options;
}

std::vector<std::array<float, 4>> centres() {
    std::vector<std::array<float, 4>> out;
    for (int k = 0; k < kLayers; ++k)
        for (int j = 0; j < kSide; ++j)
            for (int i = 0; i < kSide; ++i)
                out.push_back({float(-kHalf + (i + 0.5) * kVoxel), float(-kHalf + (j + 0.5) * kVoxel),
                               float(kBottom + (k + 0.5) * kVoxel), 0});
    return out;
}

using LiveBakes = test::WithGpu;

/// Light at all voxels' centres beside the baker's: sums of differences over the sum of irradiance.
struct Beside {
    double irradiance = 0, flux = 0, all = 0;  ///< all: live over baked
};

Beside compared(const Volume& baked, const std::vector<std::array<float, 4>>& positions,
                const std::vector<test::GpuSample>& live) {
    Beside out;
    double light = 0;
    for (std::size_t n = 0; n < positions.size(); ++n) {
        const auto& p = positions[n];
        const Light cpu = baked.sample({double(p[0]), double(p[1]), double(p[2])});
        const double irradiance[3] = {cpu.irradiance.x, cpu.irradiance.y, cpu.irradiance.z};
        const double flux[3] = {cpu.flux.x, cpu.flux.y, cpu.flux.z};
        for (std::size_t c = 0; c < 3; ++c) {
            out.irradiance += std::fabs(irradiance[c] - double(live[n][4 + c]));
            out.flux += std::fabs(flux[c] - double(live[n][c]));
            out.all += double(live[n][4 + c]), light += irradiance[c];
        }
    }
    out.irradiance /= light, out.flux /= light, out.all /= light;
    return out;
}

/// A layer near the bottom, a row for each sun: live, baked, and fifty times the difference over the mean.
/// docs/runtime.md shows it: PHOTIC_PICTURE=docs/pictures/live_bake_difference.png names the file that is written.
struct DifferencePicture {
    static constexpr int kPixels = 4, kLayer = 4, kGap = 8, kPanel = kSide * kPixels;
    Image image{3 * kPanel + 2 * kGap, 0, 3, {}};

    void addRow(const Volume& baked, const std::vector<std::array<float, 4>>& positions,
                const std::vector<test::GpuSample>& live) {
        const int top = image.height == 0 ? 0 : image.height + kGap;
        image.height = top + kPanel;
        image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3, 1.0F);
        const auto at = [](int i, int j) { return static_cast<std::size_t>((kLayer * kSide + j) * kSide + i); };
        const auto bakedAt = [&](std::size_t n) {
            const auto& p = positions[n];
            return baked.sample({double(p[0]), double(p[1]), double(p[2])}).irradiance.x;
        };
        double mean = 0;
        for (int n = 0; n < kSide * kSide; ++n) mean += bakedAt(at(n % kSide, n / kSide)) / (kSide * kSide);
        for (int y = 0; y < kPanel; ++y)
            for (int x = 0; x < 3 * kPanel; ++x) {
                const std::size_t n = at(x % kPanel / kPixels, kSide - 1 - y / kPixels);
                const double ours = double(live[n][4]), theirs = bakedAt(n);
                const int panel = x / kPanel;
                const auto colour = panel == 2
                                        ? colourOf(ColourMap::BlueRed, 0.5 + 25 * (ours - theirs) / mean)
                                        : colourOf(ColourMap::Magma, (panel == 0 ? ours : theirs) / (2.5 * mean));
                for (int c = 0; c < 3; ++c)
                    image.at(x + panel * kGap, top + y, c) = colour[static_cast<std::size_t>(c)];
            }
    }
};

TEST_F(LiveBakes, AreTheBakersOwn) {
    struct Case {
        double disc;
        const char *irradiance, *medium;
        WaterLight light;
        double allowed;
    };
    WaterLight tinted = sun();
    tinted.irradiance[1] = 900, tinted.irradiance[2] = 700;
    tinted.extinction[0] = 0.35F, tinted.extinction[1] = 0.07F, tinted.extinction[2] = 0.02F;
    DifferencePicture picture;
    const Case cases[] = {
        {0, "1000.0", "", sun(), 0.001},
        {0.53, "1000.0", "", sun(), 0.0015},
        {2, "1000.0", "", sun(), 0.0015},
        {0.53, "[1000.0, 900.0, 700.0]", "[medium]\nabsorption = [0.35, 0.07, 0.02]\n", tinted, 0.0015}};
    for (const Case& c : cases) {
        constexpr int kMesh = 192;
        const Volume baked = test::asGameVolume(test::bake(sceneText(c.disc, c.irradiance, c.medium, kMesh)).volume,
                                                NvdbPrecision::Float);
        Water water(*gpu_, kMesh, c.light);
        water.set(waves);
        auto bake = LiveBake::create(*gpu_, box(static_cast<float>(c.disc)));
        ASSERT_TRUE(bake.ok()) << bake.error().message;
        const Status done = bake->update(water.live);
        ASSERT_TRUE(done.ok()) << done.error().message;
        const auto positions = centres();
        GlslOptions glsl;
        glsl.filter = Filter::Exact;
        const auto live = sample(bake->volume(), positions, glsl);
        const Beside beside = compared(baked, positions, live);
        RecordProperty("relative_l1_" + std::to_string(&c - cases), std::to_string(beside.irradiance));
        EXPECT_LT(beside.irradiance, c.allowed) << c.disc;
        EXPECT_LT(beside.flux, c.allowed) << c.disc;
        EXPECT_NEAR(beside.all, 1, 1e-4) << c.disc;
        std::printf("live bake, %.2f degrees: relative L1 of irradiance %.5f, of flux %.5f\n", c.disc,
                    beside.irradiance, beside.flux);
        picture.addRow(baked, positions, live);
    }
    if (const char* path = std::getenv("PHOTIC_PICTURE")) writePng(path, picture.image);
}

/// Access to what is not in the public header.
struct Opened {
    explicit Opened(const GlFunctions& of) : gl(of) {}

    /// Downward flux through each layer, before halves and blur [m^2 of unfocused light].
    std::vector<double> layers(const LiveBake::Impl& bake) const {
        std::vector<double> out(static_cast<std::size_t>(bake.options.voxels[2]), 0);
        const auto count = static_cast<std::size_t>(bake.sumCount(false));
        gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, bake.sums);
        const auto* sums = static_cast<const std::int32_t*>(
            gl.MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(4 * count), GL_MAP_READ_BIT));
        EXPECT_NE(sums, nullptr);
        const std::size_t a_layer = count / out.size();
        for (std::size_t n = 2; sums && n < count; n += 4)
            out[n / a_layer] -= sums[n] / 262144.0 * double(bake.voxel(0)) * double(bake.voxel(1));
        gl.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
        gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, 0);
        return out;
    }

    /// Power that enters the water, by its triangles [m^2 of unfocused light].
    double entering(const LiveWater::Impl& water) const {
        const auto columns = static_cast<std::size_t>(water.mesh_columns),
                   rows = static_cast<std::size_t>(water.mesh_rows);
        std::vector<float> starts(4 * columns * rows);
        gl.BindTexture(GL_TEXTURE_2D, water.ray_starts);
        gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, starts.data());
        gl.BindTexture(GL_TEXTURE_2D, 0);
        double sum = 0;
        const auto power = [&](std::size_t i, std::size_t j) { return double(starts[4 * (j * columns + i) + 3]); };
        for (std::size_t j = 0; j + 1 < rows; ++j)
            for (std::size_t i = 0; i + 1 < columns; ++i)
                sum += (2 * power(i, j) + 2 * power(i + 1, j + 1) + power(i + 1, j) + power(i, j + 1)) / 6;
        return sum * double(water.water.size[0] / float(water.columns)) *
               double(water.water.size[1] / float(water.rows));
    }

    const GlFunctions& gl;
};

/// A ring of waves that spreads from the middle.
auto ring(double time) {
    return [time](double x, double y) {
        const double r = std::hypot(x, y) - 0.5 * time;
        return 0.02 * std::exp(-80 * r * r) * std::cos(25 * r);
    };
}

// Each layer below the surface carries all of the light that enters, in every frame of a ring that spreads.
TEST_F(LiveBakes, LoseNoLightWhileARingSpreads) {
    Water water(*gpu_, 96, sun());
    auto bake = LiveBake::create(*gpu_, box(0.53F));
    ASSERT_TRUE(bake.ok()) << bake.error().message;
    const Opened opened(gl_);
    double worst = 0, brightest = 0;
    for (int frame = 0; frame < 8; ++frame) {
        water.set(ring(0.1 * frame));
        ASSERT_TRUE(bake->update(water.live).ok());
        const double all = opened.entering(water.live.impl());
        const auto layers = opened.layers(bake->impl());
        for (std::size_t k = 0; k + 6 < layers.size(); ++k) {  // the last ones are cut by the surface
            worst = std::max(worst, std::fabs(layers[k] / all - 1));
            brightest = std::max(brightest, layers[k]);
        }
    }
    RecordProperty("worst_layer", std::to_string(worst));
    EXPECT_GT(brightest, 1);
    EXPECT_LT(worst, 1e-5);
}

// The same water is the same bits, whatever was baked between: a pool at rest does not flicker. And slow water changes
// slowly: half the step, half the change.
TEST_F(LiveBakes, DoNotFlicker) {
    Water water(*gpu_, 96, sun());
    auto bake = LiveBake::create(*gpu_, box(0.53F));
    ASSERT_TRUE(bake.ok()) << bake.error().message;
    const auto positions = centres();
    GlslOptions glsl;
    glsl.filter = Filter::Exact;
    const auto at = [&](double time) {
        water.set(ring(time));
        EXPECT_TRUE(bake->update(water.live).ok());
        return sample(bake->volume(), positions, glsl);
    };
    const auto change = [](const std::vector<test::GpuSample>& a, const std::vector<test::GpuSample>& b) {
        double sum = 0;
        for (std::size_t n = 0; n < a.size(); ++n) sum += std::fabs(double(a[n][3]) - double(b[n][3]));
        return sum;
    };
    const auto first = at(0.4), later = at(0.404), half = at(0.402), again = at(0.4);
    EXPECT_EQ(first, again);
    EXPECT_GT(change(first, later), 0);
    EXPECT_NEAR(change(first, half) / change(first, later), 0.5, 0.05);
    // Summed over frames: between the same two moments, twice as many frames change as much in all. What flickers would
    // change by as much from each to the next, and twice as much in all.
    const auto changes = [&](int frames) {
        auto before = at(0.4);
        double sum = 0;
        for (int n = 1; n <= frames; ++n) {
            const auto now = at(0.4 + 0.02 * n / frames);
            sum += change(before, now);
            before = now;
        }
        return sum;
    };
    const double few = changes(4), many = changes(8);
    RecordProperty("many_frames_over_few", std::to_string(many / few));
    EXPECT_NEAR(many / few, 1, 0.05);
}

TEST_F(LiveBakes, SayWhatTheyCannot) {
    LiveBakeOptions options = box(0.53F);
    options.voxels = {0, 8, 8};
    EXPECT_EQ(LiveBake::create(*gpu_, options).error().code, ErrorCode::Limit);
    options = box(0.53F), options.max[2] = options.min[2];
    EXPECT_EQ(LiveBake::create(*gpu_, options).error().code, ErrorCode::Usage);
    options = box(40);
    EXPECT_EQ(LiveBake::create(*gpu_, options).error().code, ErrorCode::Usage);
    // Water without heights; a box that is not the rectangle of periodic water; more sums than a storage block holds.
    auto bake = LiveBake::create(*gpu_, box(0.53F));
    ASSERT_TRUE(bake.ok());
    Water water(*gpu_, 32, sun());
    EXPECT_EQ(bake->update(water.live).error().code, ErrorCode::Usage);
    water.heights.size[0] = 1;
    water.set(waves);
    const Status odd = bake->update(water.live);
    ASSERT_FALSE(odd.ok());
    EXPECT_NE(odd.error().message.find("rectangle"), std::string::npos);
    water.heights.outside = WaterOutside::Flat;
    water.set(waves);
    EXPECT_TRUE(bake->update(water.live).ok());
    // Sums of 16 bytes a voxel.
    const int side = static_cast<int>(std::cbrt(static_cast<double>(gl_.largest_storage_block) / 16)) + 2;
    options = box(0), options.voxels = {side, side, side};
    auto large = LiveBake::create(*gpu_, options);
    ASSERT_TRUE(large.ok()) << large.error().message;
    const Status full = large->update(water.live);
    ASSERT_FALSE(full.ok());
    EXPECT_EQ(full.error().code, ErrorCode::Limit);
    EXPECT_NE(full.error().message.find("caustic map"), std::string::npos);
}

TEST_F(LiveBakes, LeaveGlAsItWas) {
    GLuint texture = 0, buffer = 0;
    gl_.GenTextures(1, &texture);
    gl_.BindTexture(GL_TEXTURE_3D, texture);
    gl_.TexStorage3D(GL_TEXTURE_3D, 1, GL_RGBA16F, 4, 4, 4);
    gl_.BindImageTexture(0, texture, 0, GL_TRUE, 0, GL_READ_ONLY, GL_RGBA16F);
    gl_.GenBuffers(1, &buffer);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffer);
    Water water(*gpu_, 32, sun());
    water.set(waves);
    auto bake = LiveBake::create(*gpu_, box(0.53F));
    ASSERT_TRUE(bake.ok() && bake->update(water.live).ok());
    const auto integer = [&](GLenum name, GLuint index) {
        GLint value = -1;
        gl_.GetIntegeri_v(name, index, &value);
        return value;
    };
    EXPECT_EQ(integer(GL_IMAGE_BINDING_NAME, 0), static_cast<GLint>(texture));
    EXPECT_EQ(integer(GL_IMAGE_BINDING_ACCESS, 0), GL_READ_ONLY);
    EXPECT_EQ(integer(GL_SHADER_STORAGE_BUFFER_BINDING, 1), static_cast<GLint>(buffer));
    gl_.BindImageTexture(0, 0, 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA16F);
    gl_.DeleteTextures(1, &texture);
    gl_.DeleteBuffers(1, &buffer);
}

}  // namespace
}  // namespace photic::runtime
