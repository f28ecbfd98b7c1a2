// SPDX-License-Identifier: Apache-2.0
// Light in BC6H: our encoder's blocks as the graphics driver decodes them, and volumes of them on their way to a GPU.
#include "bake/file/compressed_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "bake/file/nvdb.h"
#include "bake/file/runtime_size.h"
#include "photic/gpu_upload.h"
#include "photic/volume_bytes.h"
#include "tests/file/file_test_support.h"
#include "tests/runtime/gpu_fixture.h"

namespace photic::runtime {
namespace {

using Texels = std::array<std::array<float, 3>, 16>;

/// Light of one colour, whose brightness within a block spreads by `spread` (of its logarithm).
Bc6hTexels block(std::mt19937& random, float spread, bool with_sign) {
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> unit(0, 1);
    Bc6hTexels out;
    const float brightness = std::exp(2 * normal(random));
    std::array<float, 3> colour{};
    for (float& c : colour) c = (0.3F + unit(random)) * (with_sign && unit(random) < 0.3F ? -1.0F : 1.0F);
    for (auto& texel : out.rgb) {
        const float value = brightness * std::exp(spread * normal(random));
        for (std::size_t c = 0; c < 3; ++c) texel[c] = value * colour[c];
    }
    return out;
}

class Bc6h : public test::WithGpu {
protected:
    /// Blocks side by side as the driver reads them.
    std::vector<Texels> decodedByDriver(const std::vector<Bc6hBlock>& blocks, GLenum format) {
        const auto width = static_cast<GLsizei>(4 * blocks.size());
        GLuint texture = 0;
        gl_.GenTextures(1, &texture);
        gl_.BindTexture(GL_TEXTURE_3D, texture);
        gl_.TexStorage3D(GL_TEXTURE_3D, 1, format, width, 4, 1);
        gl_.CompressedTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, width, 4, 1, format,
                                    static_cast<GLsizei>(16 * blocks.size()), blocks.data());
        std::vector<float> pixels(static_cast<std::size_t>(width) * 4 * 3);
        gl_.GetTexImage(GL_TEXTURE_3D, 0, GL_RGB, GL_FLOAT, pixels.data());
        gl_.DeleteTextures(1, &texture);
        std::vector<Texels> out(blocks.size());
        for (std::size_t b = 0; b < blocks.size(); ++b)
            for (std::size_t n = 0; n < 16; ++n)
                std::copy_n(pixels.data() + 3 * ((n / 4) * static_cast<std::size_t>(width) + 4 * b + n % 4), 3,
                            out[b][n].begin());
        return out;
    }
};

TEST_F(Bc6h, IsDecodedByTheDriverAsByUs) {
    std::mt19937 random(4);
    for (const Bc6hSign sign : {Bc6hSign::Unsigned, Bc6hSign::Signed}) {
        std::vector<Bc6hBlock> blocks;
        for (int n = 0; n < 500; ++n) {
            // From alike to many powers of two apart: all four modes.
            Bc6hTexels texels =
                block(random, 0.002F * std::pow(1.02F, static_cast<float>(n)), sign == Bc6hSign::Signed);
            if (n % 7 == 0) texels.used = 0x1111;
            blocks.push_back(encodeBc6h(texels, sign));
        }
        const auto driver = decodedByDriver(blocks, sign == Bc6hSign::Signed ? GL_COMPRESSED_RGB_BPTC_SIGNED_FLOAT
                                                                             : GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT);
        std::array<int, 32> modes{};
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            ++modes[blocks[b][0] & 31U];
            const auto ours = decodeBc6h(blocks[b], sign);
            for (std::size_t n = 0; n < 16; ++n)
                for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(driver[b][n][c], ours[n][c]) << b << " " << n << " " << c;
        }
        for (const std::size_t mode : {0x03U, 0x07U, 0x0bU, 0x0fU}) EXPECT_GT(modes[mode], 0) << mode;
    }
}

