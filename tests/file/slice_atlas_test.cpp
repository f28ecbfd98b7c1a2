// SPDX-License-Identifier: Apache-2.0
#include "bake/file/slice_atlas.h"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "bake/field/resample.h"
#include "bake/image/image.h"
#include "bake/report/error.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

using nlohmann::json;

// The sidecar against docs/schemas/atlas.md: names, types, and sums that must agree.
void expectValidSidecar(const json& j) {
    const std::set<std::string> names{
        "photic_atlas", "image",       "rgb_image",    "width",          "height",           "columns",   "rows",
        "slices",       "slice_width", "slice_height", "texel_of_voxel", "sample_position",  "channels",  "scale",
        "unit",         "up_axis",     "voxel_size",   "bounds_world",   "world_from_index", "index_min", "resampled",
        "metadata",     "image_2",     "rgb_image_2"};
    std::set<std::string> found;
    for (const auto& [key, value] : j.items()) found.insert(key);
    EXPECT_EQ(found, names);
    EXPECT_EQ(j["photic_atlas"], 1);
    EXPECT_EQ(j["width"].get<int>(), j["columns"].get<int>() * j["slice_width"].get<int>());
    EXPECT_EQ(j["height"].get<int>(), j["rows"].get<int>() * j["slice_height"].get<int>());
    EXPECT_GE(j["columns"].get<int>() * j["rows"].get<int>(), j["slices"].get<int>());
    EXPECT_LT(j["columns"].get<int>() * (j["rows"].get<int>() - 1), j["slices"].get<int>());
    EXPECT_EQ(j["sample_position"], "cell_centre");
    EXPECT_EQ(j["channels"]["A"], "irradiance_mean");
    EXPECT_EQ(j["world_from_index"].size(), 4u);
    const int n[3] = {j["slice_width"], j["slice_height"], j["slices"]};
    for (int a = 0; a < 3; ++a) {
        const std::size_t s = static_cast<std::size_t>(a);
        const double low = j["bounds_world"]["min"][s], high = j["bounds_world"]["max"][s], h = j["voxel_size"][s];
        EXPECT_NEAR(high - low, n[a] * h, 1e-9);
        EXPECT_NEAR(j["world_from_index"][s][3].get<double>(), low + 0.5 * h, 1e-12);
        EXPECT_NEAR(j["world_from_index"][s][s].get<double>(), h, 1e-12);
    }
}

// Reads texels the way the documentation tells a stranger to.
struct Atlas {
    json sidecar;
    Image image, rgb;
    explicit Atlas(const TemporaryFolder& folder)
        : sidecar(json::parse(bytesOf(folder / "light.exr.json"))),
          image(readExr(folder / sidecar["image"].get<std::string>())) {
        if (!sidecar["rgb_image"].is_null()) rgb = readExr(folder / sidecar["rgb_image"].get<std::string>());
    }
    double texel(const Image& from, int i, int j, int k, int c) const {
        const int columns = sidecar["columns"], w = sidecar["slice_width"], h = sidecar["slice_height"];
        return double(from.at(k % columns * w + i, k / columns * h + j, c)) * sidecar["scale"].get<double>();
    }
    glm::dvec3 world(int i, int j, int k) const {
        const auto& m = sidecar["world_from_index"];
        return {m[0][0].get<double>() * i + m[0][3].get<double>(), m[1][1].get<double>() * j + m[1][3].get<double>(),
                m[2][2].get<double>() * k + m[2][3].get<double>()};
    }
};

TEST(SliceAtlas, HoldsTheLightOfEveryVoxelCropped) {
    for (const bool coloured : {false, true}) {
        const TemporaryFolder folder;
        LightVolume volume = testVolume(straightFrame({-9, 3, -20}, {14, 17, 3}, 1.0 / 64), coloured,
                                        [](const glm::ivec3& v) { return v.x >= -5 && v.x <= 9 && v.z > -12; });
        volume.metadata["method"] = "beams";
        writeSliceAtlas(folder / "light.exr", volume);
        EXPECT_EQ(folder.fileCount(), coloured ? 3u : 2u);
        const Atlas atlas(folder);
        expectValidSidecar(atlas.sidecar);
        EXPECT_EQ(atlas.sidecar["slice_width"], 15);
        EXPECT_EQ(atlas.sidecar["slice_height"], 15);
        EXPECT_EQ(atlas.sidecar["slices"], 15);
        EXPECT_EQ(atlas.sidecar["index_min"], json({-5, 3, -11}));
        EXPECT_EQ(atlas.sidecar["resampled"], false);
        EXPECT_EQ(atlas.sidecar["metadata"]["method"], "beams");
        EXPECT_EQ(atlas.sidecar["rgb_image"].is_null(), !coloured);
        ASSERT_EQ(atlas.image.width, atlas.sidecar["width"].get<int>());
        ASSERT_EQ(atlas.image.height, atlas.sidecar["height"].get<int>());
        for (int i = 0; i < 15; ++i)
            for (int j = 0; j < 15; ++j)
                for (int k = 0; k < 15; ++k) {
                    const TestLight light = testLight(atlas.world(i, j, k));
                    ASSERT_NEAR(atlas.texel(atlas.image, i, j, k, 3), light.mean(), 1e-3 * light.mean());
                    for (int a = 0; a < 3; ++a)
                        ASSERT_NEAR(atlas.texel(atlas.image, i, j, k, a), light.mean() * light.direction[a],
                                    1e-3 * light.mean());
                    if (coloured) {
                        ASSERT_NEAR(atlas.texel(atlas.rgb, i, j, k, 2), light.blue, 1e-3 * light.blue);
                    }
                }
    }
}

