// SPDX-License-Identifier: Apache-2.0
// What is loaded is what was written, and samples are trilinear, at any transform.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "photic/runtime.h"
#include "photic/runtime_gl.h"
#include "runtime/src/volume_data.h"
#include "tests/runtime/loaded_volume.h"

namespace photic::runtime {
namespace {

using test::LightValues;
using test::NvdbEncoding;
using test::NvdbSpec;

NvdbSpec swirlSpec(NvdbEncoding encoding, bool coloured) {
    NvdbSpec spec;
    spec.min = {-5, 3, -11};
    spec.max = {20, 17, 9};
    spec.values = test::swirl;
    spec.encoding = encoding;
    spec.coloured = coloured;
    return spec;
}

bool inside(const NvdbSpec& spec, const std::array<int, 3>& v) {
    for (std::size_t a = 0; a < 3; ++a) {
        if (v[a] < spec.min[a] || v[a] > spec.max[a]) return false;
    }
    return !spec.active || spec.active(v[0], v[1], v[2]);
}

/// Trilinear interpolation of the values as they were written, by definition.
std::array<double, 7> expected(const NvdbSpec& spec, const std::array<double, 3>& index) {
    std::array<double, 7> sums{};
    for (int corner = 0; corner < 8; ++corner) {
        std::array<int, 3> voxel;
        double weight = 1;
        for (std::size_t a = 0; a < 3; ++a) {
            const double low = std::floor(index[a]);
            const bool high = corner >> a & 1;
            voxel[a] = static_cast<int>(low) + high;
            weight *= high ? index[a] - low : 1 - (index[a] - low);
        }
        if (!inside(spec, voxel)) continue;
        const LightValues v = spec.values(voxel[0], voxel[1], voxel[2]);
        for (std::size_t c = 0; c < 7; ++c) sums[c] += weight * static_cast<double>(v[c]);
    }
    return sums;
}

struct Encoding {
    NvdbEncoding encoding;
    bool coloured;
    double tolerance;  ///< of the peak, 20: halves near it round by 1/128; Fp16 within a leaf's range to 2^-16 and then
                       ///< to a half
};

class Encodings : public testing::TestWithParam<Encoding> {};

TEST_P(Encodings, SamplesAreTrilinear) {
    const NvdbSpec spec = swirlSpec(GetParam().encoding, GetParam().coloured);
    const Volume volume = test::loaded(spec);
    EXPECT_EQ(volume.coloured(), GetParam().coloured);
    EXPECT_TRUE(volume.hasDirection());
    EXPECT_EQ(volume.litVoxelCount(), 26U * 15U * 21U);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 20000; ++n) {
        // Two voxels beyond the border too.
        std::array<double, 3> p;
        for (std::size_t a = 0; a < 3; ++a) p[a] = spec.min[a] - 2 + unit(random) * (spec.max[a] - spec.min[a] + 4);
        const auto e = expected(spec, p);
        const Light light = volume.sample({p[0], p[1], p[2]});
        const double tolerance = 20 * GetParam().tolerance;
        ASSERT_NEAR(light.flux.x, e[0], tolerance);
        ASSERT_NEAR(light.flux.y, e[1], tolerance);
        ASSERT_NEAR(light.flux.z, e[2], tolerance);
        ASSERT_NEAR(light.irradiance.x, GetParam().coloured ? e[4] : e[3], tolerance);
        ASSERT_NEAR(light.irradiance.y, GetParam().coloured ? e[5] : e[3], tolerance);
        ASSERT_NEAR(light.irradiance.z, GetParam().coloured ? e[6] : e[3], tolerance);
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, Encodings,
    testing::Values(Encoding{NvdbEncoding::Vec4, false, 4e-4}, Encoding{NvdbEncoding::Vec4, true, 4e-4},
                    Encoding{NvdbEncoding::Fp16, false, 5e-4}, Encoding{NvdbEncoding::Fp16, true, 5e-4},
                    Encoding{NvdbEncoding::Floats, false, 4e-4}, Encoding{NvdbEncoding::Direction, false, 6e-4},
                    Encoding{NvdbEncoding::Direction, true, 8e-4}));

TEST(Volume, VoxelCentresGiveTheVoxel) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Vec4, false);
    spec.world_from_index = {0.5, 0, 0.1, 0, 0.25, -0.05, 0, 0, 0.125};  // sheared along z
    spec.origin_world = {10, -3, 0.5};
    const Volume volume = test::loaded(spec);
    for (int i = -5; i <= 20; i += 5) {
        for (int k = -11; k <= 9; k += 4) {
            const Vec3 centre = volume.voxelCentre(i, 7, k);
            EXPECT_DOUBLE_EQ(centre.x, 10 + 0.5 * i + 0.1 * k);
            EXPECT_NEAR(volume.sample(centre).irradiance.x, test::swirl(i, 7, k)[3], 0.008);
        }
    }
    // Half a voxel off would be a mean of two.
    const Vec3 a = volume.voxelCentre(0, 7, 0), b = volume.voxelCentre(1, 7, 0);
    const double middle = volume.sample({(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2}).irradiance.x;
    EXPECT_NEAR(middle, (test::swirl(0, 7, 0)[3] + test::swirl(1, 7, 0)[3]) / 2, 0.008);
}

TEST(Volume, ReceiversGetTheFluxThroughThem) {
    NvdbSpec spec;
    spec.values = [](int, int, int) { return LightValues{0.3F, 0, -0.4F, 1.0F, 2.0F, 1.0F, 0.0F}; };
    spec.json = R"({"version": 1, "reference_irradiance": 1000})";
    const Volume white = test::loaded(spec);
    EXPECT_NEAR(white.irradiance({8, 8, 8}, {0, 0, 1}).x, 400, 0.3);
    EXPECT_NEAR(white.irradiance({8, 8, 8}, {-1, 0, 0}).y, 300, 0.3);
    EXPECT_EQ(white.irradiance({8, 8, 8}, {0, 0, -1}).x, 0);
    spec.coloured = true;
    const Vec3 e = test::loaded(spec).irradiance({8, 8, 8}, {0, 0, 1});
    EXPECT_NEAR(e.x, 800, 0.6);
    EXPECT_NEAR(e.y, 400, 0.3);
    EXPECT_EQ(e.z, 0);
}

TEST(Volume, InactiveVoxelsAreDark) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.active = [](int i, int j, int k) { return (i + j + k) % 3 == 0; };
    const Volume volume = test::loaded(spec);
    for (int i = -5; i <= 20; ++i) {
        const double e = volume.sample({double(i), 5, 0}).irradiance.x;
        if (spec.active(i, 5, 0)) {
            EXPECT_GT(e, 0);
        } else {
            EXPECT_EQ(e, 0);
        }
    }
}

