// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_stepper.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "bake/numerics/wave_calibration.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/numerics/wave_support.h"

namespace photic {
namespace {

using namespace wave_test;
constexpr double kPi = std::numbers::pi;

/// A standing wave of a periodic box after many steps, against what the scheme's own dispersion says of it.
double standingWaveError(int order, double courant, const glm::ivec3& waves) {
    WaveGrid grid;
    grid.blocks = glm::ivec3(2);
    grid.spacing = glm::dvec3(1.0 / 16);
    grid.periodic = {true, true, true};
    const auto shape = [&](int x, int y, int z) {
        return std::cos(2 * kPi * glm::dot(glm::dvec3(waves), glm::dvec3(x, y, z)) / 16);
    };
    WaveSource source;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        const int x = i >> 8, y = i >> 4 & 15, z = i & 15;
        const Place p = placeOf(grid, {x, y, z});
        source.start.push_back({p.block, static_cast<std::uint16_t>(p.cell), static_cast<float>(shape(x, y, z))});
    }
    WaveSettings settings;
    settings.order = order, settings.courant = courant, settings.sum = WaveSum::Nothing;
    WaveStepper stepper(grid, settings, source, {}, nowhere());
    for (int i = 0; i < 120; ++i) stepper.step();
    // The frequency whose wavenumber is that of the box.
    const double k = 2 * kPi * glm::length(glm::dvec3(waves)), dt = stepper.dt();
    double low = 0, high = 2 * k;
    for (int i = 0; i < 60; ++i) {
        const double w = 0.5 * (low + high),
                     found = schemeWavenumber(w, {dt, grid.spacing, order}, glm::normalize(glm::dvec3(waves)));
        (found != 0 && found < k ? low : high) = w;
    }
    // Equal values at times -dt and 0: the wave's top is half a step earlier.
    const double expected = std::cos(low * (stepper.time() + 0.5 * dt)) / std::cos(0.5 * low * dt);
    double worst = 0;
    for (int i = 0; i < 16 * 16 * 16; i += 5) {
        const int x = i >> 8, y = i >> 4 & 15, z = i & 15;
        const Place p = placeOf(grid, {x, y, z});
        worst = std::max(worst, std::fabs(stepper.value(p.block, p.cell) - expected * shape(x, y, z)));
    }
    return worst;
}

TEST(WaveStepper, FollowsItsOwnDispersion) {
    for (const int order : {2, 4})
        for (const glm::ivec3& waves : {glm::ivec3(1, 0, 0), glm::ivec3(0, 1, 2), glm::ivec3(2, 1, 1)})
            EXPECT_LT(standingWaveError(order, 0.7, waves), 2e-4) << order << " " << waves.x << waves.y << waves.z;
}

TEST(WaveStepper, FourthOrderInSpaceSecondInTime) {
    // Relative error of the wavenumber as cells and steps shrink.
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.2, 0.9));
    const auto error = [&](double h, double dt, int order) {
        return std::fabs(schemeWavenumber(1, {dt, glm::dvec3(h), order}, direction) - 1);
    };
    const auto slope = [](double coarse, double fine) { return std::log2(coarse / fine); };
    EXPECT_NEAR(slope(error(0.4, 1e-4, 4), error(0.2, 1e-4, 4)), 4, 0.1);
    EXPECT_NEAR(slope(error(0.2, 1e-4, 4), error(0.1, 1e-4, 4)), 4, 0.1);
    EXPECT_NEAR(slope(error(0.4, 1e-4, 2), error(0.2, 1e-4, 2)), 2, 0.1);
    EXPECT_NEAR(slope(error(0.01, 0.2, 4), error(0.01, 0.1, 4)), 2, 0.1);
    EXPECT_EQ(schemeWavenumber(40, {0.01, glm::dvec3(0.2), 4}, direction), 0) << "shorter than the grid holds";
}

TEST(WaveStepper, StepsBeyondTheLimitAreRefused) {
    WaveGrid grid;
    grid.blocks = {2, 2, 2};
    EXPECT_NEAR(WaveStepper::largestStep(glm::dvec3(1), 4), 0.5, 1e-12);
    EXPECT_NEAR(WaveStepper::largestStep(glm::dvec3(1), 2), 1 / std::sqrt(3.0), 1e-12);
    WaveSettings settings;
    for (const double courant : {1.01, 0.0, -1.0, std::nan("")}) {
        settings.courant = courant;
        EXPECT_THROW(WaveStepper(grid, settings, {}, {}, nowhere()), Error) << courant;
    }
    settings.courant = 1;
    EXPECT_NO_THROW(WaveStepper(grid, settings, {}, {}, nowhere()));
    settings.order = 3;
    EXPECT_THROW(WaveStepper(grid, settings, {}, {}, nowhere()), Error);
}

