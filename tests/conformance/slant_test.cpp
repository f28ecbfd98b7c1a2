// SPDX-License-Identifier: Apache-2.0
// Suns that stand low, and suns that are much fainter than others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

std::string waves(double voxel, const std::string& bake) {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.4, -0.4, -0.8]
max = [0.4, 0.4, 0.1]
voxel_size = {}
[[light]]
type = "sun"
direction = [0.7399421116938484, -0.6208851530148456, -0.2588190451025208]
angular_diameter = 0
[[surface]]
size = [5.0, 5.0]
outside = "none"
waves = [
  {{ amplitude = 0.012, wavelength = 0.9, direction = 65.0, phase = 1.1 }},
  {{ amplitude = 0.006, wavelength = 0.55, direction = -25.0, phase = 0.3 }},
  {{ amplitude = 0.003, wavelength = 0.33, direction = 140.0, phase = 2.2 }},
]
[bake]
{}
)",
                       voxel, bake);
}

/// Relative L1 of a bake against one of voxels half as large, whose layers are evaluated at four points each.
double deviation(const Baked& coarse, const Baked& fine) {
    const GridFrame& f = coarse.field().frame();
    double off = 0, all = 0;
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) {
                const glm::dvec3 low = f.worldFromIndex(glm::dvec3(i, j, k) - 0.25);
                const glm::ivec3 first = glm::ivec3(glm::floor(fine.field().frame().indexFromWorld(low) + 0.5));
                double mean = 0;
                for (int c = 0; c < 8; ++c)
                    mean += fine.irradiance(first.x + (c & 1), first.y + (c >> 1 & 1), first.z + (c >> 2)) / 8;
                off += std::fabs(coarse.irradiance(i, j, k) - mean), all += mean;
            }
    return off / all;
}

// A sun at 75 degrees moves on by a voxel from one layer to the next under water: with the layer's middle alone the
// volume is off by several per cent.
TEST(LowSun, VoxelsAreRightToOnePerCentByDefault) {
    const Baked fine = bakeText(waves(0.0125, "quadrature = 4\ntolerance = 0.1\n"), "beams");
    const double given = deviation(bakeText(waves(0.025, "tolerance = 0.25\n"), "beams"), fine);
    const double one = deviation(bakeText(waves(0.025, "quadrature = 1\n"), "beams"), fine);
    const double four = deviation(bakeText(waves(0.025, "quadrature = 4\n"), "beams"), fine);
    fmt::print("  off by {:.2f} % as given, {:.2f} % with one point, {:.2f} % with four\n", 100 * given, 100 * one,
               100 * four);
    EXPECT_LT(given, 0.01);
    EXPECT_GT(one, 0.03);
    EXPECT_EQ(given, four);
}

std::string suns(bool bright, bool dim) {
    std::string text = R"(photic = 1
[domain]
min = [-1, -0.25, -1]
max = [1, 0.25, 0.1]
voxel_size = 0.05
[[surface]]
size = [0.5, 1.0]
outside = "none"
waves = [{ amplitude = 0.01, wavelength = 0.4, direction = 20 }]
)";
    if (bright) text += "[[light]]\ntype = \"sun\"\ndirection = [1, 0, -0.5]\nirradiance = 1e6\nangular_diameter = 0\n";
    if (dim) text += "[[light]]\ntype = \"sun\"\ndirection = [-1, 0, -0.5]\nirradiance = 1.1\nangular_diameter = 0\n";
    return text;
}

// A light of a millionth of another, the least that may be given beside it, where it is alone.
TEST(FaintSun, IsKeptBesideABrightOne) {
    const Baked both = bakeText(suns(true, true), "beams"), dim = bakeText(suns(false, true), "beams");
    const Baked bright = bakeText(suns(true, false), "beams");
    const GridFrame& f = both.field().frame();
    double sum = 0, alone = 0;
    int voxels = 0;
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) {
                if (bright.irradiance(i, j, k) > 0) continue;
                sum += both.irradiance(i, j, k), alone += dim.irradiance(i, j, k);
                voxels += dim.irradiance(i, j, k) > 0;
            }
    EXPECT_GT(voxels, 300);
    EXPECT_NEAR(sum / alone, 1, 1e-5);
    EXPECT_LT(both.result.report.path.imbalance(), 1e-6);
}

}  // namespace
}  // namespace photic