TEST(Volume, PackedFilesAreTheSameVolume) {
    for (const NvdbEncoding encoding : {NvdbEncoding::Vec4, NvdbEncoding::Fp16}) {
        for (const bool coloured : {false, true}) {
            NvdbSpec spec = swirlSpec(encoding, coloured);
            spec.active = [](int i, int j, int k) { return (i * j + k) % 5 != 0; };
            spec.json = R"({"reference_irradiance": 800, "period": [26, 0, 0]})";
            const Volume plain = test::loaded(spec);
            spec.packing = test::NvdbPacking::Blosc;
            const Volume packed = test::loaded(spec);
            EXPECT_EQ(packed.data().light, plain.data().light);
            EXPECT_EQ(packed.data().rgb, plain.data().rgb);
            EXPECT_EQ(packed.data().pages, plain.data().pages);
            EXPECT_EQ(packed.data().lit_min, plain.data().lit_min);
            EXPECT_EQ(packed.data().lit_max, plain.data().lit_max);
            EXPECT_EQ(packed.litVoxelCount(), plain.litVoxelCount());
            EXPECT_EQ(packed.data().period, plain.data().period);
            EXPECT_EQ(packed.metadata().reference_irradiance, 800);
        }
    }
}

TEST(Volume, PackedFilesAreNotMuchLargerThanInMemory) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.max = {100, 90, 70};
    spec.packing = test::NvdbPacking::Blosc;
    EXPECT_LT(static_cast<double>(test::makeNvdb(spec).size()), 1.3 * static_cast<double>(test::loaded(spec).bytes()));
    // A floor's band: nearly all of the trees is empty.
    spec.active = [](int, int, int k) { return k == 3 || k == 4; };
    EXPECT_LT(static_cast<double>(test::makeNvdb(spec).size()), 1.3 * static_cast<double>(test::loaded(spec).bytes()));
}