TEST(WaveStepper, TheLimitIsWhereItBlowsUp) {
    // The shortest wave of the grid, at 1.01 times the largest step: cells shrunk behind the stepper's back.
    const auto growth = [](double courant) {
        WaveGrid grid;
        grid.blocks = {2, 2, 2};
        grid.periodic = {true, true, true};
        WaveSource source;
        for (int b = 0; b < 8; ++b)
            for (int c = 0; c < kWaveCells; ++c)
                source.start.push_back(
                    {b, static_cast<std::uint16_t>(c), ((c >> 6) + (c >> 3) + c) % 2 ? 1e-3f : -1e-3f});
        WaveBlock block;
        std::vector<float> field(2 * kWaveCells);
        for (const WaveStart& s : source.start)
            if (s.block == 0) field[s.cell] = field[kWaveCells + s.cell] = s.value;
        WaveWeights w;
        for (std::size_t a = 0; a < 3; ++a)
            w.d.second_0[a] = -2.5f, w.d.second_1[a] = 4.0f / 3, w.d.second_2[a] = -1.0f / 12;
        w.scale = static_cast<float>(std::pow(courant * WaveStepper::largestStep(glm::dvec3(1), 4), 2));
        for (int step = 0; step < 200; ++step) {
            block.now = field.data() + (step & 1) * kWaveCells,
            block.other = field.data() + (1 - (step & 1)) * kWaveCells;
            block.side.fill(block.now);  // periodic in itself
            waveKernels().step[0][0](block, w);
        }
        return std::fabs(field[0]);
    };
    EXPECT_LT(growth(0.99), 1);
    EXPECT_GT(growth(1.01), 1e3);
}

TEST(WaveStepper, EnergyIsKeptInAClosedBox) {
    WaveGrid grid;
    grid.blocks = {4, 4, 4};
    WaveSettings settings;
    settings.absorber = WaveAbsorber::Rigid, settings.sum = WaveSum::Nothing, settings.sparse = false;
    WaveStepper stepper(grid, settings, bumpAt(grid, {14.3, 15.1, 16.2}, 1.5), {}, nowhere());
    stepper.step();
    const double before = stepper.energy();
    for (int i = 0; i < 600; ++i) stepper.step();
    EXPECT_GT(before, 1);
    EXPECT_NEAR(stepper.energy() / before, 1, 1e-4);
}

TEST(WaveStepper, EnergyNeverGrows) {
    for (const WaveAbsorber absorber : {WaveAbsorber::Pml, WaveAbsorber::Sponge}) {
        WaveGrid grid;
        grid.blocks = {6, 5, 6};
        WaveSettings settings;
        settings.absorber = absorber, settings.sponge_cells = 8, settings.sum = WaveSum::Nothing, settings.courant = 1;
        settings.sparse = false;
        WaveStepper stepper(grid, settings, bumpAt(grid, {24, 20, 24}, 1.2), {}, nowhere());
        stepper.step();
        const double start = stepper.energy();
        double energy = start;
        for (int i = 0; i < 4000; ++i) {
            stepper.step();
            if (i % 4 != 0 && i > 400) continue;
            const double now = stepper.energy();
            // What the layer's memory gives back is a millionth.
            ASSERT_LE(now, energy * (1 + 1e-5) + 1e-6 * start) << "step " << i;
            energy = now;
        }
        EXPECT_LT(energy, absorber == WaveAbsorber::Pml ? 1e-5 * start : 0.02 * start);
    }
}

TEST(WaveStepper, DampingTakesEnergyAsItShould) {
    // phi_tt + 2 gamma phi_t: energy falls as exp(-2 gamma t).
    WaveGrid grid;
    grid.blocks = {4, 4, 4};
    grid.periodic = {true, true, true};
    WaveSettings settings;
    settings.sum = WaveSum::Nothing, settings.damping = 0.01, settings.courant = 0.5;
    WaveStepper stepper(grid, settings, bumpAt(grid, {15, 16, 17}, 2), {}, nowhere());
    for (int i = 0; i < 20; ++i) stepper.step();
    const double before = stepper.energy(), from = stepper.time();
    for (int i = 0; i < 200; ++i) stepper.step();
    EXPECT_NEAR(std::log(before / stepper.energy()), 2 * 0.01 * (stepper.time() - from), 0.04);
}

