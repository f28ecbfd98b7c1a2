// SPDX-License-Identifier: Apache-2.0
// 3D textures, read by readers of our own, written from the formats' specifications, and by npm's ktx-parse.
#include "bake/file/texture_3d.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bake/report/error.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

using nlohmann::json;

template <class Number>
Number numberAt(const std::string& bytes, std::size_t at) {
    Number n;
    std::memcpy(&n, bytes.data() + at, sizeof(n));
    return n;
}
std::uint32_t u32(const std::string& bytes, std::size_t at) { return numberAt<std::uint32_t>(bytes, at); }

// A texture as a stranger reads it.
struct Read {
    glm::ivec3 size{0};
    int channels = 4, channel_bytes = 2;
    std::string texels;
    json metadata;

    double at(const glm::ivec3& t, int c) const {
        const auto i = static_cast<std::size_t>(((t.z * size.y + t.y) * size.x + t.x) * channels + c);
        if (channel_bytes == 4) return double(numberAt<float>(texels, i * 4));
        return double(imath_half_to_float(numberAt<std::uint16_t>(texels, i * 2)));
    }
    glm::dvec3 world(const glm::ivec3& t) const {
        const auto& m = metadata["world_from_texture"];
        const glm::dvec3 uvw = (glm::dvec3(t) + 0.5) / glm::dvec3(size);
        glm::dvec3 p;
        for (int r = 0; r < 3; ++r) {
            const auto& row = m[static_cast<std::size_t>(r)];
            p[r] = row[0].get<double>() * uvw.x + row[1].get<double>() * uvw.y + row[2].get<double>() * uvw.z +
                   row[3].get<double>();
        }
        return p;
    }
};

Read readKtx2(const std::string& path) {
    const std::string b = bytesOf(path);
    Read r;
    EXPECT_EQ(b.substr(0, 12), std::string("\xABKTX 20\xBB\r\n\x1A\n", 12));
    EXPECT_EQ(u32(b, 12), 97u);
    EXPECT_EQ(u32(b, 16), 2u);
    for (std::size_t a = 0; a < 3; ++a) r.size[static_cast<int>(a)] = static_cast<int>(u32(b, 20 + 4 * a));
    const auto level = numberAt<std::uint64_t>(b, 80), length = numberAt<std::uint64_t>(b, 88);
    EXPECT_EQ(level % 8, 0u);
    EXPECT_EQ(level + length, b.size());
    EXPECT_EQ(length, 8u * static_cast<unsigned>(r.size.x * r.size.y * r.size.z));
    // The descriptor begins after the level index, key/values after it; keys are sorted.
    EXPECT_EQ(u32(b, 48), 104u);
    EXPECT_EQ(u32(b, 56), u32(b, 48) + u32(b, 52));
    EXPECT_EQ(u32(b, u32(b, 48)), u32(b, 52));
    std::string last;
    for (std::size_t at = u32(b, 56), end = at + u32(b, 60); at < end;) {
        const std::uint32_t bytes = u32(b, at);
        const std::string key = b.c_str() + at + 4;
        EXPECT_LT(last, key);
        last = key;
        if (key == "photic") r.metadata = json::parse(b.substr(at + 4 + key.size() + 1, bytes - key.size() - 2));
        at += 4 + (bytes + 3) / 4 * 4;
        EXPECT_LE(at, end);
    }
    r.texels = b.substr(level);
    return r;
}