TEST(Volume, UnpackingIsBounded) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.packing = test::NvdbPacking::Blosc;
    const auto bytes = test::makeNvdb(spec);
    LoadOptions small;
    small.largest_file = 2 * bytes.size();
    const auto volume = readVolume(bytes.data(), bytes.size(), small);
    ASSERT_FALSE(volume.ok());
    EXPECT_EQ(volume.error().code, ErrorCode::Limit);
    EXPECT_NE(volume.error().message.find("largest_file"), std::string::npos) << volume.error().message;
}

TEST(Volume, ZippedFilesAreRefusedByName) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.packing = test::NvdbPacking::Zip;
    const auto bytes = test::makeNvdb(spec);
    const auto volume = readVolume(bytes.data(), bytes.size());
    ASSERT_FALSE(volume.ok());
    EXPECT_NE(volume.error().message.find("codec 1"), std::string::npos) << volume.error().message;
}

TEST(Volume, PointsFarAwayAndNotANumberAreDark) {
    const Volume volume = test::loaded(swirlSpec(NvdbEncoding::Vec4, false));
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (const double far : {1e6, -1e12, 1e300, inf, -inf, nan}) {
        EXPECT_EQ(volume.sample({far, 0, 0}).irradiance.x, 0) << far;
        EXPECT_EQ(volume.sample({8, far, 0}).irradiance.x, 0) << far;
        EXPECT_EQ(volume.irradiance({8, 8, far}, {0, 0, 1}).x, 0) << far;
    }
    EXPECT_EQ(Volume().sample({0, 0, 0}).irradiance.x, 0);
}

TEST(Volume, BadValuesAreRepairedAndCounted) {
    NvdbSpec spec;
    spec.values = [](int i, int, int) -> LightValues {
        switch (i) {
            case 1:
                return {0, 0, -1, std::nanf("")};
            case 2:
                return {std::numeric_limits<float>::infinity(), 0, -1, 1};
            case 3:
                return {0, 0, -1, -5};
            case 4:
                return {0, -1e6F, -1, 1e6F};
            default:
                return {0, 0, -1, 1};
        }
    };
    const Volume volume = test::loaded(spec);
    EXPECT_EQ(volume.repairedValues(), 256U * 5U);
    EXPECT_EQ(volume.sample({1, 8, 8}).irradiance.x, 0);
    EXPECT_EQ(volume.sample({2, 8, 8}).flux.x, 0);
    EXPECT_EQ(volume.sample({3, 8, 8}).irradiance.x, 0);
    EXPECT_EQ(volume.sample({4, 8, 8}).irradiance.x, 65504);
    EXPECT_EQ(volume.sample({4, 8, 8}).flux.y, -65504);
}

TEST(Volume, MetadataAreRead) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.json = R"({ "version": 1, "paths": "all", "reference_irradiance": 12.5, "ior": 1.333, "frame": 7,
        "scattering": [0.1, 0.2, 0.3], "absorption": 0.05, "anisotropy": 0.8, "up_axis": "Z",
        "ledger": {"power": [1, {"a": "}\""}], "ok": true}, "unknown": null } )";
    const Metadata m = test::loaded(spec).metadata();
    EXPECT_EQ(m.reference_irradiance, 12.5);
    EXPECT_EQ(m.ior, 1.333);
    EXPECT_EQ(m.frame, 7);
    EXPECT_EQ(m.scattering.y, 0.2);
    EXPECT_EQ(m.absorption.z, 0.05);
    EXPECT_EQ(m.anisotropy, 0.8);
    EXPECT_EQ(m.paths, "all");
}

