// SPDX-License-Identifier: Apache-2.0
// Light under a wave, folds and cusps included: the slope of the error over three resolutions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bake/field/scene_grid.h"
#include "bake/scene/load_toml.h"
#include "bake/tubes/launch_domain.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

/// Cells a side of the launched patch that make the mesh twice as fine as the grid along x.
std::int64_t meshCells(const WaveScene& wave) {
    Monitor monitor;
    const Scene scene = parseScene(wave.toml(), "wave.toml", ".", 0, monitor);
    const LaunchDomain launched = launchDomain(scene, scene.surfaces[0], scene.lights[0], sceneFrame(scene));
    return static_cast<std::int64_t>(std::ceil((launched.max.x - launched.min.x) / (wave.voxel() / 2)));
}

void expectSlopes(int quadrature, double extinction) {
    std::vector<WaveErrors> errors;
    for (const int cells : {64, 128, 256}) {
        WaveScene scene;
        scene.cells = cells, scene.quadrature = quadrature, scene.extinction = extinction;
        const Baked baked = bakeText(scene.toml(), "beams", option("mesh", meshCells(scene)));
        errors.push_back(waveErrors(scene, baked, scene.truth()));
        const WaveErrors& e = errors.back();
        fmt::print(
            "  cells {:3} quadrature {} extinction {}: irradiance {:.3e} smooth, {:.3e} all; flux {:.3e}, {:.3e}; "
            "smooth share {:.2f}\n",
            cells, quadrature, extinction, e.irradiance_smooth, e.irradiance_all, e.flux_smooth, e.flux_all,
            e.smooth_share);
    }
    const auto slope = [&](double WaveErrors::*member) {
        return std::log2(errors[0].*member / (errors[2].*member)) / 2;
    };
    // Density is constant in a tube, so where a voxel's side cuts one the cut is misplaced by the square of the tube's width:
    // first order while mesh and grid are refined together. 1.8 is wanted where the map is smooth, and not met
    // (docs/accuracy.md, "What falls short"); these limits hold what there is.
    for (const auto member : {&WaveErrors::irradiance_smooth, &WaveErrors::flux_smooth, &WaveErrors::irradiance_all, &WaveErrors::flux_all}) {
        EXPECT_GE(slope(member), 0.85);
        EXPECT_LE(errors[2].*member, 5.5e-4);
    }
    EXPECT_GT(errors[0].smooth_share, 0.3);
    EXPECT_LT(errors[0].smooth_share, 0.95);  // caustics are there
}

TEST(WaveSlopes, BeamsConvergeThroughFoldsAndCusps) { expectSlopes(1, 0); }
TEST(WaveSlopes, BeamsWithFourPointsAcrossALayer) { expectSlopes(4, 0); }
TEST(WaveSlopes, BeamsInAbsorbingWater) { expectSlopes(1, 1.2); }

}  // namespace
}  // namespace photic
