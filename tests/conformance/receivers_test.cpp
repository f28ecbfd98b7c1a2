// SPDX-License-Identifier: Apache-2.0
// What an artist sees: the pool's floor under a sun with a disc, looked up trilinearly in the volume.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "bake/field/prefilter.h"
#include "bake/picture/receiver_picture.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

using truth::pool3::SceneText;

/// Texels of the picture per pixel of the map, a side: the map holds means, a picture point values.
constexpr int kOver = 4;

struct Looked {
    double relative_l1 = 0;
    std::int64_t voxels = 0;
    glm::ivec3 size{0};
};

/// The pool with voxels of `cell` [m] that `where` asks for.
SceneText pool(double cell, const std::string& where) {
    SceneText text;
    text.voxel_size = cell;
    text.half = {1.03, 1.03};  // beyond the map, so that its rim is looked up between voxels too
    text.z_min = truth::pool3::kFloor - 4 * cell, text.z_max = 0.08;
    text.angular_diameter_deg = 0.53;
    text.objects =
        "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] }\nrole = \"receiver\"\n";
    text.bake = where;
    return text;
}
const char* const kBand = "where = \"receivers\"\nband = 2\n";

Looked lookUp(const SceneText& text, bool prefilter, const char* disc = "blur") {
    GivenOptions options = option("mesh", std::int64_t{1024});
    options["disc"] = {std::string(disc), "test"};
    Baked baked = bakeText(truth::pool3::sceneToml(text), "beams", options);
    if (prefilter) prefilterForTrilinear(baked.result.volume.field);
    Looked looked;
    looked.voxels = baked.field().needed().count();
    looked.size = baked.field().frame().size();

    const LightVolume& volume = baked.result.volume;
    PictureFrame frame;
    frame.origin = {-1, -1, truth::pool3::kFloor}, frame.across = {2, 0, 0}, frame.up = {0, 2, 0};
    frame.width = frame.height = 512 * kOver;
    const Image image = receiverPicture(volume, frame);
    std::vector<double> map(512 * 512);
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            map[static_cast<std::size_t>(y / kOver) * 512 + x / kOver] +=
                image.at(x, frame.height - 1 - y, 0) / double(kOver * kOver);
        }
    }
    looked.relative_l1 = truth::relativeL1(map, truth::pool3::exactDiscFloor().values);
    fmt::print(
        "  cell {:.2f} mm, layers {:.2f} mm, shear {}, disc {}, prefilter {}: {} voxels needed, relative L1 {:.4f}\n",
        1e3 * text.voxel_size, 1e3 * (text.layer_height > 0 ? text.layer_height : text.voxel_size), text.shear, disc,
        prefilter, looked.voxels, looked.relative_l1);
    return looked;
}

TEST(Receivers, PrefilteredCellsOfOne256thAreWithinFourPercent) {
    const SceneText text = pool(2.0 / 256, kBand);
    const Looked plain = lookUp(text, false, "sample"), filtered = lookUp(text, true, "sample");
    EXPECT_LE(filtered.relative_l1, 0.04);
    EXPECT_LT(filtered.relative_l1, plain.relative_l1) << "the prefilter does nothing";
    // One blur a layer takes the water for flat: a thirtieth of the price, and half a per cent more error.
    EXPECT_LE(lookUp(text, true, "blur").relative_l1, filtered.relative_l1 + 0.006);
}

TEST(Receivers, AFinerBandIsWithinOnePercent) {
    const Looked looked = lookUp(pool(2.0 / 1024, kBand), true);
    EXPECT_LE(looked.relative_l1, 0.01);
    EXPECT_LT(looked.voxels, 5'000'000);
}