TEST(Volume, TheMediumEndsAtTheWater) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Fp16, false);
    spec.world_from_index = {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.25};
    spec.origin_world = {0, 0, 1};
    // Not said: below the highest of the voxels with light, 9 and a half in index.
    spec.json = R"({"scattering": 0.1})";
    const Metadata unknown = test::loaded(spec).metadata();
    EXPECT_DOUBLE_EQ(unknown.surface[3], 1 + 9.5 * 0.25);
    EXPECT_FLOAT_EQ(mediumOf(unknown).surface[2], 1);
    EXPECT_FLOAT_EQ(mediumOf(unknown).surface[3], 1 + 9.5 * 0.25);
    spec.json = R"({"scattering": 0.1, "water_level": 2.75, "scene_hash": "0123456789abcdef"})";
    const Metadata known = test::loaded(spec).metadata();
    EXPECT_EQ(known.surface[3], 2.75);
    EXPECT_FLOAT_EQ(mediumOf(known).surface[3], 2.75F);
    EXPECT_EQ(known.scene_hash, "0123456789abcdef");
    spec.json = R"({"water_level": 2, "up_axis": "Y"})";
    EXPECT_EQ(test::loaded(spec).metadata().surface[1], 1);
    EXPECT_EQ(test::loaded(spec).metadata().surface[2], 0);
    // Of darkness nothing is known: everywhere, as MediumOptions has it.
    EXPECT_FLOAT_EQ(mediumOf(Volume().metadata()).surface[2], 0);
}

TEST(Volume, PeriodicLightRepeats) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Vec4, false);  // 26 x 15 x 21 voxels
    spec.world_from_index = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
    spec.json = R"({"period": [2.6, 1.5, 0]})";
    const Volume volume = test::loaded(spec);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 2000; ++n) {
        const double x = -0.5 + 2.6 * unit(random), y = 0.3 + 1.5 * unit(random), z = 2 * unit(random) - 1.2;
        const double here = volume.sample({x, y, z}).irradiance.x;
        ASSERT_NEAR(volume.sample({x + 2.6 * 3, y - 1.5 * 5, z}).irradiance.x, here, 1e-6);
    }
    // Between the last voxel and the first of the next period: their mean, not a dark seam.
    const double seam = volume.sample({2.05, 0.7, 0}).irradiance.x;
    EXPECT_NEAR(seam, (test::swirl(20, 7, 0)[3] + test::swirl(-5, 7, 0)[3]) / 2, 0.01);
}

TEST(Volume, PeriodThatIsNoWholeNumberOfVoxelsIsRefused) {
    NvdbSpec spec = swirlSpec(NvdbEncoding::Vec4, false);
    spec.json = R"({"period": [26.5, 0, 0]})";
    const auto bytes = test::makeNvdb(spec);
    const auto volume = readVolume(bytes.data(), bytes.size());
    ASSERT_FALSE(volume.ok());
    EXPECT_NE(volume.error().message.find("26.5"), std::string::npos) << volume.error().message;
}

TEST(Volume, FilesLoadAndErrorsNameThem) {
    const auto folder = std::filesystem::temp_directory_path();
    const std::string path = (folder / ("photic_volume_" + std::to_string(::getpid()) + ".nvdb")).string();
    const auto bytes = test::makeNvdb(swirlSpec(NvdbEncoding::Fp16, false));
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    EXPECT_TRUE(loadVolume(path).ok());
    LoadOptions small;
    small.largest_file = 1000;
    EXPECT_EQ(loadVolume(path, small).error().code, ErrorCode::Limit);
    small = {};
    small.largest_memory = 100000;
    EXPECT_EQ(loadVolume(path, small).error().code, ErrorCode::Limit);
    std::filesystem::remove(path);
    const auto missing = loadVolume(path);
    ASSERT_FALSE(missing.ok());
    EXPECT_EQ(missing.error().code, ErrorCode::File);
    EXPECT_NE(missing.error().message.find(path), std::string::npos);
    EXPECT_FALSE(loadVolume(folder.string()).ok());
}

TEST(Volume, MemoryIsWhatItSays) {
    NvdbSpec spec;
    spec.min = {0, 0, 0};
    spec.max = {63, 63, 63};
    spec.values = test::swirl;
    const Volume volume = test::loaded(spec);
    const double per_voxel = static_cast<double>(volume.bytes()) / static_cast<double>(volume.litVoxelCount());
    EXPECT_GT(per_voxel, 8.0);
    EXPECT_LT(per_voxel, 8.05);
}

}  // namespace
}  // namespace photic::runtime