/// Random blocks, stepped by two kernels.
TEST(WaveKernels, AllInstructionSetsAgree) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto noise = [&](std::size_t count) {
        std::vector<float> v(count);
        for (float& x : v) x = uniform(random);
        return v;
    };
    const std::vector<float> now = noise(512), before = noise(512), sums = noise(2048);
    std::vector<std::vector<float>> sides;
    for (int i = 0; i < 6; ++i) sides.push_back(noise(512));
    WaveWeights w;
    for (std::size_t a = 0; a < 3; ++a) {
        const float s = 1 + 0.2f * static_cast<float>(a);
        w.d.first_1[a] = 0.66f * s, w.d.first_2[a] = -0.08f * s;
        w.d.second_0[a] = -2.5f * s, w.d.second_1[a] = 1.33f * s, w.d.second_2[a] = -0.08f * s;
    }
    w.scale = 0.2f, w.keep = 0.95f, w.lose = 0.9f, w.per_two_steps = 1.1f;
    const auto run = [&](InstructionSet set, int look, int sum, std::array<float, 6>& largest) {
        std::vector<float> other = before, total = sums;
        WaveBlock block;
        block.now = now.data(), block.other = other.data(), block.sums = total.data(), block.largest = &largest;
        for (std::size_t i = 0; i < 6; ++i) block.side[i] = sides[i].data();
        waveKernels(set).step[look][sum](block, w);
        other.insert(other.end(), total.begin(), total.end());
        return other;
    };
    for (const InstructionSet set : instructionSets())
        for (int sum = 0; sum < 3; ++sum) {
            std::array<float, 6> a{}, b{};
            const auto one = run(InstructionSet::Portable, 1, sum, a), two = run(set, 1, sum, b);
            for (std::size_t i = 0; i < one.size(); ++i)
                ASSERT_NEAR(one[i], two[i], 3e-5) << waveKernels(set).name << i;
            for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], 1e-5);
            EXPECT_GT(a[0], 0.5f);
            EXPECT_EQ(two, run(set, 0, sum, b)) << "looking changes the step";
        }
}

TEST(WaveBand, HoldsTheWavesAndLittleElse) {
    WaveGrid grid;
    grid.blocks = {14, 14, 14};
    WaveSettings settings;
    settings.sum = WaveSum::Nothing;
    const auto run = [&](bool sparse) {
        settings.sparse = sparse;
        WaveStepper stepper(grid, settings, bumpAt(grid, {56, 56, 56}, 2), {}, nowhere());
        for (int i = 0; i < 80; ++i) stepper.step();
        std::vector<float> values;
        for (int b = 0; b < grid.count(); ++b)
            for (int c = 0; c < kWaveCells; c += 7) values.push_back(stepper.value(b, c));
        return std::pair(values, stepper.counts());
    };
    const auto [dense, all] = run(false);
    const auto [band, some] = run(true);
    double worst = 0, most = 0;
    for (std::size_t i = 0; i < dense.size(); ++i)
        worst = std::max(worst, double(std::fabs(dense[i] - band[i]))),
        most = std::max(most, double(std::fabs(dense[i])));
    EXPECT_GT(most, 0.01);
    EXPECT_LT(worst, 3 * settings.threshold);
    EXPECT_EQ(all.block_steps, all.blocks * all.steps);
    EXPECT_LT(static_cast<double>(some.block_steps), 0.6 * static_cast<double>(all.block_steps));
}

TEST(WaveBand, IsEmptyOnceTheWavesAreGone) {
    WaveGrid grid;
    grid.blocks = {5, 5, 5};
    WaveSettings settings;
    settings.sum = WaveSum::Nothing;
    WaveStepper stepper(grid, settings, bumpAt(grid, {20, 20, 20}, 2), {}, nowhere());
    for (int i = 0; i < 2000 && !stepper.finished(); ++i) stepper.step();
    EXPECT_TRUE(stepper.finished());
    EXPECT_EQ(stepper.band().active().size(), 0u);
    EXPECT_EQ(stepper.band().bytes(), 0);
}

