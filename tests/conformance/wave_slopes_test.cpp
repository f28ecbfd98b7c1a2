// SPDX-License-Identifier: Apache-2.0
// Light under a wave, folds and cusps included: the slope of the error over three resolutions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

struct Limits {
    double smooth, all;
};

void expectSlopes(int quadrature, double extinction, Limits limits) {
    std::vector<WaveErrors> errors;
    for (const int cells : {64, 128, 256}) {
        WaveScene scene;
        scene.cells = cells, scene.quadrature = quadrature, scene.extinction = extinction;
        // The mesh is twice as fine as the grid.
        const Baked baked = bakeText(scene.toml(), "beams", option("spacing", 0.5));
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
    EXPECT_GE(slope(&WaveErrors::irradiance_smooth), limits.smooth);
    EXPECT_GE(slope(&WaveErrors::flux_smooth), limits.smooth);
    EXPECT_GE(slope(&WaveErrors::irradiance_all), limits.all);
    EXPECT_GE(slope(&WaveErrors::flux_all), limits.all);
    EXPECT_LE(errors[2].irradiance_all, 5.5e-4);
    EXPECT_GT(errors[0].smooth_share, 0.3);
    EXPECT_LT(errors[0].smooth_share, 0.95);  // caustics are there
}

// Where a voxel's side cuts a tube of constant density, the cut is misplaced by the square of the tube's width: first
// order while mesh and grid are refined together.
TEST(WaveSlopes, AreFirstOrder) { expectSlopes(1, 0, {1.0, 0.85}); }

}  // namespace
}  // namespace photic
