// SPDX-License-Identifier: Apache-2.0
// The second lobe through every file: written, read back, and looked up by the run-time library.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/field/resample.h"
#include "bake/file/nvdb.h"
#include "bake/file/runtime_size.h"
#include "bake/file/slice_atlas.h"
#include "bake/file/texture_3d.h"
#include "photic/runtime.h"
#include "runtime/src/brick_plan.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

/// Light in all voxels, and half of it again, mirrored, in those with x below 8.
LightVolume twoLobes(const GridFrame& frame, bool coloured) {
    LightVolume volume = testVolume(frame, coloured);
    volume.second = std::move(testVolume(frame, coloured, [](const glm::ivec3& v) { return v.x < 8; }).field);
    LightField& second = *volume.second;
    for (int slot = 0; slot < second.leafCount(); ++slot) {
        if (second.state(slot) == LeafState::Empty) continue;
        float* leaf = second.makeDense(slot);
        for (int i = 0; i < 512 * second.channels().count(); ++i)
            leaf[i] *= i < 512 * second.channels().irradiance ? 0.5f : -0.5f;
    }
    volume.metadata["lobe_axis"] = "[0,0,-1]";
    return volume;
}

GridFrame smallFrame() { return straightFrame({-9, 3, -20}, {14, 17, 3}, 1.0 / 64); }

double received(const std::array<float, 8>& light, int colours, const glm::dvec3& normal) {
    const auto f = static_cast<std::size_t>(colours);
    return std::max(0.0, -glm::dot(normal, glm::dvec3(light[f], light[f + 1], light[f + 2])));
}

TEST(SecondLobe, ComesBackFromAVdb) {
    for (const bool coloured : {false, true}) {
        const TemporaryFolder folder;
        const LightVolume volume = twoLobes(smallFrame(), coloured);
        const std::int64_t active = writeVdb(folder / "a.vdb", volume, {});
        EXPECT_EQ(active, volume.field.needed().count());
        const LightVolume read = readVdb(folder / "a.vdb");
        ASSERT_TRUE(read.second.has_value());
        EXPECT_EQ(read.metadata.at("lobe_axis"), "[0,0,-1]");
        for (const glm::ivec3& v : {glm::ivec3(-9, 3, -20), glm::ivec3(7, 10, -5), glm::ivec3(8, 10, -5)}) {
            const double e = volume.second->irradiance(v);
            EXPECT_NEAR(read.second->irradiance(v), e, 1e-3 * e);
            EXPECT_LT(glm::length(read.second->flux(v) - volume.second->flux(v)), 2e-3 * e + 1e-12);
            EXPECT_NEAR(read.field.irradiance(v), volume.field.irradiance(v), 1e-3 * volume.field.irradiance(v));
        }
        // Written again, the same bytes.
        writeVdb(folder / "b.vdb", read, {});
        EXPECT_EQ(bytesOf(folder / "a.vdb"), bytesOf(folder / "b.vdb"));
    }
}

TEST(SecondLobe, ALeafWithNothingElseIsActive) {
    const TemporaryFolder folder;
    LightVolume volume = twoLobes(smallFrame(), false);
    const int slot = volume.field.needed().slotOf({0, 8, -8});
    volume.field.setEmpty(slot);
    writeVdb(folder / "a.vdb", volume, {});
    const LightVolume read = readVdb(folder / "a.vdb");
    EXPECT_EQ(read.field.irradiance({1, 9, -7}), 0);
    EXPECT_GT(read.second->irradiance({1, 9, -7}), 0);
}

TEST(SecondLobe, JoinsTheFirstWhereOneIsWanted) {
    LightVolume volume = twoLobes(smallFrame(), true);
    const glm::ivec3 v(5, 6, -3);
    const double all = volume.field.irradiance(v) + volume.second->irradiance(v);
    const glm::dvec3 flux = volume.field.flux(v) + volume.second->flux(v);
    const LightVolume one = withoutLobes(std::move(volume));
    EXPECT_FALSE(one.second.has_value());
    EXPECT_EQ(one.metadata.count("lobe_axis"), 0u);
    EXPECT_NEAR(one.field.irradiance(v), all, 1e-6 * all);
    EXPECT_LT(glm::length(one.field.flux(v) - flux), 1e-6 * all);
}