TEST(WaveBand, BytesACell) {
    // Two levels, energy and three of flux: 24 bytes. Without sums 8; a matched axis 8 more.
    WaveGrid grid;
    grid.blocks = {3, 3, 3};
    WaveSettings settings;
    settings.sparse = false;
    const auto bytes = [&](WaveSum sum, bool periodic) {
        settings.sum = sum, grid.periodic = {periodic, periodic, periodic};
        WaveStepper s(grid, settings, {}, std::vector<std::uint8_t>(27, 1), nowhere());
        return s.counts().peak_bytes / (27.0 * kWaveCells);
    };
    EXPECT_EQ(bytes(WaveSum::EnergyAndFlux, true), 24);
    EXPECT_EQ(bytes(WaveSum::Energy, true), 12);
    EXPECT_EQ(bytes(WaveSum::Nothing, true), 8);
    // The 26 blocks around one: 6 with one matched axis, 12 with two, 8 with three; sums only in the middle.
    EXPECT_NEAR(bytes(WaveSum::EnergyAndFlux, false), 8 + (6 * 8 + 12 * 16 + 8 * 24 + 16) / 27.0, 1e-12);
}

TEST(WaveBand, ThreadsChangeNoBit) {
    std::vector<std::vector<float>> results;
    for (const int threads : {1, 2, 3}) {
        setThreadCount(threads);
        WaveGrid grid;
        grid.blocks = {6, 7, 6};
        WaveSettings settings;
        std::vector<float> sums(static_cast<std::size_t>(grid.count()) * 4 * kWaveCells);
        WaveStepper stepper(
            grid, settings, planeFromTop(grid, glm::normalize(glm::dvec3(0.3, 0.1, -1)), WavePulse(1.5)),
            std::vector<std::uint8_t>(static_cast<std::size_t>(grid.count()), 1), [&](int block, const float* s) {
                for (int i = 0; i < 4 * kWaveCells; ++i)
                    sums[static_cast<std::size_t>(block * 4 * kWaveCells + i)] += s[i];
            });
        for (int i = 0; i < 150; ++i) stepper.step();
        stepper.finish();
        results.push_back(sums);
    }
    setThreadCount(0);
    EXPECT_GT(*std::max_element(results[0].begin(), results[0].end()), 0.1f);
    for (const auto& r : results) EXPECT_EQ(std::memcmp(r.data(), results[0].data(), r.size() * sizeof(float)), 0);
}

TEST(WaveSums, OfAPlaneWaveAreTheCalibration) {
    // Along z and across, in a box that is periodic to the sides; the second along a lattice direction of the period.
    for (const bool slant : {false, true}) {
        WaveGrid grid;
        grid.blocks = {3, 1, 8};
        grid.periodic = {true, true, false};
        const WavePulse pulse = WavePulse::ofWavelength(7);
        const glm::dvec3 direction(0, 0, -1);
        WaveSource source = planeFromTop(grid, direction, pulse);
        if (slant) grid.spacing = {1, 1, 0.8}, source = planeFromTop(grid, direction, pulse);
        WaveSettings settings;
        settings.sum_every = 2;
        std::map<int, std::vector<float>> sums;
        WaveStepper stepper(grid, settings, source,
                            std::vector<std::uint8_t>(static_cast<std::size_t>(grid.count()), 1),
                            [&](int block, const float* s) {
                                auto& to = sums[block];
                                to.resize(4 * kWaveCells);
                                for (std::size_t i = 0; i < to.size(); ++i) to[i] += s[i];
                            });
        for (int i = 0; i < 400; ++i) stepper.step();
        stepper.finish();
        const WavePlaneSums plane = planeSums(pulse, {stepper.dt(), grid.spacing, 4}, direction);
        EXPECT_LT(plane.energy, pulse.slopeEnergy());
        EXPECT_GT(plane.energy, 0.85 * pulse.slopeEnergy());
        for (const int z : {2, 4, 6}) {
            const auto& s = sums.at(grid.index({1, 0, z}));
            EXPECT_NEAR(s[77] / plane.energy, 1, 5e-3) << z;
            EXPECT_NEAR(s[3 * kWaveCells + 77] / -plane.flux, 1, 5e-3) << z;
            EXPECT_NEAR(s[1 * kWaveCells + 77] / plane.flux, 0, 1e-5) << z;
        }
    }
}

