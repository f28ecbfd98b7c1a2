// SPDX-License-Identifier: Apache-2.0
// The GPU samples what the CPU samples, in every layout, and falls back as it says.
#include <algorithm>
#include <cmath>

#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/wrapped_gl.h"

namespace photic::runtime {
namespace {

using test::GpuSample;
using test::NvdbSpec;

/// A sparse field: blobs of light in the dark, so that the atlas has seams, empty pages and borders.
bool inBlob(int i, int j, int k) {
    const auto near = [&](int x, int y, int z, int r) {
        return (i - x) * (i - x) + (j - y) * (j - y) + (k - z) * (k - z) < r * r;
    };
    return near(4, 4, 4, 10) || near(40, 20, 33, 14) || near(15, 55, 50, 9) || (i + j) / 2 == 30;
}

NvdbSpec sparseSpec(bool coloured) {
    NvdbSpec spec;
    spec.min = {-7, -3, 2};
    spec.max = {60, 62, 61};
    spec.values = test::swirl;
    spec.active = inBlob;
    spec.coloured = coloured;
    // Sheared, away from the origin, not one unit.
    spec.world_from_index = {0.03, 0, 0.004, 0, 0.03, -0.002, 0, 0, 0.025};
    spec.origin_world = {3.0, -11.0, -1.5};
    spec.json = R"({"reference_irradiance": 2.0})";
    return spec;
}

NvdbSpec constantsSpec() {
    // Large constant parts share one brick.
    NvdbSpec spec = sparseSpec(false);
    spec.active = {};
    spec.values = [](int i, int, int) -> test::LightValues {
        return i < 24 ? test::LightValues{0, 0, -1, 1} : test::LightValues{0, -2, 0, 2};
    };
    return spec;
}

/// Largest difference between GPU and CPU over the largest value.
double difference(const Volume& volume, const std::vector<std::array<float, 4>>& positions,
                  const std::vector<GpuSample>& samples) {
    double worst = 0, largest = 0;
    for (std::size_t n = 0; n < positions.size(); ++n) {
        const auto& p = positions[n];
        const Light light = volume.sample({double(p[0]), double(p[1]), double(p[2])});
        const double cpu[6] = {light.flux.x,       light.flux.y,       light.flux.z,
                               light.irradiance.x, light.irradiance.y, light.irradiance.z};
        const float gpu[6] = {samples[n][0], samples[n][1], samples[n][2], samples[n][4], samples[n][5], samples[n][6]};
        for (int c = 0; c < 6; ++c) {
            const double d = std::fabs(cpu[c] - static_cast<double>(gpu[c]));
            if (!(d <= worst)) worst = d;  // NaN counts
            largest = std::max(largest, std::fabs(cpu[c]));
        }
    }
    return worst / largest;
}

struct Way {
    Layout layout;
    Filter filter;
    bool coloured;
};

class TwoLevels : public test::WithGpu {};

// Wide and narrow voxels in one atlas: what the CPU reads from narrow ones alone, across all seams.
TEST_F(TwoLevels, SampleAsTheCpuDoes) {
    for (const bool coloured : {false, true}) {
        NvdbSpec spec = sparseSpec(coloured);
        spec.active = {};
        const Volume volume =
            test::makeVolume(test::twoLevels(spec, [](int x, int y, int z) { return (2 * x + y + z) % 3 != 0; }));
        const auto positions = test::randomPositions(volume, 100000, 4);
        for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
            for (const Layout layout : {Layout::Automatic, Layout::Buffer}) {
                UploadOptions options;
                options.layout = layout, options.filter = filter;
                GpuVolume gpu = upload(volume, options);
                EXPECT_GT(gpu.info().coarse_bricks, 10u);
                GlslOptions glsl;
                glsl.filter = filter;
                EXPECT_LT(difference(volume, positions, sample(gpu, positions, glsl)), filterLimit());
            }
        }
    }
}

// The same where light repeats, across seams and some periods away.
TEST_F(TwoLevels, RepeatAsOnTheCpu) {
    NvdbSpec spec;
    spec.min = {-32, 0, 3};
    spec.max = {31, 47, 70};
    spec.values = test::swirl;
    spec.world_from_index = {0.05, 0, 0, 0, 0.05, 0, 0, 0, 0.05};
    NvdbSpec two =
        test::twoLevels(spec, [](int x, int y, int z) { return (2 * x + y + z) % 3 != 0; }, {true, true, false});
    two.json.insert(two.json.size() - 1, ", \"period\": [3.2, 2.4, 0]");
    const Volume volume = test::makeVolume(two);
    auto positions = test::randomPositions(volume, 100000, 5);
    for (std::size_t n = 0; n < positions.size(); ++n) {
        positions[n][0] += 3.2F * static_cast<float>(static_cast<int>(n % 3) - 1);
        if (n % 4 == 0) positions[n][1] = 2.4F * static_cast<float>(n % 3) + 0.1F * positions[n][0];
    }
    for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
        for (const Layout layout : {Layout::Atlas, Layout::Buffer}) {
            UploadOptions options;
            options.layout = layout, options.filter = filter;
            GpuVolume gpu = upload(volume, options);
            EXPECT_GT(gpu.info().coarse_bricks, 10U);
            GlslOptions glsl;
            glsl.filter = filter;
            EXPECT_LT(difference(volume, positions, sample(gpu, positions, glsl)), filterLimit());
        }
    }
}

