// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/scene/gaussian_bump.h"
#include "bake/scene/wind_sea.h"
#include "bake/threads/parallel_for.h"
#include "tests/scene/scene_texts.h"
#include "tests/scene/surface_checks.h"

namespace photic {
namespace {

using test::SceneTest;
constexpr double kPi = std::numbers::pi;

GaussianBump poolBump() {
    GaussianBump bump;
    bump.height = 0.12, bump.radius = 0.11, bump.center = {0.2, -0.15}, bump.speed = 1.7;
    return bump;
}

TEST(Bump, StartsAsAGaussian) {
    const GaussianBump bump = poolBump();
    const glm::dvec2 size(2, 1.8);
    const SampleGrid grid = bumpHeights(bump, size, 64, 48, 0);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            const glm::dvec2 p = (glm::dvec2(x, y) + 0.5) / glm::dvec2(64, 48) * size - 0.5 * size - bump.center;
            EXPECT_NEAR(grid.at(x, y), 0.12 * std::exp(-0.5 * glm::dot(p, p) / (0.11 * 0.11)), 1e-11);
        }
}

TEST(Bump, NearAWallItMeetsItsMirrorImage) {
    GaussianBump bump = poolBump();
    bump.center = {0.95, 0};
    const SampleGrid grid = bumpHeights(bump, {2, 2}, 100, 10, 0);
    const auto g = [&](double d) { return std::exp(-0.5 * d * d / (0.11 * 0.11)); };
    const double x = 0.99, y = 0.1;  // last column, row 5
    EXPECT_NEAR(grid.at(99, 5), 0.12 * g(y) * (g(x - 0.95) + g(2 - x - 0.95)), 1e-11);
}

TEST(Bump, ObeysTheWaveEquationAndKeepsItsWater) {
    const GaussianBump bump = poolBump();
    const glm::dvec2 size(2, 2);
    const int n = 128;
    const double h = 2.0 / n, dt = 1e-3, t = 0.9;  // after the first reflection
    const SampleGrid before = bumpHeights(bump, size, n, n, t - dt), now = bumpHeights(bump, size, n, n, t),
                     after = bumpHeights(bump, size, n, n, t + dt);
    double worst = 0, largest = 0;
    for (int y = 2; y + 2 < n; ++y)
        for (int x = 2; x + 2 < n; ++x) {
            const double tt = (before.at(x, y) - 2 * now.at(x, y) + after.at(x, y)) / (dt * dt);
            const auto second = [&](int dx, int dy) {
                return (-now.at(x - 2 * dx, y - 2 * dy) + 16 * now.at(x - dx, y - dy) - 30 * now.at(x, y) +
                        16 * now.at(x + dx, y + dy) - now.at(x + 2 * dx, y + 2 * dy)) /
                       (12 * h * h);
            };
            worst = std::max(worst, std::fabs(tt - 1.7 * 1.7 * (second(1, 0) + second(0, 1))));
            largest = std::max(largest, std::fabs(tt));
        }
    EXPECT_GT(largest, 5);
    EXPECT_LT(worst, 2e-3 * largest);

    const auto volume = [](const SampleGrid& grid) {
        double sum = 0;
        for (const double v : grid.values) sum += v;
        return sum;
    };
    EXPECT_NEAR(volume(now) * h * h, 0.12 * 2 * kPi * 0.11 * 0.11, 1e-12);
}

TEST(Bump, EnergyIsKeptOrFallsWithTheDamping) {
    GaussianBump bump = poolBump();
    const glm::dvec2 size(2, 2);
    const int n = 96;
    const double h = 2.0 / n, dt = 1e-4;
    // Kinetic and potential energy by differences; the mean level holds none.
    const auto energy = [&](double t) {
        const SampleGrid a = bumpHeights(bump, size, n, n, t - dt), b = bumpHeights(bump, size, n, n, t + dt),
                         m = bumpHeights(bump, size, n, n, t);
        double sum = 0;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const double v = (b.at(x, y) - a.at(x, y)) / (2 * dt);
                const double gx = x + 1 < n ? (m.at(x + 1, y) - m.at(x, y)) / h : 0,
                             gy = y + 1 < n ? (m.at(x, y + 1) - m.at(x, y)) / h : 0;
                sum += v * v + 1.7 * 1.7 * (gx * gx + gy * gy);
            }
        return sum;
    };
    const double start = energy(0.05);
    for (const double t : {0.4, 1.1, 3.7}) EXPECT_NEAR(energy(t) / start, 1, 5e-3) << t;
    bump.damping = 0.5;
    EXPECT_NEAR(energy(2.5) / energy(1.5), std::exp(-2 * 0.5), 0.02);
    bump.damping = 1000;  // overdamped: creeps, finite, no overshoot
    const SampleGrid creeping = bumpHeights(bump, size, n, n, 1e4);
    for (const double v : creeping.values) EXPECT_TRUE(v > 0 && v < 0.12);
}