Read readDds(const std::string& path) {
    const std::string b = bytesOf(path);
    Read r;
    EXPECT_EQ(b.substr(0, 4), "DDS ");
    EXPECT_EQ(u32(b, 4), 124u);
    EXPECT_EQ(u32(b, 8) & 0x80100fu, 0x80100fu & (0x1u | 0x2u | 0x4u | 0x8u | 0x1000u | 0x800000u));
    r.size = {static_cast<int>(u32(b, 16)), static_cast<int>(u32(b, 12)), static_cast<int>(u32(b, 24))};
    EXPECT_EQ(u32(b, 20), static_cast<unsigned>(r.size.x) * 8);  // pitch
    EXPECT_EQ(u32(b, 76), 32u);
    EXPECT_EQ(b.substr(84, 4), "DX10");
    EXPECT_EQ(u32(b, 112) & 0x200000u, 0x200000u);  // a volume
    EXPECT_EQ(u32(b, 128), 10u);                    // R16G16B16A16_FLOAT
    EXPECT_EQ(u32(b, 132), 4u);                     // TEXTURE3D
    EXPECT_EQ(u32(b, 140), 1u);
    r.texels = b.substr(148);
    r.metadata = json::parse(bytesOf(path + ".json"));
    return r;
}

Read readVf(const std::string& path, const std::string& sidecar, char kind) {
    const std::string b = bytesOf(path);
    Read r;
    EXPECT_EQ(b.substr(0, 4), std::string("VF_") + kind);
    for (std::size_t a = 0; a < 3; ++a) r.size[static_cast<int>(a)] = numberAt<std::uint16_t>(b, 4 + 2 * a);
    r.channels = kind == 'V' ? 3 : 1, r.channel_bytes = 4;
    r.texels = b.substr(10);
    r.metadata = json::parse(bytesOf(sidecar));
    return r;
}

// Every texel against the light at its place in the world.
void expectLight(const Read& r, int light_channel, int flux_channel, double tolerance, bool unity) {
    ASSERT_EQ(r.texels.size(), static_cast<std::size_t>(r.size.x * r.size.y * r.size.z * r.channels * r.channel_bytes));
    for (int x = 0; x < r.size.x; ++x)
        for (int y = 0; y < r.size.y; ++y)
            for (int z = 0; z < r.size.z; ++z) {
                const glm::dvec3 p = r.world({x, y, z});
                const TestLight light = testLight(unity ? glm::dvec3(p.x, p.z, p.y) : p);
                const double e = light.mean() / 1000;
                if (light_channel >= 0) {
                    ASSERT_NEAR(r.at({x, y, z}, light_channel), e, tolerance * e);
                }
                if (flux_channel < 0) continue;
                glm::dvec3 flux(r.at({x, y, z}, flux_channel), r.at({x, y, z}, flux_channel + 1),
                                r.at({x, y, z}, flux_channel + 2));
                if (light_channel >= 0) {
                    ASSERT_LE(glm::dot(flux, flux), r.at({x, y, z}, light_channel) * r.at({x, y, z}, light_channel));
                }
                if (unity) std::swap(flux.y, flux.z);
                for (int a = 0; a < 3; ++a) ASSERT_NEAR(flux[a], e * light.direction[a], tolerance * e);
            }
}

LightVolume sourceVolume(bool coloured) {
    LightVolume volume = testVolume(straightFrame({-9, 3, -20}, {14, 17, 3}, 1.0 / 64), coloured,
                                    [](const glm::ivec3& v) { return v.x >= -5 && v.x <= 9 && v.z > -12; });
    volume.metadata = {{"method", "beams"}, {"ior", "1.333"}};
    return volume;
}

TEST(Texture3d, Ktx2AndDdsHoldTheLightOfEveryVoxelCropped) {
    for (const bool coloured : {false, true}) {
        for (const auto format : {TextureFormat::Ktx2, TextureFormat::Dds}) {
            const TemporaryFolder folder;
            const bool dds = format == TextureFormat::Dds;
            const std::string path = folder / (dds ? "a.dds" : "a.ktx2"),
                              rgb_path = folder / (dds ? "a_rgb.dds" : "a_rgb.ktx2");
            const DenseWritten written = writeTextures(path, sourceVolume(coloured), format);
            EXPECT_EQ(written.size, glm::ivec3(15, 15, 15));
            EXPECT_EQ(written.files.size(), 1u + coloured + dds);
            EXPECT_EQ(folder.fileCount(), written.files.size());
            const Read r = dds ? readDds(path) : readKtx2(path);
            EXPECT_EQ(r.size, written.size);
            EXPECT_EQ(r.metadata["reference_irradiance"], 1000.0);
            EXPECT_EQ(r.metadata["texture_size"], (json{15, 15, 15}));
            EXPECT_EQ(r.metadata["rgb_texture"].is_null(), !coloured);
            expectLight(r, 3, 0, 1e-3, false);
            if (!coloured) continue;
            Read rgb = dds ? r : readKtx2(rgb_path);
            if (dds) rgb.texels = bytesOf(rgb_path).substr(148);
            for (int i = 0; i < 15; ++i) {
                const TestLight light = testLight(rgb.world({i, 7, 3}));
                ASSERT_NEAR(rgb.at({i, 7, 3}, 0), light.red / 1000, 1e-3);
                ASSERT_NEAR(rgb.at({i, 7, 3}, 2), light.blue / 1000, 1e-3);
                ASSERT_NEAR(rgb.at({i, 7, 3}, 3), light.mean() / 1000, 1e-3);
            }
        }
    }
}