TEST_F(Bc6h, IsAsNearAsSixteenPlacesAllow) {
    // Even places over a spread s reach four of it: off by a 60th of that at most, a quarter of it on average.
    for (const Bc6hSign sign : {Bc6hSign::Unsigned, Bc6hSign::Signed}) {
        for (const auto& [spread, allowed] :
             {std::pair{0.0F, 0.0007}, {0.02F, 0.003}, {0.1F, 0.007}, {0.5F, 0.03}, {1.0F, 0.06}}) {
            std::mt19937 random(9);
            double off = 0, all = 0;
            for (int n = 0; n < 400; ++n) {
                const Bc6hTexels texels = block(random, spread, sign == Bc6hSign::Signed);
                const auto decoded = decodeBc6h(encodeBc6h(texels, sign), sign);
                for (std::size_t i = 0; i < 16; ++i)
                    for (std::size_t c = 0; c < 3; ++c) {
                        off += std::fabs(double(decoded[i][c]) - double(texels.rgb[i][c]));
                        all += std::fabs(double(texels.rgb[i][c]));
                    }
            }
            EXPECT_LT(off / all, allowed) << spread;
        }
    }
    // What does not count costs nothing: four texels get a place each.
    Bc6hTexels few;
    few.used = 0x1111;
    for (std::size_t i = 0; i < 16; ++i) few.rgb[i].fill(i % 4 == 0 ? 1.0F + 0.2F * static_cast<float>(i) : 3000.0F);
    const auto decoded = decodeBc6h(encodeBc6h(few, Bc6hSign::Unsigned), Bc6hSign::Unsigned);
    for (std::size_t i = 0; i < 16; i += 4) EXPECT_NEAR(decoded[i][0], few.rgb[i][0], 0.04F * few.rgb[i][0]);
    // Nothing that is no light comes out of what is none.
    Bc6hTexels odd;
    odd.rgb[3] = {std::nanf(""), 1e30F, -5.0F};
    for (const auto& texel : decodeBc6h(encodeBc6h(odd, Bc6hSign::Unsigned), Bc6hSign::Unsigned))
        for (const float v : texel) EXPECT_TRUE(v >= 0 && v <= 65504);
}

/// Whether light is there: all of a box, or two balls at its ends.
bool everywhere(const glm::ivec3&) { return true; }
bool inBlobs(const glm::ivec3& v) {
    return glm::length(glm::dvec3(v) - glm::dvec3(6, 9, 2)) < 7 ||
           glm::length(glm::dvec3(v) - glm::dvec3(53, 39, 33)) < 7;
}

LightVolume source(bool coloured, bool sparse) {
    const GridFrame frame = leaningFrame({-3, 2, -11}, {61, 47, 41}, 1.0 / 64);
    return sparse ? testVolume(frame, coloured, inBlobs) : testVolume(frame, coloured, everywhere);
}

Volume written(const LightVolume& volume, NvdbCodec codec = NvdbCodec::Blosc) {
    const TemporaryFolder folder;
    writeNvdb(folder / "a.nvdb", volume, {NvdbPrecision::Half, codec});
    auto loaded = loadVolume(folder / "a.nvdb");
    if (!loaded) {
        ADD_FAILURE() << loaded.error().message;
        return {};
    }
    return *loaded;
}

std::vector<std::array<float, 4>> positions(const Volume& volume) { return test::randomPositions(volume, 20000, 3); }

/// Mean difference of GPU look-ups from the CPU's, over the mean irradiance.
double meanDifference(const Volume& volume, const std::vector<std::array<float, 4>>& at,
                      const std::vector<test::GpuSample>& samples) {
    double off = 0, all = 0;
    for (std::size_t n = 0; n < at.size(); ++n) {
        const Light light = volume.sample({double(at[n][0]), double(at[n][1]), double(at[n][2])});
        const double cpu[6] = {light.flux.x,       light.flux.y,       light.flux.z,
                               light.irradiance.x, light.irradiance.y, light.irradiance.z};
        for (std::size_t c = 0; c < 6; ++c) off += std::fabs(cpu[c] - double(samples[n][c < 3 ? c : c + 1])) / 6;
        all += (light.irradiance.x + light.irradiance.y + light.irradiance.z) / 3;
    }
    return off / all;
}

