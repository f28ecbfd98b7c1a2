// SPDX-License-Identifier: Apache-2.0
// Light on the receivers of examples/glass against photons that are counted where they land, on both sides.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bake/baker/bake_scene.h"
#include "bake/field/scene_grid.h"
#include "bake/scene/load_toml.h"
#include "tests/support/landed_light.h"

namespace photic {
namespace {

using support::Agreement;
using support::LookedAt;

struct Example {
    const char* name;
    double voxels = 1;  ///< of the example's own size
    double texel = 8;   ///< of the example's own voxels
    int fine = 16;      ///< parts of a texel's side that tubes are laid in without voxels
    std::int64_t photons = 4'000'000;
    /// What look-ups and tubes may be off by beyond the photons' noise.
    double look_ups = 0.01, tubes = 0.005;
};

Scene exampleScene(const Example& example) {
    Monitor quiet;
    Scene scene = loadScene(fmt::format("{}/examples/glass/{}.toml", PHOTIC_SOURCE_DIR, example.name), 0, quiet);
    scene.domain.voxel_size *= example.voxels, scene.domain.layer_height = 0;
    for (Light& light : scene.lights) light.angular_diameter_deg = 0;
    if (example.voxels < 0.5) scene.bake.where = Where::Receivers;
    return scene;
}

/// What tubes bring to the texels themselves, without voxels: texels cut into `fine` a side, which are narrow beside
/// what the light does.
std::vector<double> lightOnTexels(const Scene& scene, const LookedAt& plane, const std::vector<double>& looked_at,
                                  int fine) {
    Monitor quiet;
    PlaneTexels texels = plane.texels;
    texels.right /= double(fine), texels.up /= double(fine), texels.columns *= fine, texels.rows *= fine;
    const std::vector<float> light = planeIrradiance(scene, texels, 0.1 * texels.side(), quiet);
    std::vector<double> means(looked_at);
    for (int j = 0; j < plane.texels.rows; ++j)
        for (int i = 0; i < plane.texels.columns; ++i) {
            double& mean = means[static_cast<std::size_t>(j * plane.texels.columns + i)];
            if (!std::isfinite(mean)) continue;
            mean = 0;
            for (int b = 0; b < fine; ++b)
                for (int a = 0; a < fine; ++a)
                    mean += double(light[static_cast<std::size_t>((j * fine + b) * texels.columns + i * fine + a)]) /
                            (fine * fine);
        }
    return means;
}

class LandedLight : public testing::TestWithParam<Example> {};

TEST_P(LandedLight, ReceiversGetWhatPhotonsBring) {
    const Example example = GetParam();
    const Scene scene = exampleScene(example);
    Monitor quiet;
    BakeChoices choices;
    choices.measure = Measure::Nothing;
    const BakedScene baked = bakeScene(scene, quiet, choices);
    EXPECT_LT(baked.report.power.imbalance(), 1e-5);
    EXPECT_LT(baked.report.path.imbalance(), 1e-5);
    std::vector<LookedAt> planes = support::planesOf(scene, example.texel / example.voxels);
    std::erase_if(planes, [](const LookedAt& p) { return p.name.starts_with("card"); });
    std::vector<PlaneTexels> texels;
    for (const LookedAt& plane : planes) texels.push_back(plane.texels);
    support::LandedOptions landing;
    landing.count = example.photons;
    const auto landed = support::landedLight(scene, sceneFrame(scene), texels, landing);
    for (std::size_t k = 0; k < planes.size(); ++k) {
        SCOPED_TRACE(planes[k].name);
        const std::vector<double> found = support::lookedUpLight(scene, baked.volume, planes[k], true);
        const Agreement look_ups = support::agreementOf(found, landed[k].front);
        const Agreement on_them =
            support::agreementOf(lightOnTexels(scene, planes[k], found, example.fine), landed[k].front);
        ASSERT_GT(look_ups.light, 0);
        fmt::print("  {}: photons' noise {:.2f} %, look-ups off by {:.2f} %, tubes on the texels by {:.2f} %\n",
                   planes[k].name, 100 * look_ups.noise, 100 * look_ups.apart, 100 * on_them.apart);
        EXPECT_LT(look_ups.noise, 0.025);
        EXPECT_LT(look_ups.apart, look_ups.noise + example.look_ups);
        EXPECT_LT(on_them.apart, on_them.noise + example.tubes);
        const std::vector<double> behind = support::lookedUpLight(scene, baked.volume, planes[k], false);
        const Agreement back = support::agreementOf(behind, landed[k].back);
        EXPECT_EQ(back.light, 0) << "nothing comes through what blocks light";
        EXPECT_LT(back.found, 1e-3 * look_ups.light);
    }
}

INSTANTIATE_TEST_SUITE_P(Glass, LandedLight,
                         testing::Values(Example{"glass_ball"}, Example{"ring", 0.5, 4}, Example{"mirror_sphere"},
                                         Example{"prism"}, Example{"lens_check"},
                                         // Each facet throws a beam with sharp edges, three of the example's voxels
                                         // wide, and between its mirrors light falls through gaps of 4 mm.
                                         Example{"discoball", 0.25, 8, 64},
                                         // Threads of light that are finer than the voxels.
                                         Example{"wine_glass", 1, 8, 16, 1'000'000, 0.05, 0.03},
                                         Example{"aquarium", 1, 8, 8, 500'000, 0.02, 0.05}),
                         [](const auto& example) { return std::string(example.param.name); });

}  // namespace
}  // namespace photic