TEST(Receivers, ShearedGridsAreFinerForAsManyVoxels) {
    // A slab of 1/4 m about the floor. Leaning layers may be several times as thick, which pays for narrower cells.
    const auto slab = [](double cell, double layer, const char* shear) {
        SceneText text = pool(cell, "");
        text.z_min = truth::pool3::kFloor - 0.125, text.z_max = truth::pool3::kFloor + 0.125;
        text.layer_height = layer, text.shear = shear;
        return text;
    };
    const Looked aligned = lookUp(slab(2.0 / 256, 0, "none"), true);
    // Leaning makes the frame some 0.1 m wider: cells 7 % wider than the layers alone would allow keep the count.
    const auto sheared = [&](int thicker) {
        return lookUp(slab(1.07 * 2.0 / 256 / std::sqrt(thicker), thicker * 2.0 / 256, "light"), true);
    };
    const Looked four = sheared(4), eight = sheared(8);
    for (const Looked& looked : {four, eight}) {
        EXPECT_LE(looked.voxels, aligned.voxels);
        EXPECT_GT(looked.voxels, 0.8 * static_cast<double>(aligned.voxels));
    }
    EXPECT_LT(four.relative_l1, 0.6 * aligned.relative_l1);
}

// Floor and wall of a pool below calm water, and what else stands in it.
std::string cornerPool(const std::string& floor, const std::string& wall, const std::string& more = "") {
    const std::string object = "[[object]]\nname = \"";
    return R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.55]
max = [0.55, 0.5, 0.05]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0.3, 0.1, -0.8]
irradiance = 1000
angular_diameter = 0
[[surface]]
name = "water"
size = [4.0, 4.0]
outside = "flat"
flat = true
)" + object +
           "floor\"\n" + floor + "\n" + object + "wall\"\n" + wall + "\n" + more;
}
const char* const kFloorPlane = "plane = { point = [0, 0, -0.48], normal = [0, 0, 1] }";
const char* const kWallPlane = "plane = { point = [0.43, 0, 0], normal = [-1, 0, 0] }";

/// How far two bakes of the pool are apart [W/m2] around the corner, far from everything else (the sun comes over a
/// wall that ends at the water), and not farther behind floor and wall than a look-up on them reaches.
double mostApart(const Baked& truth, const Baked& other) {
    const GridFrame& f = truth.field().frame();
    double most = 0;
    int behind_both = 0;
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) {
                const glm::dvec3 place = f.worldFromIndex(glm::dvec3(i, j, k));
                if (place.x < 0.1 || place.y < 0 || place.x > 0.43 + 0.05) continue;
                if (place.z > -0.3 || place.z < -0.48 - 0.05) continue;
                most = std::max(most, std::fabs(other.irradiance(i, j, k) - truth.irradiance(i, j, k)));
                behind_both += place.x > 0.43 && place.z < -0.48 && truth.irradiance(i, j, k) > 900;
            }
    EXPECT_GT(behind_both, 5);
    return most;
}
constexpr double kMostApart = 5;  // [W/m2], of 948: half a per cent

// A look-up in the corner of floor and wall mixes the voxels behind both. They stayed dark as soon as a body stood
// anywhere in the pool, and the corner was a fifth too dark.
TEST(Receivers, CornersAreLitWhateverElseStands) {
    const std::string ball = R"([[object]]
name = "ball"
sphere = { center = [-0.35, -0.35, -0.3], radius = 0.06 }
)";
    EXPECT_LT(mostApart(bakeText(cornerPool(kFloorPlane, kWallPlane), "beams"),
                        bakeText(cornerPool(kFloorPlane, kWallPlane, ball), "beams")),
              kMostApart);
}

// The same where floor and wall are bodies that touch or overlap.
TEST(Receivers, CornersOfBodiesAreLitAsThoseOfPlanes) {
    const Baked truth = bakeText(cornerPool(kFloorPlane, kWallPlane), "beams");
    const char* const floor = "box = { min = [-2, -2, -2], max = [2, 2, -0.48] }";
    const char* const standing = "box = { min = [0.43, -2, -0.48], max = [2, 2, -0.001] }";
    const char* const sunk = "box = { min = [0.43, -2, -2.5], max = [2, 2, -0.001] }";
    for (const auto& [a, b] :
         {std::pair{floor, standing}, {floor, sunk}, {kFloorPlane, standing}, {kFloorPlane, sunk}, {floor, kWallPlane}})
        EXPECT_LT(mostApart(truth, bakeText(cornerPool(a, b), "beams")), kMostApart) << a << " and " << b;
}

}  // namespace
}  // namespace photic
