// SPDX-License-Identifier: Apache-2.0
// The focused pool's floor against its exact map: as a thin layer of voxels, and as a picture of a receiver.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bake/picture/receiver_picture.h"
#include "bake/scene/load_toml.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

using truth::FloorMap;
using truth::pool3::SceneText;

/// One layer of 512 x 512 voxels centred on the floor. Layers are aligned to the world's origin, so its height is the
/// number near 1e-4 m that puts a centre at z = -1.5: at 2e-5 m off, light lands 1/200 of a pixel aside, which the
/// finest mesh would notice.
Baked bakeFloorLayer(std::int64_t mesh, const std::string& interpolation = "constant") {
    SceneText text;
    text.voxel_size = 2.0 / 512;
    text.layer_height = 1.5 / 14999.5;
    text.z_min = truth::pool3::kFloor - text.voxel_size, text.z_max = truth::pool3::kFloor + text.voxel_size;
    Monitor monitor;
    Scene scene = parseScene(truth::pool3::sceneToml(text), "pool3.toml", ".", 0, monitor);
    scene.domain.min.z = truth::pool3::kFloor - text.layer_height / 2;
    scene.domain.max.z = truth::pool3::kFloor + text.layer_height / 2;
    return bakeScene(std::move(scene), "beams", option("mesh", mesh) | option("interpolation", interpolation));
}

std::vector<double> layerMap(const Baked& baked) {
    const GridFrame& f = baked.field().frame();
    EXPECT_EQ(f.size(), glm::ivec3(512, 512, 1));
    EXPECT_NEAR(f.worldFromIndex(f.min).z, truth::pool3::kFloor, 1e-9);
    std::vector<double> map;
    for (int j = 0; j < 512; ++j) {
        for (int i = 0; i < 512; ++i) map.push_back(-baked.field().flux(f.min + glm::ivec3(i, j, 0)).z);
    }
    return map;
}

std::vector<double> pictureMap(const Baked& baked) {
    PictureFrame frame;
    frame.origin = {-1, -1, truth::pool3::kFloor}, frame.across = {2, 0, 0}, frame.up = {0, 2, 0};
    const Image image = receiverPicture(baked.result.volume, frame);
    std::vector<double> map;
    for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 512; ++x) map.push_back(image.at(x, 511 - y, 0));
    }
    return map;
}

struct Limit {
    std::int64_t mesh;
    double relative_l1;
};

class Pool3Floor : public ::testing::TestWithParam<Limit> {};

TEST_P(Pool3Floor, LayerAndPictureAreThoseOfTheMap) {
    const FloorMap exact = truth::pool3::exactFloor();
    Baked baked = bakeFloorLayer(GetParam().mesh);
    const double layer = truth::relativeL1(layerMap(baked), exact.values);
    const double rmse = truth::relativeRmse(layerMap(baked), exact.values);
    const double picture = truth::relativeL1(pictureMap(std::move(baked)), exact.values);
    fmt::print("  mesh {}: relative L1 {:.3e} as a layer, {:.3e} as a picture; relative RMSE {:.3e}\n", GetParam().mesh,
               layer, picture, rmse);
    EXPECT_LE(layer, GetParam().relative_l1);
    EXPECT_LE(picture, GetParam().relative_l1);
    EXPECT_GT(layer, 1e-6) << "nothing is exact: was the map compared with itself?";
}

INSTANTIATE_TEST_SUITE_P(Meshes, Pool3Floor,
                         ::testing::Values(Limit{512, 0.016}, Limit{1024, 0.004}, Limit{4096, 0.0005}),
                         [](const auto& row) { return std::to_string(row.param.mesh); });

// [Ernst et al. 2005, section 3.4] is smooth, and further off than constant density at every mesh: where triangles fold
// its denominator passes through 0.
TEST(Pool3Floor, ThePapersInterpolationIsFurtherOffAtEveryMesh) {
    const FloorMap exact = truth::pool3::exactFloor();
    double light = 0;
    for (const double value : exact.values) light += value;
    for (const std::int64_t mesh : {256, 512, 1024}) {
        const std::vector<double> paper = layerMap(bakeFloorLayer(mesh, "ernst")),
                                  ours = layerMap(bakeFloorLayer(mesh));
        double sum = 0;
        for (const double value : paper) sum += value;
        const double off = truth::relativeL1(paper, exact.values);
        fmt::print(
            "  mesh {}: relative L1 {:.2g}, relative RMSE {:.2g}, energy {:.3f}; constant density {:.2g}, {:.2g}\n",
            mesh, off, truth::relativeRmse(paper, exact.values), sum / light, truth::relativeL1(ours, exact.values),
            truth::relativeRmse(ours, exact.values));
        EXPECT_GT(off, 3 * truth::relativeL1(ours, exact.values));
        EXPECT_LT(off, 0.4);
    }
}

}  // namespace
}  // namespace photic