class CompressedLight : public test::WithGpu {};

TEST_F(CompressedLight, IsReadAlikeByGpuAndCpuFromAQuarterOfTheBytes) {
    Monitor monitor;
    for (const bool coloured : {false, true}) {
        for (const bool sparse : {false, true}) {
            const LightVolume halves = source(coloured, sparse);
            LightVolume blocks = source(coloured, sparse);
            compressLight(blocks, monitor);
            EXPECT_EQ(blocks.compressed[0]->one_box, !sparse);
            const Volume volume = written(blocks), before = written(halves);
            EXPECT_EQ(volume.litVoxelCount(), before.litVoxelCount());
            GpuVolume gpu = upload(volume, {}), as_halves = upload(volume, {.texels = runtime::Texels::Halves});
            EXPECT_TRUE(gpu.info().bc6h);
            EXPECT_FALSE(as_halves.info().bc6h);
            EXPECT_EQ(gpu.info().layout, sparse ? Layout::Atlas : Layout::Dense);
            // The budget counts what the library takes.
            EXPECT_EQ(static_cast<std::int64_t>(gpu.info().bytes), runtimeSize(blocks, GameTexels::Bc6h).bytes);
            const double least = (sparse ? 2.2 : 3.8) * (coloured ? 2 : 1);
            EXPECT_LT(static_cast<double>(gpu.info().bytes) * least, static_cast<double>(as_halves.info().bytes));
            // Smooth light loses little, and both look-ups read the same; bricks differ by the voxel that they share.
            const auto at = positions(volume);
            for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
                GlslOptions glsl;
                glsl.filter = filter;
                const auto samples = sample(gpu, at, glsl);
                EXPECT_LT(meanDifference(volume, at, samples), (sparse ? 0.002 : 0.0005) + filterError());
                EXPECT_LT(meanDifference(before, at, samples), 0.006 + filterError());
                EXPECT_LT(meanDifference(volume, at, sample(as_halves, at, glsl)), 0.0005 + filterError());
            }
            // In parts, and as bytes for other engines: the same.
            auto parts = GpuUpload::start(*gpu_, volume, {});
            ASSERT_TRUE(parts.ok());
            auto sent = parts->take();
            ASSERT_TRUE(sent.ok()) << sent.error().message;
            EXPECT_TRUE(sent->info().bc6h);
            EXPECT_EQ(sample(*sent, at), sample(gpu, at));
            const auto bytes = packVolume(volume);
            ASSERT_TRUE(bytes.ok());
            EXPECT_EQ(bytes->info.bytes,
                      bytes->light.texels.size() + bytes->colour.texels.size() + bytes->pages.texels.size());
        }
    }
}