class EveryLayout : public test::WithGpu, public testing::WithParamInterface<Way> {};

TEST_P(EveryLayout, SamplesAsTheCpuDoes) {
    const Way way = GetParam();
    const Volume volume = test::makeVolume(sparseSpec(way.coloured));
    UploadOptions options;
    options.layout = way.layout;
    options.filter = way.filter;
    GpuVolume gpu = upload(volume, options);
    ASSERT_EQ(gpu.info().layout, way.layout);
    // 1e-5 of the largest value when weighted in float; the hardware's weights cost more.
    const double limit = way.filter == Filter::Exact ? 1e-5 : filterLimit();
    GlslOptions glsl;
    glsl.filter = way.filter;
    const auto random = test::randomPositions(volume, 1000000, 3);
    EXPECT_LT(difference(volume, random, sample(gpu, random, glsl)), limit);
    const auto coherent = test::coherentPositions(volume, 1000000);
    EXPECT_LT(difference(volume, coherent, sample(gpu, coherent, glsl)), limit);
}

TEST_P(EveryLayout, BrickBordersAndVoxelCentresAreExact) {
    const Way way = GetParam();
    const Volume volume = test::makeVolume(sparseSpec(way.coloured));
    UploadOptions options;
    options.layout = way.layout;
    options.filter = way.filter;
    GpuVolume gpu = upload(volume, options);
    GlslOptions glsl;
    glsl.filter = way.filter;
    // On, just before and just behind every brick's border and the box's ends, along each axis; half a voxel off would
    // show as another voxel's value.
    std::vector<std::array<float, 4>> positions;
    const VoxelBox box = volume.litVoxels();
    const Vec3 o = volume.voxelCentre(0, 0, 0), x = volume.voxelCentre(1, 0, 0), z = volume.voxelCentre(0, 0, 1);
    for (int i = box.min[0] - 2; i <= box.max[0] + 2; ++i) {
        for (int k = box.min[2] - 2; k <= box.max[2] + 2; k += 3) {
            for (const double off : {-0.01, 0.0, 0.01, 0.5}) {
                const Vec3 c = volume.voxelCentre(i, 20, k);
                positions.push_back({static_cast<float>(c.x + off * ((x.x - o.x) + (z.x - o.x))),
                                     static_cast<float>(c.y), static_cast<float>(c.z + off * (z.z - o.z)), 0});
            }
        }
    }
    EXPECT_LT(difference(volume, positions, sample(gpu, positions, glsl)),
              way.filter == Filter::Exact ? 1e-5 : filterLimit());
}

TEST_P(EveryLayout, PeriodicLightRepeats) {
    const Way way = GetParam();
    NvdbSpec spec;
    spec.min = {3, -2, 0};
    spec.max = {22, 34, 12};  // 20 and 37 voxels: neither a multiple of 8
    spec.values = test::swirl;
    spec.coloured = way.coloured;
    spec.active = [](int i, int j, int) { return (i == 3 || i > 9) && j != 5; };
    spec.world_from_index = {0.05, 0, 0, 0, 0.05, 0, 0, 0, 0.05};
    spec.json = R"({"period": [1.0, 1.85, 0]})";
    const Volume volume = test::makeVolume(spec);
    UploadOptions options;
    options.layout = way.layout;
    options.filter = way.filter;
    GpuVolume gpu = upload(volume, options);
    GlslOptions glsl;
    glsl.filter = way.filter;
    auto positions = test::randomPositions(volume, 100000, 4);
    for (std::size_t n = 0; n < positions.size(); ++n) {
        positions[n][0] += static_cast<float>(static_cast<int>(n % 5) - 2);
        positions[n][1] += 1.85F * static_cast<float>(static_cast<int>(n % 3) - 1);
    }
    // Farther from the middle, float leaves fewer bits for the fraction.
    EXPECT_LT(difference(volume, positions, sample(gpu, positions, glsl)),
              way.filter == Filter::Exact ? 3e-5 : filterLimit());
}