TEST(SliceAtlas, ShearedGridsAreResampledAtSecondOrder) {
    // Light at the interior points of a leaning grid against the same light where it belongs, for three resolutions.
    std::vector<double> error;
    for (const int n : {8, 16, 32}) {
        const TemporaryFolder folder;
        const LightVolume volume =
            testVolume(leaningFrame(glm::ivec3(-n), glm::ivec3(n - 1, n - 1, n / 2), 2.0 / n), false);
        const LightField straight = resampledToAxes(volume.field);
        EXPECT_TRUE(straight.frame().axisAligned());
        writeSliceAtlas(folder / "light.exr", volume);
        const Atlas atlas(folder);
        expectValidSidecar(atlas.sidecar);
        EXPECT_EQ(atlas.sidecar["resampled"], true);
        double sum = 0;
        int count = 0;
        const auto& f = straight.frame();
        for (int x = f.min.x; x <= f.max.x; ++x)
            for (int y = f.min.y; y <= f.max.y; ++y)
                for (int z = f.min.z; z <= f.max.z; ++z) {
                    const glm::dvec3 p = f.worldFromIndex({x, y, z});
                    if (glm::length(p) > 0.7) continue;
                    const TestLight light = testLight(p);
                    sum += glm::length(straight.flux({x, y, z}) - light.mean() * light.direction) / light.mean();
                    ++count;
                }
        ASSERT_GT(count, 20);
        error.push_back(sum / count);
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 1.8);
    EXPECT_GT(std::log2(error[1] / error[2]), 1.8);
}

TEST(SliceAtlas, TooLargeIsRefusedWithAVoxelSizeThatFits) {
    // One lit voxel at each end: 70000 texels wide.
    const TemporaryFolder folder;
    LightVolume volume = testVolume(straightFrame({0, 0, 0}, {69999, 7, 7}, 0.001), false,
                                    [](const glm::ivec3& v) { return v.x % 69999 == 0; });
    try {
        writeSliceAtlas(folder / "light.exr", volume);
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::Input);
        const std::string message = e.what();
        const auto at = message.find("voxel_size = ");
        ASSERT_NE(at, std::string::npos) << message;
        const double h = std::stod(message.substr(at + 13));
        EXPECT_GE(h, 70.0 / 16384);
        EXPECT_LT(h, 1.1 * 70.0 / 16384);
    }
    EXPECT_EQ(folder.fileCount(), 0u);
    // A single long row of slices must be folded.
    volume = testVolume(straightFrame({0, 0, 0}, {63, 63, 999}, 0.001), false,
                        [](const glm::ivec3& v) { return v.x % 63 == 0 && v.y % 63 == 0 && v.z % 999 == 0; });
    writeSliceAtlas(folder / "light.exr", volume);
    expectValidSidecar(Atlas(folder).sidecar);
}

TEST(SliceAtlas, FramesThatAreLitElsewhereShareALayout) {
    const TemporaryFolder folder;
    const auto frame = straightFrame({-8, -8, -8}, {23, 23, 23}, 0.1);
    const LightVolume left = testVolume(frame, false, [](const glm::ivec3& v) { return v.x < 0 && v.y == 4; });
    const LightVolume right = testVolume(frame, false, [](const glm::ivec3& v) { return v.x > 12 && v.z == 2; });
    const LightVolume dark = testVolume(frame, false, [](const glm::ivec3&) { return false; });
    EXPECT_FALSE(litBox(dark));
    EXPECT_FALSE(together({}, {}));
    const auto box = together(together({}, litBox(left)), together(litBox(dark), litBox(right)));
    ASSERT_TRUE(box);
    EXPECT_EQ(box->min, glm::ivec3(-8, -8, -8));
    EXPECT_EQ(box->max, glm::ivec3(23, 23, 23));
    double lit = 0;
    for (const LightVolume* volume : {&left, &right, &dark}) {
        writeSliceAtlas(folder / "light.exr", *volume, box);
        const Atlas atlas(folder);
        expectValidSidecar(atlas.sidecar);
        EXPECT_EQ(atlas.sidecar["index_min"], json({-8, -8, -8}));
        EXPECT_EQ(atlas.sidecar["slices"], 32);
        for (int i = 0; i < 32; ++i) {
            const glm::ivec3 voxel(i - 8, 4, 2);
            const bool is_lit = volume == &left ? voxel.x < 0 : volume == &right && voxel.x > 12;
            const double expected = is_lit ? testLight(atlas.world(i, 12, 10)).mean() : 0.0;
            ASSERT_NEAR(atlas.texel(atlas.image, i, 12, 10, 3), expected, 1e-3 * expected) << i;
            lit += expected;
        }
    }
    EXPECT_GT(lit, 0);
}

TEST(SliceAtlas, DarkVolumesAndUnwritableFolders) {
    const TemporaryFolder folder;
    const LightVolume dark =
        testVolume(straightFrame({3, 4, 5}, {9, 9, 9}, 0.1), false, [](const glm::ivec3&) { return false; });
    writeSliceAtlas(folder / "light.exr", dark);
    const Atlas atlas(folder);
    expectValidSidecar(atlas.sidecar);
    EXPECT_EQ(atlas.sidecar["width"], 1);
    EXPECT_THROW(writeSliceAtlas(folder / "no/light.exr", dark), Error);
}

}  // namespace
}  // namespace photic
