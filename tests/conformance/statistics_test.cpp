// SPDX-License-Identifier: Apache-2.0
// Beams against photons, voxel by voxel, and photons against the closed form, in units of the photons' own standard
// error.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/conformance/bake_scene.h"
#include "tests/support/statistics.h"

namespace photic {
namespace {

/// 64 repeats: a voxel's mean over its standard error then follows Student's t with 63 degrees of freedom, which is
/// turned into the normal deviate of the same probability, so that chi^2/n is to be 1. (With 16 repeats and no such
/// care it would be 15/13.)
constexpr std::int64_t kShifts = 64;
constexpr double kBias = 0.005;  ///< allowance, added in quadrature to the standard error

/// truth::normalFromStudent from a table, for millions of voxels.
double deviate(double t) {
    constexpr int kSteps = 8192;
    constexpr double kMost = 16;
    static const std::vector<double> table = [] {
        std::vector<double> z;
        for (int i = 0; i <= kSteps + 1; ++i) z.push_back(truth::normalFromStudent(kMost * i / kSteps, kShifts - 1));
        return z;
    }();
    const double place = std::min(std::fabs(t), kMost) / kMost * kSteps;
    const auto i = static_cast<std::size_t>(place);
    return std::copysign(table[i] + (place - static_cast<double>(i)) * (table[i + 1] - table[i]), t);
}

struct Deviations {
    std::int64_t voxels = 0;
    double square = 0, beyond_3 = 0, worst = 0, mean = 0;
    void add(double photons, double other, double error) {
        const double z = deviate((photons - other) / std::hypot(error, kBias * other));
        ++voxels, square += z * z, mean += z, beyond_3 += std::fabs(z) > 3, worst = std::max(worst, std::fabs(z));
    }
    void finish(const char* what) {
        square /= static_cast<double>(voxels), beyond_3 /= static_cast<double>(voxels),
            mean /= static_cast<double>(voxels);
        fmt::print("  {}: {} voxels, chi^2/n {:.4f}, mean z {:.4f}, |z| > 3 in {:.3f} %, worst {:.2f}\n", what, voxels,
                   square, mean, 100 * beyond_3, worst);
    }
};

template <class Other>
Deviations compare(const Baked& photons, const Other& other, const char* what) {
    Deviations d;
    const LightVolume& error = *photons.result.standard_error;
    const LightField& paths = error.scalars.at("path_count");
    const GridFrame& f = photons.field().frame();
    for (int k = f.min.z; k <= f.max.z; ++k) {
        for (int j = f.min.y; j <= f.max.y; ++j) {
            for (int i = f.min.x; i <= f.max.x; ++i) {
                const glm::ivec3 v(i, j, k);
                if (paths.value(v, 0) < 25) continue;
                d.add(photons.field().irradiance(v), other(v), error.field.value(v, 0));
            }
        }
    }
    d.finish(what);
    return d;
}

/// Random photons. Quasi-random ones have correct standard errors, but over one set of shifts their errors in different
/// voxels are one function of the shifts, translated: chi^2/n of one bake is then anything from 0.4 to 1.6.
GivenOptions randomPaths(std::int64_t count) {
    return option("count", count) | option("shifts", kShifts) | option("sampling", std::string("random"));
}

TEST(Statistics, BeamsAgreeWithPhotons) {
    // 128 x 128 columns; the 100 voxels of a column share their rays, so that chi^2/n is known to some 1 %. Enough
    // paths that voxels with 25 of them are no selection of lucky ones.
    truth::pool3::SceneText text;
    text.voxel_size = 2.0 / 128;
    text.bake = "quadrature = 4\n";
    const std::string toml = truth::pool3::sceneToml(text);
    const Baked beams = bakeText(toml, "beams", option("mesh", std::int64_t{1024}));
    const Baked photons = bakeText(toml, "photons", randomPaths(6'000'000));
    const Deviations d = compare(
        photons, [&](const glm::ivec3& v) { return beams.field().irradiance(v); }, "photons against beams");
    EXPECT_GT(d.voxels, 1'000'000);
    EXPECT_NEAR(d.square, 1, 0.02);
    EXPECT_LE(d.beyond_3, 0.004);
    EXPECT_LE(d.worst, 6);
}

TEST(Statistics, QuasiRandomPhotonsDeviateNoFurther) {
    truth::pool3::SceneText text;
    text.voxel_size = 2.0 / 64;
    text.bake = "quadrature = 4\n";
    const std::string toml = truth::pool3::sceneToml(text);
    const Baked beams = bakeText(toml, "beams", option("mesh", std::int64_t{1024}));
    const Baked photons = bakeText(toml, "photons", option("count", std::int64_t{200'000}) | option("shifts", kShifts));
    const Deviations d = compare(
        photons, [&](const glm::ivec3& v) { return beams.field().irradiance(v); }, "quasi-random ones");
    EXPECT_LE(d.beyond_3, 0.004);
    EXPECT_LE(d.worst, 6);
    EXPECT_NEAR(d.square, 1, 0.6);
}

class PhotonsUnderAWave : public ::testing::Test {
protected:
    WaveScene scene_;
    Baked photons_ = bakeText(scene_.toml(), "photons", randomPaths(600'000));
    truth::VoxelMeans means_ = scene_.truth();
    Deviations against(double factor, const char* what) {
        const glm::ivec3 low = photons_.field().frame().min;
        return compare(
            photons_,
            [&](const glm::ivec3& v) { return factor * means_.fluence[means_.index(v.x - low.x, v.z - low.z)]; }, what);
    }
};

TEST_F(PhotonsUnderAWave, AgreeWithTheClosedForm) {
    const Deviations d = against(1, "photons against the wave");
    EXPECT_GT(d.voxels, 40'000);
    EXPECT_NEAR(d.square, 1, 0.15);  // 64 x 8 columns that share their rays
    EXPECT_NEAR(d.mean, 0, 0.15);
    EXPECT_LE(d.worst, 6);
}

TEST_F(PhotonsUnderAWave, TellAFieldThatIsThreePercentOff) {
    EXPECT_GT(against(0.97, "3 % dimmer").mean, 0.4);
    EXPECT_LT(against(1.03, "3 % brighter").mean, -0.4);
}

}  // namespace
}  // namespace photic
