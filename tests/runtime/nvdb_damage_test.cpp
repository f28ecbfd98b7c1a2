// SPDX-License-Identifier: Apache-2.0
// Files that are cut short or damaged are refused, or loaded as something harmless; never read past their end.
// Meant for the sanitized build too; tests/fuzz goes on where this stops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include "photic/runtime.h"
#include "runtime/src/metadata_json.h"
#include "runtime/src/nvdb_layout.h"
#include "tests/runtime/nvdb_files.h"

namespace photic::runtime {
namespace {

using test::NvdbEncoding;
using test::NvdbSpec;
using FileBytes = std::vector<unsigned char>;

LoadOptions modest() {
    LoadOptions options;
    options.largest_memory = 1 << 24;
    return options;
}

/// Reads from a block of just this size, so that a sanitizer sees the first byte beyond.
Result<Volume> readCopy(const FileBytes& bytes, std::size_t size) {
    const std::unique_ptr<unsigned char[]> copy(new unsigned char[size]);
    std::copy_n(bytes.begin(), size, copy.get());
    return readVolume(copy.get(), size, modest());
}

/// What must hold of any volume that loads.
void expectHarmless(const Volume& volume) {
    const VoxelBox box = volume.litVoxels();
    const Vec3 corner = volume.voxelCentre(box.min[0], box.min[1], box.min[2]);
    const Vec3 other = volume.voxelCentre(box.max[0], box.max[1], box.max[2]);
    for (const double t : {-0.1, 0.0, 0.3, 0.77, 1.0, 1.1}) {
        const Light light = volume.sample({corner.x + t * (other.x - corner.x), corner.y + t * (other.y - corner.y),
                                           corner.z + t * (other.z - corner.z)});
        EXPECT_TRUE(std::isfinite(light.irradiance.x) && light.irradiance.x >= 0);
        EXPECT_TRUE(std::isfinite(light.flux.x + light.flux.y + light.flux.z));
    }
}

FileBytes smallFile(NvdbEncoding encoding, bool coloured, int first_x = 1,
                    test::NvdbPacking packing = test::NvdbPacking::None) {
    NvdbSpec spec;
    spec.min = {first_x, 0, 0};
    spec.max = {13, 4, 4};
    spec.values = test::swirl;
    spec.encoding = encoding;
    spec.coloured = coloured;
    spec.packing = packing;
    spec.json = R"({"version": 1, "reference_irradiance": 1000, "ior": 1.33, "period": [0, 0, 0]})";
    return test::makeNvdb(spec);
}

TEST(NvdbDamage, EveryTruncatedLengthIsRefused) {
    const FileBytes file = smallFile(NvdbEncoding::Fp16, false);
    ASSERT_TRUE(readCopy(file, file.size()).ok());
    for (std::size_t size = 0; size < file.size(); ++size) {
        const auto volume = readVolume(file.data(), size, modest());
        ASSERT_FALSE(volume.ok()) << size << " of " << file.size();
        ASSERT_EQ(volume.error().code, ErrorCode::Format) << volume.error().message;
    }
    // Some of them with nothing behind their end: where headers are, and here and there.
    for (std::size_t size = 0; size < file.size(); size += size < 2000 ? 1 : 4999)
        EXPECT_FALSE(readCopy(file, size).ok());
}

TEST(NvdbDamage, TruncatedLengthsOfAPackedFileAreRefused) {
    const FileBytes file = smallFile(NvdbEncoding::Fp16, false, 1, test::NvdbPacking::Blosc);
    ASSERT_TRUE(readCopy(file, file.size()).ok());
    for (std::size_t size = 0; size < file.size(); size += size < 1000 ? 1 : 29) {
        const auto volume = readCopy(file, size);
        ASSERT_FALSE(volume.ok()) << size << " of " << file.size();
        ASSERT_EQ(volume.error().code, ErrorCode::Format) << volume.error().message;
    }
}

TEST(NvdbDamage, MutationsDoNoHarm) {
    std::mt19937_64 random(7);
    const auto upTo = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    int loaded = 0, refused = 0;
    using test::NvdbPacking;
    for (const auto& [encoding, packing] : {std::pair{NvdbEncoding::Vec4, NvdbPacking::None},
                                            {NvdbEncoding::Fp16, NvdbPacking::None},
                                            {NvdbEncoding::Direction, NvdbPacking::None},
                                            {NvdbEncoding::Fp16, NvdbPacking::Blosc},
                                            {NvdbEncoding::Vec4, NvdbPacking::Blosc}}) {
        const FileBytes file = smallFile(encoding, encoding == NvdbEncoding::Direction, 1, packing);
        // Bytes that steer the reader: all that is not zero outside of leaves' values, found by what they are.
        std::vector<std::size_t> live;
        for (std::size_t i = 0; i < file.size(); ++i) {
            if (file[i] != 0) live.push_back(i);
        }
        for (int n = 0; n < 500; ++n) {
            FileBytes damaged = file;
            const std::size_t count = 1 + upTo(3);
            for (std::size_t i = 0; i < count; ++i) {
                const std::size_t at = upTo(4) == 0 ? upTo(file.size()) : live[upTo(live.size())];
                static constexpr std::uint64_t kNasty[] = {0,
                                                           1,
                                                           0x7f,
                                                           0x80,
                                                           0xff,
                                                           0xffffffff,
                                                           0x7fffffff,
                                                           0x80000000,
                                                           0xffffffffffffffff,
                                                           0x8000000000000000,
                                                           32,
                                                           4096};
                const std::uint64_t value = upTo(2) == 0 ? random() : kNasty[upTo(std::size(kNasty))];
                std::memcpy(damaged.data() + at, &value,
                            std::min<std::size_t>(std::size_t{1} << upTo(4), file.size() - at));
            }
            const auto volume = readCopy(damaged, damaged.size());
            if (volume) {
                ++loaded;
                expectHarmless(*volume);
            } else {
                ++refused;
                EXPECT_FALSE(volume.error().message.empty());
            }
        }
    }
    // Both happen, or the mutations hit nothing that matters, or everything.
    EXPECT_GT(loaded, 50);
    EXPECT_GT(refused, 50);
}

/// One hand-made damage: a name, the error's word, and what to change.
struct Damage {
    const char* name;
    const char* word;
    void (*apply)(FileBytes&, std::size_t grid);
};

template <class T>
void put(FileBytes& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}
template <class T>
T get(const FileBytes& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

class Damages : public testing::TestWithParam<Damage> {};

TEST_P(Damages, IsRefusedInWords) {
    FileBytes file = smallFile(NvdbEncoding::Vec4, false, -3);  // on both sides of 0: two tiles in the root
    const std::size_t grid = nvdb::kFileHeaderSize + nvdb::kRecordSize +
                             get<std::uint32_t>(file, nvdb::kFileHeaderSize + nvdb::kRecordNameSize);
    // The first word of a grid differs between versions of NanoVDB.
    const auto magic = get<std::uint64_t>(file, grid);
    ASSERT_TRUE(magic == nvdb::kMagicOld || magic == nvdb::kMagicGrid) << magic;
    GetParam().apply(file, grid);
    const auto volume = readCopy(file, file.size());
    ASSERT_FALSE(volume.ok());
    EXPECT_NE(volume.error().message.find(GetParam().word), std::string::npos) << volume.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    All, Damages,
    testing::Values(
        Damage{"magic", "no NanoVDB file", [](FileBytes& f, std::size_t) { f[0] = 'X'; }},
        Damage{"version", "only 32.x", [](FileBytes& f, std::size_t) { put<std::uint32_t>(f, 8, 31U << 21); }},
        Damage{"zipped", "compressed", [](FileBytes& f, std::size_t) { put<std::uint16_t>(f, 16 + 168, 1); }},
        Damage{"packed beyond belief", "size in memory",
               [](FileBytes& f, std::size_t) {
                   put<std::uint16_t>(f, 14, 2), put<std::uint16_t>(f, 16 + 168, 2);
                   put<std::uint64_t>(f, 16, 1ULL << 60);
               }},
        Damage{"sizes differ", "size in memory", [](FileBytes& f, std::size_t) { put<std::uint64_t>(f, 16 + 8, 5); }},
        Damage{"endless name", "no end", [](FileBytes& f, std::size_t g) { std::memset(f.data() + g + 40, 'a', 256); }},
        Damage{"other name", "no grid `flux`", [](FileBytes& f, std::size_t g) { f[g + 40] = 'F'; }},
        Damage{"endless transform", "not finite",
               [](FileBytes& f, std::size_t g) { put<double>(f, g + 296 + 88, std::nan("")); }},
        Damage{"flat transform", "no inverse", [](FileBytes& f, std::size_t g) { put<double>(f, g + 296 + 88, 0.0); }},
        Damage{"leaves beyond the end", "leaves",
               [](FileBytes& f, std::size_t g) { put<std::uint32_t>(f, g + 672 + 32, 0xffffffffU); }},
        Damage{"root beyond the end", "the root",
               [](FileBytes& f, std::size_t g) { put<std::uint64_t>(f, g + 672 + 24, 1ULL << 40); }},
        Damage{"child between nodes", "no node",
               [](FileBytes& f, std::size_t g) {
                   const std::size_t tile = g + 672 + get<std::uint64_t>(f, g + 672 + 24) + 96;
                   put<std::int64_t>(f, tile + 8, get<std::int64_t>(f, tile + 8) + 4);
               }},
        Damage{"two parents", "two parents",
               [](FileBytes& f, std::size_t g) {
                   const std::size_t tile = g + 672 + get<std::uint64_t>(f, g + 672 + 24) + 96;
                   put<std::int64_t>(f, tile + 64 + 8, get<std::int64_t>(f, tile + 8));
               }},
        Damage{"a tile of 4096^3", "largest_memory",
               [](FileBytes& f, std::size_t g) {
                   const std::size_t tile = g + 672 + get<std::uint64_t>(f, g + 672 + 24) + 96;
                   put<std::int64_t>(f, tile + 8, 0);
                   put<std::uint32_t>(f, tile + 16, 1);
               }}),
    [](const auto& param_info) {
        std::string name = param_info.param.name;
        std::replace_if(
            name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
        return name;
    });

TEST(NvdbDamage, BadMetadataAreRefused) {
    for (const char* json : {"{", "{\"a\"", "{\"a\":", "{\"a\":1", "{\"a\":}", "[]", "{\"a\":[1,2}", "{\"a\" 1}",
                             "{\"a\":1,}", "{\"reference_irradiance\":-1}", "{\"reference_irradiance\":1e999}",
                             "{\"version\":2}", "{\"version\":\"1\"}", "{\"scattering\":[1,2]}", "{\"anisotropy\":1}",
                             "{\"period\":-3}", "{\"a\":[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]}"}) {
        EXPECT_THROW(readMetadata(json), Failure) << json;
    }
    EXPECT_NO_THROW(readMetadata("{}"));
}

}  // namespace
}  // namespace photic::runtime
