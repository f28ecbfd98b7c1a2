// SPDX-License-Identifier: Apache-2.0
// Plane pulses onto the absorbing layer at 0 to 45 degrees, against the same waves in a box that ends later.
#include "bake/numerics/wave_absorber.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/numerics/wave_support.h"

namespace photic {
namespace {

using namespace wave_test;

/// A wide beam that runs down at an angle onto the bottom; `extra` more blocks below it.
struct Beam {
    double angle_deg = 0;
    WaveAbsorber absorber = WaveAbsorber::Pml;
    int sponge_cells = 8;
};
constexpr int kColumns = 44, kRows = 12;

double waveAt(const WaveStepper& stepper, const WaveGrid& grid, int x, int from_top) {
    const int z = grid.blocks.z * kWaveSide - 1 - from_top;
    const Place p = placeOf(grid, {x, 3, z});
    return stepper.value(p.block, p.cell);
}

/// Reflected over arriving energy [dB]: what differs from the deeper box, in the cells above the layer.
double reflection(const Beam& beam) {
    const double angle = beam.angle_deg * std::numbers::pi / 180;
    const glm::dvec3 direction(std::sin(angle), 0, -std::cos(angle));
    const WavePulse pulse = WavePulse::ofWavelength(10);
    const auto stepperFor = [&](WaveGrid& grid, int extra) {
        grid.blocks = {kColumns, 1, kRows + extra};
        grid.periodic = {false, true, false};
        WaveSource source = planeFromTop(grid, direction, pulse);
        // A beam: a plane pulse whose height falls off to the sides, so that its ends do not matter.
        const double middle = 0.5 * kColumns * kWaveSide - 0.5 * kRows * kWaveSide * std::tan(angle), width = 34;
        for (WaveDriven& d : source.driven) {
            const double x = grid.place(d.block).x * kWaveSide + (d.cell >> 6);
            d.amplitude = static_cast<float>(std::exp(-0.5 * std::pow((x - middle) / width, 2)));
        }
        WaveSettings settings;
        settings.sum = WaveSum::Nothing, settings.sparse = false;
        settings.absorber = beam.absorber, settings.sponge_cells = beam.sponge_cells;
        return std::make_unique<WaveStepper>(grid, settings, std::move(source), std::vector<std::uint8_t>{}, nowhere());
    };
    WaveGrid grid, deeper_grid;
    const auto stepper = stepperFor(grid, 0), deeper = stepperFor(deeper_grid, 10);
    const int low = kRows * kWaveSide - std::max(beam.absorber == WaveAbsorber::Pml ? 8 : beam.sponge_cells, 8) - 2;
    double arriving = 0, reflected = 0;
    const double end = kRows * kWaveSide / std::cos(angle) + 60;
    while (stepper->time() < end) {
        stepper->step(), deeper->step();
        if (stepper->counts().steps % 8 != 0) continue;
        for (int x = 80; x < kColumns * kWaveSide - 80; ++x)
            for (int z = low - 24; z < low; ++z) {
                const double a = waveAt(*deeper, deeper_grid, x, z), b = waveAt(*stepper, grid, x, z) - a;
                arriving += a * a, reflected += b * b;
            }
    }
    EXPECT_GT(arriving, 1);
    return 10 * std::log10(reflected / arriving);
}

TEST(WaveAbsorber, TheMatchedLayerReflectsLessThan60Decibels) {
    for (const double angle : {0.0, 15.0, 30.0, 45.0}) {
        const double db = reflection({angle});
        fmt::print("  PML, 8 cells, {:2.0f} degrees: {:.1f} dB\n", angle, db);
        EXPECT_LT(db, -60) << angle;
    }
}

TEST(WaveAbsorber, TheSpongeReflectsFarMore) {
    const double narrow = reflection({0, WaveAbsorber::Sponge, 8}), wide = reflection({0, WaveAbsorber::Sponge, 32});
    fmt::print("  sponge, 8 cells: {:.1f} dB, 32 cells: {:.1f} dB\n", narrow, wide);
    EXPECT_LT(narrow, -8);
    EXPECT_GT(narrow, -40);
    EXPECT_LT(wide, narrow - 5);
    EXPECT_GT(reflection({0, WaveAbsorber::Rigid}), -3) << "nothing absorbs";
}

}  // namespace
}  // namespace photic