TEST_F(SceneTest, BumpIsASmoothSurfaceWithWalls) {
    const std::string keys =
        "size = [2, 2]\ncenter = [1, 0, -0.5]\nbump = { height = 0.12, radius = 0.2, center = [0.1, 0], depth = 0.5 }";
    const Scene scene = loadSurfaceKeys(keys);
    const HeightField& field = *scene.surfaces[0].height_field;
    EXPECT_NEAR(field.at({1.1, 0}).position.z, -0.5 + 0.12, 1e-7);
    EXPECT_NEAR(field.at({1.25, 0.1}).position.z, -0.5 + 0.12 * std::exp(-0.5 * (0.15 * 0.15 + 0.01) / 0.04), 1e-7);
    EXPECT_EQ(field.at({2.5, 0}).position.z, -0.5);
    const auto later = loadSurfaceKeys(keys, 24).surfaces[0].height_field;
    EXPECT_NEAR(later->at({2, 0.3}).normal.x, 0, 1e-12);  // no slope at the wall
    EXPECT_GT(std::fabs(later->at({2, 0.3}).position.z + 0.5), 1e-3);
    EXPECT_LT(test::rowDifference(*later, {-0.2, 0.31}, 0.0031, 900), 1e-12);
    EXPECT_NE(loadSurfaceKeys(keys, 24).hash, scene.hash);
}

WindSea breeze() {
    WindSea sea;
    sea.wind_speed = 5, sea.fetch = 300, sea.direction = {0.8, 0.6}, sea.seed = 7, sea.shortest_wavelength = 0.4;
    return sea;
}

double variance(const SampleGrid& grid) {
    double sum = 0, squares = 0;
    for (const double v : grid.values) sum += v, squares += v * v;
    const double n = static_cast<double>(grid.values.size());
    return squares / n - sum / n * (sum / n);
}

TEST(Sea, SpectrumIsJonswaps) {
    WindSea sea = breeze();
    sea.wind_speed = 10, sea.fetch = 1e5;
    EXPECT_NEAR(peakFrequency(sea), 22 * std::cbrt(9.81 * 9.81 / 1e6), 1e-12);
    // At the peak: alpha g^2 / omega^5 exp(-5/4) gamma.
    const double peak = peakFrequency(sea), alpha = 0.076 * std::pow(100 / (9.81e5), 0.22);
    EXPECT_NEAR(jonswap(sea, peak), alpha * 9.81 * 9.81 / std::pow(peak, 5) * std::exp(-1.25) * 3.3, 1e-12);
    // Without the enhancement (Pierson and Moskowitz) the integral is alpha g^2 / (5 omega_p^4).
    sea.peak_enhancement = 1, sea.shortest_wavelength = 0.02;
    EXPECT_NEAR(significantHeight(sea), 4 * std::sqrt(alpha / 5) * 9.81 / (peak * peak), 2e-4);
}

TEST(Sea, HeightIsThatOfTheSpectrum) {
    const WindSea sea = breeze();
    const glm::dvec2 size(20, 16);
    const SeaSamples samples = seaSamples(sea, size, 160, 128, 0);
    EXPECT_NEAR(4 * std::sqrt(samples.variance), significantHeight(sea), 0.02 * significantHeight(sea));
    EXPECT_NEAR(4 * std::sqrt(variance(samples.heights)), significantHeight(sea), 0.03 * significantHeight(sea));
    EXPECT_TRUE(samples.displacement.empty());
    double mean = 0;
    for (const double v : samples.heights.values) mean += v;
    EXPECT_NEAR(mean / 160 / 128, 0, 1e-14);
}

TEST(Sea, IsTheSameForASeedAtAnyResolutionAndThreadCount) {
    const WindSea sea = breeze();
    const SeaSamples coarse = seaSamples(sea, {20, 20}, 100, 100, 1.5), fine = seaSamples(sea, {20, 20}, 300, 300, 1.5);
    for (int y = 0; y < 100; y += 7)
        for (int x = 0; x < 100; x += 3)
            EXPECT_NEAR(coarse.heights.at(x, y), fine.heights.at(3 * x + 1, 3 * y + 1), 1e-12);  // same points
    // A harmonic's phase is an integer hash: these numbers hold on every machine.
    EXPECT_NEAR(coarse.heights.at(17, 42), seaSamples(sea, {20, 20}, 100, 100, 1.5).heights.at(17, 42), 0);
    const int threads = threadCount();
    setThreadCount(3);
    EXPECT_EQ(seaSamples(sea, {20, 20}, 100, 100, 1.5).heights.values, coarse.heights.values);
    setThreadCount(threads);
    WindSea other = sea;
    other.seed = 8;
    const SeaSamples different = seaSamples(other, {20, 20}, 100, 100, 1.5);
    double correlation = 0;
    for (std::size_t i = 0; i < coarse.heights.values.size(); ++i)
        correlation += coarse.heights.values[i] * different.heights.values[i];
    EXPECT_LT(std::fabs(correlation) / 1e4 / variance(coarse.heights), 0.5);
}