TEST(SecondLobe, TheRunTimeLibraryAddsBothUp) {
    for (const bool coloured : {false, true}) {
        for (const auto precision : {NvdbPrecision::Half, NvdbPrecision::Float}) {
            const TemporaryFolder folder;
            const LightVolume volume = twoLobes(smallFrame(), coloured);
            writeNvdb(folder / "a.nvdb", volume, {precision, NvdbCodec::None});
            const auto loaded = runtime::loadVolume(folder / "a.nvdb");
            ASSERT_TRUE(loaded) << loaded.error().message;
            ASSERT_TRUE(loaded->hasSecondLobe());
            EXPECT_GT(loaded->secondLobe().litVoxelCount(), 0u);
            const RuntimeSize size = runtimeSize(volume);
            EXPECT_EQ(size.bricks,
                      static_cast<std::int64_t>(runtime::planBricks(loaded->data()).bricks.size() +
                                                runtime::planBricks(loaded->secondLobe().data()).bricks.size()));
            const GridFrame& frame = volume.field.frame();
            const int colours = coloured ? 3 : 1;
            std::vector<runtime::Vec3> places, normals;
            std::vector<double> expected;
            for (int i = 0; i < 500; ++i) {
                const glm::dvec3 index(-10 + 26 * std::fmod(i * 0.754877, 1), 2 + 17 * std::fmod(i * 0.569840, 1),
                                       -21 + 25 * std::fmod(i * 0.438579, 1));
                const glm::dvec3 p = frame.worldFromIndex(index);
                const auto first = sampleTrilinear(volume.field, index),
                           second = sampleTrilinear(*volume.second, index);
                const glm::dvec3 normal = glm::normalize(glm::dvec3(std::cos(i), std::sin(1.7 * i), std::cos(2.3 * i)));
                const runtime::Light light = loaded->sample({p.x, p.y, p.z});
                constexpr double kTolerance = 2.5;  // W/m2 of halves below 1700
                ASSERT_NEAR(light.irradiance.x, double(first[0] + second[0]), kTolerance);
                ASSERT_NEAR(light.flux.z,
                            double(first[static_cast<std::size_t>(colours) + 2] +
                                   second[static_cast<std::size_t>(colours) + 2]),
                            kTolerance);
                places.push_back({p.x, p.y, p.z}), normals.push_back({normal.x, normal.y, normal.z});
                const auto share = [&](const std::array<float, 8>& of) {
                    double mean = 0;
                    for (int c = 0; c < colours; ++c) mean += double(of[static_cast<std::size_t>(c)]) / colours;
                    return mean > 0 ? double(of[0]) / mean * received(of, colours, normal) : 0;
                };
                expected.push_back(share(first) + share(second));
                ASSERT_NEAR(loaded->irradiance(places.back(), normals.back()).x, expected.back(), kTolerance);
            }
            std::vector<runtime::Vec3> many(places.size());
            std::vector<runtime::Light> lights(places.size());
            loaded->irradiance(places, normals, many);
            loaded->sample(places, lights);
            for (std::size_t i = 0; i < many.size(); ++i) {
                const runtime::Vec3 one = loaded->irradiance(places[i], normals[i]);
                ASSERT_NEAR(many[i].x, one.x, 2e-3);
                ASSERT_NEAR(lights[i].irradiance.y, loaded->sample(places[i]).irradiance.y, 2e-3);
            }
        }
    }
}

TEST(SecondLobe, HasTexturesOfItsOwn) {
    for (const bool coloured : {false, true}) {
        const TemporaryFolder folder;
        const LightVolume volume = twoLobes(smallFrame(), coloured);
        const DenseWritten written = writeTextures(folder / "a.dds", volume, TextureFormat::Dds);
        EXPECT_EQ(written.files.size(), coloured ? 5u : 3u);
        const auto json = nlohmann::json::parse(bytesOf(folder / "a.dds.json"));
        EXPECT_EQ(json["texture_2"], "a_2.dds");
        EXPECT_EQ(json["rgb_texture_2"], coloured ? nlohmann::json("a_2_rgb.dds") : nlohmann::json(nullptr));
        EXPECT_EQ(json["lobe_axis"], (nlohmann::json{0, 0, -1}));
        // Halves of the first voxel, past the header: flux z is minus half of the first lobe's.
        const std::string first = bytesOf(folder / "a.dds"), second = bytesOf(folder / "a_2.dds");
        ASSERT_EQ(first.size(), second.size());
        EXPECT_NE(first, second);
        writeTextures(folder / "u.vf", volume, TextureFormat::UnityVf);
        EXPECT_FALSE(bytesOf(folder / "u_2_flux.vf").empty());
    }
}

TEST(SecondLobe, HasASliceAtlasOfItsOwn) {
    const TemporaryFolder folder;
    writeSliceAtlas(folder / "a.exr", twoLobes(smallFrame(), true));
    const auto json = nlohmann::json::parse(bytesOf(folder / "a.exr.json"));
    EXPECT_EQ(json["image_2"], "a_2.exr");
    EXPECT_EQ(json["rgb_image_2"], "a_2_rgb.exr");
    EXPECT_FALSE(bytesOf(folder / "a_2.exr").empty());
    EXPECT_FALSE(bytesOf(folder / "a_2_rgb.exr").empty());
    writeSliceAtlas(folder / "b.exr", testVolume(smallFrame(), false));
    EXPECT_EQ(nlohmann::json::parse(bytesOf(folder / "b.exr.json"))["image_2"], nullptr);
}

}  // namespace
}  // namespace photic
