// SPDX-License-Identifier: Apache-2.0
#include "tests/support/wave_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/support/closed_forms.h"

namespace photic::truth {
namespace {

constexpr double kEta = 1.333, kAmplitude = 0.03, kWavelength = 1.0;
constexpr double kWavenumber = 2 * std::numbers::pi / kWavelength;

WaveLight waves(int cells, double extinction = 0) {
    return {cosineProfile(kAmplitude, kWavenumber), kEta, -1.5, 1.5, cells, extinction};
}

double greatestDifference(const std::vector<double>& a, const std::vector<double>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::fabs(a[i] - b[i]));
    return worst;
}

TEST(WaveLightTruth, JacobianIsTheSlopeOfTheLanding) {
    const WaveLight light = waves(256);
    for (const double u : {-0.31, 0.0, 0.07, 0.24, 0.49}) {
        for (const double z : {-0.1, -0.8, -3.0}) {
            const double e = 1e-5;
            EXPECT_NEAR(light.jacobian(u, z), (light.landing(u + e, z) - light.landing(u - e, z)) / (2 * e), 1e-8);
        }
    }
}

TEST(WaveLightTruth, CuspLiesWhereTheFormulaSays) {
    const double depth = 1 / (kAmplitude * kWavenumber * kWavenumber * (1 - 1 / kEta));
    const double z = kAmplitude - depth;
    const WaveLight light = waves(256);
    EXPECT_NEAR(light.jacobian(0, z), 0, 1e-12);
    // A cusp, not a mere fold: above it no neighbour crosses, below it three rays arrive on the axis.
    EXPECT_GT(light.jacobian(0.02, z), 0);
    EXPECT_GT(light.jacobian(0, z + 0.01), 0);
    EXPECT_LT(light.jacobian(0, z - 0.01), 0);
}

/// Means by 1e6 rays at regular places, each with its exact length through every voxel.
VoxelMeans bruteForce(const WaveLight& light, double extinction, double x0, double dx, int nx, double z0, double dz,
                      int nz) {
    VoxelMeans out;
    out.nx = nx, out.nz = nz;
    out.fluence.resize(static_cast<std::size_t>(nx) * nz), out.down = out.across = out.fluence;
    const int rays = 1000000;
    const double du = 3.0 / rays;
    for (int r = 0; r < rays; ++r) {
        const double u = -1.5 + (r + 0.5) * du, h = kAmplitude * std::cos(kWavenumber * u);
        const double tan_alpha = light.landing(u, h - 1) - u;
        const double cos_alpha = 1 / std::hypot(1, tan_alpha);
        const double power =
            du * fresnelTransmittance(1 / std::hypot(1, kAmplitude * kWavenumber * std::sin(kWavenumber * u)), 1, kEta);
        for (int k = 0; k < nz; ++k) {
            const double top = std::min(h, z0 + (k + 1) * dz), bottom = z0 + k * dz;
            if (top <= bottom) continue;
            const double xa = u + (h - top) * tan_alpha, xb = u + (h - bottom) * tan_alpha;
            const int first = std::max(0, static_cast<int>(std::floor((std::min(xa, xb) - x0) / dx)));
            const int last = std::min(nx - 1, static_cast<int>(std::floor((std::max(xa, xb) - x0) / dx)));
            for (int i = first; i <= last; ++i) {
                double part = 1;
                double middle = (top + bottom) / 2;
                if (xa != xb) {
                    double sa = std::clamp((x0 + i * dx - xa) / (xb - xa), 0.0, 1.0);
                    double sb = std::clamp((x0 + (i + 1) * dx - xa) / (xb - xa), 0.0, 1.0);
                    if (sa > sb) std::swap(sa, sb);
                    part = sb - sa;
                    middle = top - (top - bottom) * (sa + sb) / 2;
                }
                // Extinction at the middle of the piece: second order in an exponent of 1e-2.
                const double height =
                    power * part * (top - bottom) * std::exp(-extinction * (h - middle) / cos_alpha) / (dx * dz);
                const auto v = out.index(i, k);
                out.fluence[v] += height / cos_alpha, out.down[v] += height, out.across[v] += height * tan_alpha;
            }
        }
    }
    return out;
}

TEST(WaveLightTruth, VoxelMeansAreThoseOfAMillionRays) {
    for (const double extinction : {0.0, 0.2}) {
        const WaveLight light = waves(768, extinction);
        const VoxelMeans truth = light.voxelMeans(-0.5, 0.03125, 32, -4.5, 0.117, 40);
        const VoxelMeans counted = bruteForce(light, extinction, -0.5, 0.03125, 32, -4.5, 0.117, 40);
        // One ray more or less in a voxel is 3e-6 / 0.03 = 1e-4 of a mean of 1; caustics hold up to 10 times that.
        EXPECT_LT(greatestDifference(truth.fluence, counted.fluence), 4e-4);
        EXPECT_LT(greatestDifference(truth.down, counted.down), 4e-4);
        EXPECT_LT(greatestDifference(truth.across, counted.across), 4e-4);
        EXPECT_GT(*std::max_element(truth.fluence.begin(), truth.fluence.end()), extinction > 0 ? 1.5 : 3);
    }
}

TEST(WaveLightTruth, VoxelMeansAreConverged) {
    for (const double extinction : {0.0, 0.5}) {
        const VoxelMeans coarse = waves(768, extinction).voxelMeans(-0.5, 1.0 / 64, 64, -4.5, 1.0 / 21, 96);
        const VoxelMeans fine = waves(3001, extinction).voxelMeans(-0.5, 1.0 / 64, 64, -4.5, 1.0 / 21, 96);
        EXPECT_LT(greatestDifference(coarse.fluence, fine.fluence), 1e-6);
        EXPECT_LT(greatestDifference(coarse.down, fine.down), 1e-6);
        EXPECT_LT(greatestDifference(coarse.across, fine.across), 1e-6);
    }
}

TEST(WaveLightTruth, EveryWholeLayerCarriesThePower) {
    const VoxelMeans means = waves(768).voxelMeans(-0.5, 1.0 / 48, 48, -1.5, 1.0 / 48, 68);
    double expected = 0;
    const int steps = 4096;
    for (int i = 0; i < steps; ++i) {
        const double slope = kAmplitude * kWavenumber * std::sin(2 * std::numbers::pi * (i + 0.5) / steps);
        expected += fresnelTransmittance(1 / std::hypot(1, slope), 1, kEta) / steps;
    }
    for (int k = 0; k < 70 - 4; ++k) {
        double power = 0;
        for (int i = 0; i < 48; ++i) power += means.down[means.index(i, k)] / 48;
        EXPECT_NEAR(power, expected, 1e-9) << k;
    }
}

TEST(WaveLightTruth, PointValuesAreTheLimitOfSmallVoxels) {
    const WaveLight light = waves(768, 0.3);
    for (const double x : {-0.37, 0.11, 0.42}) {
        for (const double z : {-0.2, -0.9, -2.2}) {
            const VoxelMeans voxel = light.voxelMeans(x - 5e-5, 1e-4, 1, z - 5e-5, 1e-4, 1);
            EXPECT_NEAR(voxel.fluence[0] / light.fluence(x, z), 1, 1e-5) << x << " " << z;
            EXPECT_NEAR(voxel.down[0] / light.horizontal(x, z), 1, 1e-5) << x << " " << z;
        }
    }
}

TEST(WaveLightTruth, LeastJacobianFindsTheFolds) {
    const WaveLight light = waves(768);
    const double cusp = kAmplitude - 1 / (kAmplitude * kWavenumber * kWavenumber * (1 - 1 / kEta));
    const VoxelMeans means = light.voxelMeans(-0.5, 1.0 / 64, 64, cusp - 40.0 / 64, 1.0 / 64, 60);
    int folded = 0;
    for (int k = 0; k < 60; ++k) {
        for (int i = 0; i < 64; ++i) {
            const double j = means.jacobian[means.index(i, k)];
            folded += j == 0;
            if (k >= 42) {
                EXPECT_GT(j, 0) << "a fold above the cusp in " << i << " " << k;
            }
            // Where no arrival folds, the sum of 1/|J| over a handful of arrivals bounds the mean.
            if (j > 0 && std::isfinite(j)) {
                EXPECT_LT(means.fluence[means.index(i, k)], 8 / j);
            }
        }
    }
    EXPECT_GE(folded, 2 * 38);  // two strands below the cusp
    EXPECT_LE(folded, 8 * 40);
}

}  // namespace
}  // namespace photic::truth