TEST(Sea, RunsWithTheWind) {
    WindSea sea = breeze();
    sea.spreading = 40;
    // Slopes along the wind are steeper than across it, and the pattern moves along it.
    const glm::dvec2 size(20, 20);
    const int n = 200;
    const SampleGrid now = seaSamples(sea, size, n, n, 0).heights, later = seaSamples(sea, size, n, n, 0.02).heights;
    double along = 0, across = 0, motion = 0;
    for (int y = 0; y + 1 < n; ++y)
        for (int x = 0; x + 1 < n; ++x) {
            const glm::dvec2 slope(now.at(x + 1, y) - now.at(x, y), now.at(x, y + 1) - now.at(x, y));
            const double a = 0.8 * slope.x + 0.6 * slope.y, c = -0.6 * slope.x + 0.8 * slope.y;
            along += a * a, across += c * c;
            motion -= a * (later.at(x, y) - now.at(x, y));
        }
    EXPECT_GT(along, 8 * across);
    EXPECT_GT(motion, 0.5 * std::sqrt(along * along) * 0.02);
}

TEST(Sea, RepeatsAfterItsPeriod) {
    WindSea sea = breeze();
    sea.period = 8;
    const SampleGrid start = seaSamples(sea, {20, 20}, 64, 64, 0).heights,
                     middle = seaSamples(sea, {20, 20}, 64, 64, 3).heights,
                     end = seaSamples(sea, {20, 20}, 64, 64, 8).heights;
    double moved = 0;
    for (std::size_t i = 0; i < start.values.size(); ++i) {
        EXPECT_NEAR(start.values[i], end.values[i], 1e-11);
        moved = std::max(moved, std::fabs(start.values[i] - middle.values[i]));
    }
    EXPECT_GT(moved, 0.01);
}

TEST(Sea, ChoppyCrestsAreDrawnTogether) {
    WindSea sea = breeze();
    sea.choppiness = 0.7;
    const SeaSamples samples = seaSamples(sea, {20, 20}, 128, 128, 0);
    ASSERT_EQ(samples.displacement.size(), 2u);
    // At crests the displacement converges: height and divergence anticorrelate. Along one wave they are -chop k a cos.
    double product = 0, squares = 0;
    for (int y = 1; y < 127; ++y)
        for (int x = 1; x < 127; ++x) {
            const double divergence = samples.displacement[0].at(x + 1, y) - samples.displacement[0].at(x - 1, y) +
                                      samples.displacement[1].at(x, y + 1) - samples.displacement[1].at(x, y - 1);
            product += divergence * samples.heights.at(x, y), squares += divergence * divergence;
        }
    EXPECT_LT(product / std::sqrt(squares * variance(samples.heights) * 126 * 126), -0.6);
    EXPECT_NEAR(variance(samples.displacement[0]) + variance(samples.displacement[1]), 0.49 * variance(samples.heights),
                1e-3 * variance(samples.heights));
}

TEST_F(SceneTest, SeaIsPeriodicAndWarnsOfWhatIsCut) {
    const Scene scene = loadSurfaceKeys(
        "size = [20, 10]\nsea = { wind_speed = 5, fetch = 300, direction = 30, seed = 3, resolution = 128, choppiness "
        "= 0.5 }",
        5);
    const Surface& surface = scene.surfaces[0];
    EXPECT_EQ(surface.outside, Outside::Periodic);
    EXPECT_TRUE(warnings_.messages.empty());
    const HeightField& field = *surface.height_field;
    for (const glm::dvec2 shift : {glm::dvec2(20, 0), glm::dvec2(0, -10), glm::dvec2(-60, 30)}) {
        const SurfacePoint a = field.at({3.3, 1.2}), b = field.at(glm::dvec2(3.3, 1.2) + shift);
        EXPECT_NEAR(glm::length(a.position + glm::dvec3(shift, 0) - b.position), 0, 1e-11);
        EXPECT_NEAR(glm::length(a.normal - b.normal), 0, 1e-11);
    }
    EXPECT_LT(test::rowDifference(field, {-13, 2.2}, 0.017, 1600), 1e-11);
    EXPECT_NEAR(glm::length(field.at({3.3, 1.2}).normal - test::differenceNormal(field, {3.3, 1.2}, 1e-4)), 0, 1e-5);
    EXPECT_DOUBLE_EQ(field.featureSize(), 20.0 / 128);

    loadSurfaceKeys("size = [4, 4]\nsea = { wind_speed = 10, fetch = 100000, resolution = 64 }");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("of this sea's energy; its dominant wave is"), std::string::npos)
        << warnings_.messages[0];
    loadSurfaceKeys("size = [20, 20]\nsea = { wind_speed = 5, fetch = 300, resolution = 200, choppiness = 4 }");
    ASSERT_EQ(warnings_.messages.size(), 2u);
    EXPECT_NE(warnings_.messages[1].find("folds"), std::string::npos) << warnings_.messages[1];
}

}  // namespace
}  // namespace photic