INSTANTIATE_TEST_SUITE_P(
    All, EveryLayout,
    testing::Values(Way{Layout::Atlas, Filter::Hardware, false}, Way{Layout::Atlas, Filter::Exact, false},
                    Way{Layout::Atlas, Filter::Exact, true}, Way{Layout::Dense, Filter::Hardware, true},
                    Way{Layout::Dense, Filter::Exact, false}, Way{Layout::Buffer, Filter::Exact, false},
                    Way{Layout::Buffer, Filter::Exact, true}));

using GpuVolumes = test::WithGpu;

TEST_F(GpuVolumes, LayoutFollowsTheFill) {
    EXPECT_EQ(upload(test::makeVolume(sparseSpec(false)), {}).info().layout, Layout::Atlas);
    NvdbSpec full;
    full.min = {0, 0, 0};
    full.max = {63, 63, 63};
    full.values = test::swirl;
    GpuVolume gpu = upload(test::makeVolume(full), {});
    EXPECT_EQ(gpu.info().layout, Layout::Dense);
    EXPECT_GT(gpu.info().fill, 0.7);
    // A dark voxel on either side of 64, 8 bytes each; the pages of 65 cells a side, 4 bytes each.
    EXPECT_EQ(gpu.info().bytes, 66U * 66U * 66U * 8U + 9U * 9U * 9U * 4U);
}

TEST_F(GpuVolumes, ConstantBricksAreShared) {
    UploadOptions options;
    options.layout = Layout::Atlas;
    const Volume volume = test::makeVolume(constantsSpec());
    GpuVolume gpu = upload(volume, options);
    // 9 x 9 x 8 pages or so; inside, each half has one value, and only borders differ.
    EXPECT_LT(gpu.info().bricks, 400U);
    const auto positions = test::randomPositions(volume, 100000, 5);
    EXPECT_LT(difference(volume, positions, sample(gpu, positions)), filterLimit());
}

TEST_F(GpuVolumes, EmptyIsEmpty) {
    GpuVolume gpu = upload(Volume(), {});
    const auto samples = sample(gpu, {{0, 0, 0, 0}, {1e30F, 0, 0, 0}, {std::nanf(""), 0, 0, 0}});
    for (const GpuSample& s : samples) {
        for (int c = 0; c < 7; ++c) EXPECT_EQ(s[static_cast<std::size_t>(c)], 0.0F);
    }
}

TEST_F(GpuVolumes, DarkAheadIsDark) {
    const Volume volume = test::makeVolume(sparseSpec(false));
    GpuVolume gpu = upload(volume, {});
    const auto positions = test::randomPositions(volume, 20000, 6);
    const auto samples = sample(gpu, positions);
    int skips = 0;
    for (std::size_t n = 0; n < positions.size(); ++n) {
        const double dark = static_cast<double>(samples[n][7]);
        if (dark <= 0) continue;
        ++skips;
        for (int i = 0; i < 16; ++i) {
            const double x = static_cast<double>(positions[n][0]) + dark * (i / 16.0);
            ASSERT_EQ(volume.sample({x, double(positions[n][1]), double(positions[n][2])}).irradiance.x, 0);
        }
    }
    EXPECT_GT(skips, 1000);
}

TEST_F(GpuVolumes, SmallTexturesGiveWayToBuffers) {
    const Volume volume = test::makeVolume(sparseSpec(false));
    UploadOptions options;
    options.largest_texture_3d = 32;
    GpuVolume gpu = upload(volume, options);
    EXPECT_EQ(gpu.info().layout, Layout::Buffer);
    const auto positions = test::randomPositions(volume, 100000, 7);
    EXPECT_LT(difference(volume, positions, sample(gpu, positions)), 1e-5);
}