/// The mean frequency runs at 1 along the direction that the speed was set for, and the flux of such a wave has its
/// direction, as have those of waves some ten degrees away, which one factor for all axes would turn by 0.2 to 0.5
/// degrees.
TEST(WaveSums, FluxKeepsItsDirection) {
    const glm::dvec3 spacing(1, 1, 0.9), along = glm::normalize(glm::dvec3(-0.5, 0.2, -0.84));
    const WavePulse pulse = WavePulse::ofWavelength(6);
    const double dt = 0.95 * WaveStepper::largestStep(spacing, 4), w = pulse.frequency();
    const double speed = tunedSpeed(w, {dt, spacing, 4}, along, 1 / 0.95);
    EXPECT_NEAR(speed, 1, 0.015);
    EXPECT_NEAR(schemeWavenumber(w, {dt, spacing, 4}, along, 1 / speed) / w, 1, 1e-9);
    EXPECT_GT(std::fabs(schemeWavenumber(w, {dt, spacing, 4}, along) / w - 1), 2e-3);
    // Of the differential equation alone energy travels at its speed; the scheme is some per cent off.
    EXPECT_NEAR(schemeGroupVelocity(1e-2 * w, {dt, spacing, 4}, along, 0.9), 0.9, 1e-4);
    const double group = schemeGroupVelocity(w, {dt, spacing, 4}, along, speed);
    EXPECT_NEAR(group, 1, 0.05);
    EXPECT_GT(std::fabs(group - 1), 1e-3);

    // What central differences make of the pulse's own waves, all of them along one direction.
    const auto slopes = [&](const glm::dvec3& direction) {
        glm::dvec3 sums(0);
        constexpr int kWaves = 1000;
        for (int i = 0; i < kWaves; ++i) {
            const double frequency = (i + 0.5) * 6 / pulse.width() / kWaves;
            const double wave = schemeWavenumber(frequency, {dt, spacing, 4}, direction, 1 / speed);
            for (int a = 0; a < 3; ++a) {
                const double x = wave * direction[a] * spacing[a];
                const double slope = (8 * std::sin(x) - std::sin(2 * x)) / (6 * spacing[a]);
                sums[a] += pulse.spectrum(frequency) * std::sin(frequency * dt) * slope;
            }
        }
        return sums;
    };
    const auto off = [](const glm::dvec3& a, const glm::dvec3& b) {
        return std::acos(std::min(1.0, glm::dot(glm::normalize(a), glm::normalize(b)))) * 180 / kPi;
    };
    const WaveFluxScale scale(pulse, {dt, spacing, 4}, along, speed);
    for (const glm::dvec3& direction :
         {along, glm::normalize(along + glm::dvec3(0.15, 0.1, 0)), glm::normalize(along + glm::dvec3(-0.15, 0, 0))}) {
        EXPECT_GT(off(slopes(direction), direction), 0.2);
        EXPECT_LT(off(scale(slopes(direction)), direction), 0.02);
    }
    EXPECT_EQ(scale(glm::dvec3(0)), glm::dvec3(0));
}

TEST(WavePulse, ItsIntegralsAreWhatTheyAreSaidToBe) {
    for (const PulseShape shape : {PulseShape::Slope, PulseShape::Bump}) {
        const WavePulse pulse = WavePulse::ofWavelength(2.5, shape);
        double slope = 0, integral = 0, spectrum = 0, mean = 0;
        const double dt = pulse.width() / 200;
        for (double t = -pulse.reach(); t < pulse.reach(); t += dt) {
            slope += std::pow((pulse(t + 1e-4) - pulse(t - 1e-4)) / 2e-4, 2) * dt, integral += pulse(t) * dt;
        }
        const double dw = 1e-3 / pulse.width();
        for (double w = 0.5 * dw; w < 8 / pulse.width(); w += dw)
            spectrum += w * w * pulse.spectrum(w) * dw, mean += w * w * w * pulse.spectrum(w) * dw;
        EXPECT_NEAR(slope / pulse.slopeEnergy(), 1, 1e-3);
        EXPECT_NEAR(spectrum / pulse.slopeEnergy(), 1, 1e-4);
        EXPECT_NEAR(mean / spectrum / pulse.frequency(), 1, 1e-3);
        EXPECT_NEAR(2 * kPi / pulse.frequency(), 2.5, 1e-9);
        EXPECT_NEAR(integral, pulse.integral(), 1e-3 * pulse.width());
    }
}

}  // namespace
}  // namespace photic