TEST(Texture3d, UnityFilesAreTurnedToItsAxes) {
    const TemporaryFolder folder;
    LightVolume volume = testVolume(straightFrame({-9, 3, -20}, {14, 9, 3}, 1.0 / 64), true);
    writeTextures(folder / "a.vf", volume, TextureFormat::UnityVf);
    const Read irradiance = readVf(folder / "a.vf", folder / "a.vf.json", 'F'),
               flux = readVf(folder / "a_flux.vf", folder / "a.vf.json", 'V'),
               rgb = readVf(folder / "a_rgb.vf", folder / "a.vf.json", 'V');
    EXPECT_EQ(irradiance.size, glm::ivec3(24, 24, 7));  // x, our z, our y
    EXPECT_EQ(irradiance.metadata["up_axis"], "Y");
    EXPECT_EQ(irradiance.metadata["handedness"], "left");
    expectLight(irradiance, 0, -1, 1e-5, true);
    expectLight(flux, -1, 0, 1e-5, true);
    const glm::dvec3 p = rgb.world({3, 20, 5});
    EXPECT_NEAR(rgb.at({3, 20, 5}, 1), testLight({p.x, p.z, p.y}).green / 1000, 1e-5);
}

TEST(Texture3d, ShearedFieldsAreResampledAndBoxesAreShared) {
    const TemporaryFolder folder;
    const LightVolume leaning = testVolume(leaningFrame({-16, -16, -16}, {15, 15, 8}, 1.0 / 16), false);
    writeTextures(folder / "a.ktx2", leaning, TextureFormat::Ktx2);
    const Read r = readKtx2(folder / "a.ktx2");
    EXPECT_EQ(r.metadata["resampled"], true);
    double sum = 0;
    int count = 0;
    for (int x = 0; x < r.size.x; ++x)
        for (int y = 0; y < r.size.y; ++y)
            for (int z = 0; z < r.size.z; ++z) {
                const glm::dvec3 p = r.world({x, y, z});
                if (glm::length(p) > 0.7) continue;
                sum += std::fabs(r.at({x, y, z}, 3) / (testLight(p).mean() / 1000) - 1), ++count;
            }
    ASSERT_GT(count, 1000);
    EXPECT_LT(sum / count, 0.01);

    const VoxelBox box{{-20, 0, -30}, {20, 20, 10}};
    EXPECT_EQ(writeTextures(folder / "b.ktx2", sourceVolume(false), TextureFormat::Ktx2, box).size,
              glm::ivec3(41, 21, 41));
    EXPECT_EQ(readKtx2(folder / "b.ktx2").at({0, 0, 0}, 3), 0);
}