TEST_F(CompressedLight, OfBothLobesAndOfLightThatRepeats) {
    Monitor monitor;
    LightVolume two = source(false, true);
    two.second.emplace(two.field.neededPtr(), two.field.channels());
    LightField& second = *two.second;
    for (int slot = 0; slot < second.leafCount(); slot += 2) {
        if (two.field.state(slot) == LeafState::Empty) continue;
        float* to = second.makeDense(slot);
        for (int i = 0; i < 512; ++i)
            if (two.field.dense(slot)[i] > 0) to[i] = 300, to[3 * 512 + i] = 280;
    }
    two.metadata["lobe_axis"] = "[0,0,-1]";
    compressLight(two, monitor);
    ASSERT_TRUE(two.compressed[1]);
    const Volume lobes = written(two);
    ASSERT_TRUE(lobes.hasSecondLobe());
    GpuVolume gpu = upload(lobes, {});
    EXPECT_TRUE(gpu.info().bc6h);
    ASSERT_TRUE(gpu.secondLobe());
    EXPECT_TRUE(gpu.secondLobe()->info().bc6h);
    const auto at = positions(lobes.secondLobe());
    EXPECT_LT(meanDifference(lobes.secondLobe(), at, sample(*gpu.secondLobe(), at)), 0.002 + filterError());

    // 18 voxels a period: no whole number of blocks.
    LightVolume sea = testVolume(straightFrame({5, -7, 0}, {23, 11, 9}, 1.0 / 16), true);
    sea.metadata["period"] = "[1.125,1.125,0]";
    compressLight(sea, monitor);
    EXPECT_TRUE(sea.compressed[0]->one_box);
    const Volume repeats = written(sea);
    GpuVolume tile = upload(repeats, {});
    EXPECT_TRUE(tile.info().bc6h);
    const auto far = positions(repeats);
    for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
        GlslOptions glsl;
        glsl.filter = filter;
        EXPECT_LT(meanDifference(repeats, far, sample(tile, far, glsl)), 0.0005 + filterError());
    }
}

TEST_F(CompressedLight, IsHalvesWhereTheGpuKnowsNoBlocks) {
    Monitor monitor;
    LightVolume blocks = source(false, true);
    compressLight(blocks, monitor);
    const Volume volume = written(blocks);
    GlFunctions poor = gpu_->gl();
    UploadOptions options;
    EXPECT_TRUE(packVolume(volume, options)->info.bc6h);
    options.texels = runtime::Texels::Halves;
    EXPECT_FALSE(packVolume(volume, options)->info.bc6h);
    options = {};
    options.layout = Layout::Buffer;  // no textures, no blocks
    EXPECT_FALSE(packVolume(volume, options)->info.bc6h);
    // What has no room for halves at its resolution has room for blocks.
    options = {};
    options.budget = upload(volume, {}).info().bytes;
    EXPECT_EQ(upload(volume, options).info().coarsened, 0);
    options.texels = runtime::Texels::Halves;
    EXPECT_GT(upload(volume, options).info().coarsened, 0);
}

TEST_F(CompressedLight, ThatIsDamagedIsRefusedOrHarmless) {
    Monitor monitor;
    LightVolume blocks = testVolume(straightFrame({0, 0, 0}, {20, 20, 20}, 0.1), false, inBlobs);
    compressLight(blocks, monitor);
    const TemporaryFolder folder;
    writeNvdb(folder / "a.nvdb", blocks, {NvdbPrecision::Half, NvdbCodec::None});
    const std::string sound = bytesOf(folder / "a.nvdb");
    const std::size_t begin = sound.find("PhoticB6");
    ASSERT_NE(begin, std::string::npos);
    int refused = 0;
    for (std::size_t at = 0; at < 64 + 64; ++at) {
        for (const char flip : {'\x01', '\x80'}) {
            std::string bytes = sound;
            bytes[begin + at] = static_cast<char>(bytes[begin + at] ^ flip);
            const auto read = readVolume(bytes.data(), bytes.size());
            if (!read) {
                ++refused;
                EXPECT_EQ(read.error().code, ErrorCode::Format) << at;
            } else {
                EXPECT_TRUE(packVolume(*read).ok());
            }
        }
    }
    EXPECT_GT(refused, 60);
}

TEST(CompressedLightFile, NeedsDirections) {
    Monitor monitor;
    const GridFrame frame = straightFrame({0, 0, 0}, {8, 8, 8}, 0.1);
    LightVolume volume{LightField(std::make_shared<NeededVoxels>(NeededVoxels::everything(frame)), {1, false}),
                       1,
                       true,
                       false,
                       {},
                       {}};
    EXPECT_THROW(compressLight(volume, monitor), photic::Error);
}

}  // namespace
}  // namespace photic::runtime
