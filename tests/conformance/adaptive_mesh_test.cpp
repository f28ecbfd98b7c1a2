// SPDX-License-Identifier: Apache-2.0
// The default divides tubes where light bends most; a mesh of equal cells is what it must be worth its while against.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "bake/baker/bake_scene.h"
#include "bake/scene/load_toml.h"

namespace photic {
namespace {

BakedScene seaWithMesh(std::int64_t cells) {
    Monitor monitor;
    Scene scene = parseScene(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.8]
max = [0.5, 0.5, 0.1]
voxel_size = 0.03125
[[light]]
type = "sun"
direction = [0.433, 0.25, -0.866]
angular_diameter = 0
[[surface]]
name = "water"
size = [2, 2]
sea = { wind_speed = 3.0, fetch = 100.0, seed = 3, resolution = 64 }
[[object]]
name = "floor"
plane = { point = [0, 0, -0.75], normal = [0, 0, 1] }
)",
                             "sea.toml", ".", 0, monitor);
    scene.bake.method = "beams";
    scene.bake.method_options["beams"]["mesh"] = {cells, "test"};
    BakeChoices choices;
    choices.measure = Measure::Nothing;
    return bakeScene(scene, monitor, choices);
}

/// Mean difference of two volumes over the mean of the second.
double errorOf(const LightField& field, const LightField& truth) {
    double off = 0, all = 0;
    const GridFrame& frame = truth.frame();
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                off += std::fabs(double(field.value({x, y, z}, 0)) - double(truth.value({x, y, z}, 0)));
                all += double(truth.value({x, y, z}, 0));
            }
    return off / all;
}

TEST(AdaptiveMesh, IsBetterThanAnEvenOneOfAsManyTubes) {
    const BakedScene adaptive = seaWithMesh(0), truth = seaWithMesh(768);
    const auto cells = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(adaptive.report.tubes) / 2)));
    const BakedScene even = seaWithMesh(cells);
    ASSERT_LT(cells, 384) << "the truth is to be finer than both";
    EXPECT_GE(even.report.tubes, adaptive.report.tubes * 0.8);
    const double own = errorOf(adaptive.volume.field, truth.volume.field),
                 evenly = errorOf(even.volume.field, truth.volume.field);
    std::printf("  %lld tubes: off by %.3f %%, evenly by %.3f %%\n", static_cast<long long>(adaptive.report.tubes),
                100 * own, 100 * evenly);
    EXPECT_LT(own, evenly);
}

}  // namespace
}  // namespace photic