TEST(Texture3d, KtxParseReadsWhatIsThere) {
    if (std::system("node --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
    const std::string prefix = PHOTIC_KTX_PARSE;
    const std::string installed = "test -d '" + prefix + "/node_modules/ktx-parse'";
    const std::string install = installed + " || timeout 120 npm install --silent --no-audit --no-fund --prefix '" +
                                prefix + "' ktx-parse@1.0.1 >/dev/null 2>&1";
    if (std::system(install.c_str()) != 0) GTEST_SKIP() << "npm cannot install ktx-parse@1.0.1: is there a network?";
    const TemporaryFolder folder;
    const LightVolume volume = sourceVolume(true);
    writeTextures(folder / "a.ktx2", volume, TextureFormat::Ktx2);
    for (const char* name : {"a.ktx2", "a_rgb.ktx2"}) {
        const std::string command = "KTX_PARSE='" + prefix +
                                    "' node '" PHOTIC_SOURCE_DIR "/tests/file/ktx_parse.mjs' '" + (folder / name) +
                                    "' > '" + (folder / "out.json") + "'";
        ASSERT_EQ(std::system(command.c_str()), 0);
        const json found = json::parse(bytesOf(folder / "out.json"));
        const Read own = readKtx2(folder / name);
        EXPECT_EQ(found["vkFormat"], 97);
        EXPECT_EQ(found["typeSize"], 2);
        EXPECT_EQ(found["size"], (json{15, 15, 15}));
        EXPECT_EQ(found["counts"], (json{0, 1, 1, 0}));
        EXPECT_EQ(found["bytes"], own.texels.size());
        EXPECT_EQ(found["uncompressed"], own.texels.size());
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < own.texels.size(); ++i)
            sum = (sum + static_cast<unsigned char>(own.texels[i]) * (i % 65521 + 1)) % 4294967296u;
        EXPECT_EQ(found["sum"], sum);
        EXPECT_EQ(json::parse(found["keys"]["photic"].get<std::string>()), own.metadata);
        EXPECT_EQ(found["keys"]["KTXorientation"], "ruo");
        const json& descriptor = found["descriptor"];
        EXPECT_EQ(descriptor["colorModel"], 1);
        EXPECT_EQ(descriptor["transferFunction"], 1);
        EXPECT_EQ(descriptor["bytesPlane"][0], 8);
        ASSERT_EQ(descriptor["samples"].size(), 4u);
        EXPECT_EQ(descriptor["samples"][3]["bitOffset"], 48);
        EXPECT_EQ(descriptor["samples"][3]["bitLength"], 15);
        EXPECT_EQ(descriptor["samples"][3]["channelType"], 15 | 0xC0);
    }
}

TEST(Texture3d, TooLargeOddAndUnwritable) {
    const TemporaryFolder folder;
    LightVolume volume = testVolume(straightFrame({0, 0, 0}, {2999, 7, 7}, 0.001), false,
                                    [](const glm::ivec3& v) { return v.x % 2999 == 0; });
    for (const auto format : {TextureFormat::Ktx2, TextureFormat::Dds, TextureFormat::UnityVf}) {
        try {
            writeTextures(folder / "a.x", volume, format);
            FAIL();
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::Input);
            EXPECT_NE(std::string(e.what()).find("2048"), std::string::npos) << e.what();
        }
    }
    volume = sourceVolume(true);
    EXPECT_THROW(writeTextures("/dev/null/no/a.dds", volume, TextureFormat::Dds), Error);
    // Where the second file cannot be made, the first is not left either.
    std::filesystem::create_directory(folder / "a_rgb.ktx2");
    EXPECT_THROW(writeTextures(folder / "a.ktx2", volume, TextureFormat::Ktx2), Error);
    EXPECT_EQ(folder.fileCount(), 1u);
    volume.field.makeDense(volume.field.needed().slotOf({0, 5, 0}))[NeededVoxels::offsetInLeaf({0, 5, 0})] = 1e9f;
    EXPECT_GT(writeTextures(folder / "b.ktx2", volume, TextureFormat::Ktx2).clamped, 0);
    const LightVolume dark =
        testVolume(straightFrame({3, 4, 5}, {9, 9, 9}, 0.1), false, [](const glm::ivec3&) { return false; });
    EXPECT_EQ(writeTextures(folder / "dark.dds", dark, TextureFormat::Dds).size, glm::ivec3(1));
}

}  // namespace
}  // namespace photic