TEST_F(GpuVolumes, BudgetCoarsensOrRefuses) {
    const Volume volume = test::makeVolume(sparseSpec(true));
    const std::uint64_t full = upload(volume, {}).info().bytes;
    UploadOptions options;
    options.budget = full / 3;
    GpuVolume coarse = upload(volume, options);
    EXPECT_EQ(coarse.info().coarsened, 1);
    EXPECT_LE(coarse.info().bytes, options.budget);
    // The mean light is the same.
    const auto positions = test::randomPositions(volume, 200000, 8);
    double sum = 0, coarse_sum = 0;
    const auto fine = sample(*std::make_unique<GpuVolume>(upload(volume, {})), positions),
               half = sample(coarse, positions);
    for (std::size_t n = 0; n < positions.size(); ++n) {
        sum += static_cast<double>(fine[n][3]);
        coarse_sum += static_cast<double>(half[n][3]);
    }
    EXPECT_NEAR(coarse_sum / sum, 1, 0.01);

    options.when_too_large = WhenTooLarge::Refuse;
    const auto refused = GpuVolume::upload(*gpu_, volume, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::Limit);
    EXPECT_NE(refused.error().message.find(std::to_string(options.budget)), std::string::npos)
        << refused.error().message;
}

TEST_F(GpuVolumes, OutOfMemoryFallsBack) {
    const Volume volume = test::makeVolume(sparseSpec(false));
    test::StarvedGl poor(context_->loader(), 20000);  // the page table fits, the light does not
    const auto starved = GpuContext::create(poor.loader());
    ASSERT_TRUE(starved.ok());
    auto gpu = GpuVolume::upload(*starved, volume);
    ASSERT_TRUE(gpu.ok()) << gpu.error().message;
    EXPECT_EQ(gpu->info().layout, Layout::Buffer);
    EXPECT_EQ(gpu->info().coarsened, 0);
    const auto positions = test::randomPositions(volume, 100000, 9);
    EXPECT_LT(difference(volume, positions, sample(*gpu, positions)), 1e-5);

    test::StarvedGl::largest = 0;
    const auto none = GpuVolume::upload(*starved, volume);
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::Memory) << none.error().message;
}

TEST_F(GpuVolumes, SurviveALostContext) {
    const Volume volume = test::makeVolume(sparseSpec(false));
    const auto positions = test::randomPositions(volume, 50000, 10);
    GpuVolume gpu = upload(volume, {});
    const auto before = sample(gpu, positions);
    gpu.abandon();
    open(test::GlApi::Core45);  // a new context; the old one's names are gone
    makeContext();
    gpu = upload(volume, {});
    EXPECT_EQ(sample(gpu, positions), before);
}

TEST_F(GpuVolumes, LeaveGlAsItWas) {
    GLuint texture = 0;
    gl_.GenTextures(1, &texture);
    gl_.ActiveTexture(GL_TEXTURE2);
    gl_.BindTexture(GL_TEXTURE_3D, texture);
    const GpuVolume gpu = upload(test::makeVolume(sparseSpec(false)), {});
    GLint bound = 0, active = 0;
    gl_.GetIntegerv(GL_TEXTURE_BINDING_3D, &bound);
    gl_.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    EXPECT_EQ(static_cast<GLuint>(bound), texture);
    EXPECT_EQ(active, GL_TEXTURE2);
    gl_.DeleteTextures(1, &texture);
}

TEST_F(GpuVolumes, PrefixAndBindingsAreTheGames) {
    const Volume volume = test::makeVolume(sparseSpec(false));
    GpuVolume gpu = upload(volume, {});
    GlslOptions glsl;
    glsl.prefix = "pond";
    glsl.first_texture = 5;
    glsl.first_buffer = 3;
    const auto positions = test::randomPositions(volume, 50000, 11);
    EXPECT_EQ(sample(gpu, positions, glsl), sample(gpu, positions));
}

TEST_F(GpuVolumes, WorkOnEs31) {
    open(test::GlApi::Es31);
    if (IsSkipped() || HasFatalFailure()) return;
    makeContext();
    const Volume volume = test::makeVolume(sparseSpec(true));
    const auto positions = test::randomPositions(volume, 50000, 12);
    for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
        UploadOptions options;
        options.layout = layout;
        GpuVolume gpu = upload(volume, options);
        EXPECT_LT(difference(volume, positions, sample(gpu, positions)), filterLimit());
    }
}

}  // namespace
}  // namespace photic::runtime
