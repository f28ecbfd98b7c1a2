// SPDX-License-Identifier: Apache-2.0
// The forward caustic mesh against the exact floor of tests/data, energy, layers and periods.
#include <cmath>
#include <numbers>

#include "tests/runtime/water_fixture.h"
#include "tests/support/closed_forms.h"
#include "tests/support/pool3.h"

namespace photic::runtime {
namespace {

namespace pool3 = truth::pool3;
using test::channel;

class CausticMap : public test::WithWater {
protected:
    void draw(float bottom, float top, int layers, int resolution) {
        CausticMapOptions options;
        options.bottom = bottom, options.top = top, options.layers = layers, options.resolution = resolution;
        options.full_precision = true;
        const auto drawn = water_->updateCausticMap(options);
        ASSERT_TRUE(drawn.ok()) << drawn.error().message;
    }
    /// Irradiance on the level floor, averaged over 4 x 4 look-ups a pixel.
    std::vector<double> floorAt(double z, int size) {
        const int fine = 4 * size;
        const auto values =
            channel(test::evaluate(gl_, "photic_caustic_map.glsl",
                                   "vec4(photicCausticIrradiance(" + test::floorPoint(z, fine) + ", vec3(0, 0, 1)), 0)",
                                   fine, fine, [&](const Uniforms& u) { water_->impl().setCausticMap(u, 0); }),
                    0);
        std::vector<double> out(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0.0);
        for (int j = 0; j < fine; ++j) {
            for (int i = 0; i < fine; ++i) {
                out[static_cast<std::size_t>(j / 4 * size + i / 4)] +=
                    values[static_cast<std::size_t>(j * fine + i)] / 16;
            }
        }
        return out;
    }
};

TEST_F(CausticMap, StillWaterIsExact) {
    fill(test::sampleWater(32, [](double, double) { return 0.0; }));
    draw(-1.5f, 0, 4, 64);
    const double cos_in = -pool3::sun().z;
    for (const double z : {-1.5, -0.8, -0.1}) {
        const double expected = truth::PlaneWater{1, cos_in, 1, pool3::kIor, 0}.horizontal(-z);
        for (const double v : floorAt(z, 16)) EXPECT_NEAR(v, expected, 2e-4) << z;
    }
}

TEST_F(CausticMap, ConvergesToTheExactFloor) {
    const auto exact = pool3::exactFloor().values;
    double last = 1, correlation = 0;
    for (const int side : {64, 128, 512}) {
        fill(test::pool3Water(side));
        draw(pool3::kFloor, 0, 1, 2048);
        const auto like = test::likeness(floorAt(pool3::kFloor, 512), exact);
        std::printf("caustic mesh of %d: correlation %.4f, energy %.4f, relative L1 %.4f\n", side, like.correlation,
                    like.energy, like.relative_l1);
        EXPECT_NEAR(like.energy, 1, 0.005) << side;
        EXPECT_LT(like.relative_l1, 0.75 * last) << side;
        last = like.relative_l1, correlation = like.correlation;
    }
    EXPECT_GT(correlation, 0.976);
}

TEST_F(CausticMap, LayersBetweenWhichLightIsFoundByMixing) {
    // A receiver between two layers against a map drawn for it alone.
    fill(test::pool3Water(128));
    const double z = -0.93;
    draw(static_cast<float>(z), 0, 1, 256);
    const auto own = floorAt(z, 128);
    double error[2];
    for (int i = 0; i < 2; ++i) {
        draw(-1.5f, 0, i == 0 ? 5 : 17, 256);
        const auto like = test::likeness(floorAt(z, 128), own);
        EXPECT_NEAR(like.energy, 1, 0.01);
        error[i] = like.relative_l1;
        std::printf("%d layers: correlation %.4f, relative L1 %.4f\n", i == 0 ? 5 : 17, like.correlation, error[i]);
    }
    EXPECT_LT(error[1], 0.5 * error[0]);
    EXPECT_LT(error[1], 0.08);
}

TEST_F(CausticMap, PeriodicWaterHasNoSeamAndKeepsItsEnergy) {
    constexpr double kPi = std::numbers::pi;
    const auto waves = [](double x, double y) {
        return 0.03 * std::sin(2 * kPi * x) + 0.02 * std::cos(kPi * y + x * kPi);
    };
    fill(test::sampleWater(128, waves, 1, WaterOutside::Periodic));
    draw(-1.5f, 0, 1, 512);
    // Over a whole period, what lands is what is sent in: the mean over level water, exactly.
    const auto whole = floorAt(-1.5, 128);
    double mean = 0;
    for (const double v : whole) mean += v / static_cast<double>(whole.size());
    double sent = 0;
    constexpr int kSide = 256;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const double x = -1 + (i + 0.5) * 2 / kSide, y = -1 + (j + 0.5) * 2 / kSide;
            const double sx = 0.06 * kPi * std::cos(2 * kPi * x) - 0.02 * kPi * std::sin(kPi * y + x * kPi);
            const double sy = -0.02 * kPi * std::sin(kPi * y + x * kPi);
            const glm::dvec3 area(-sx, -sy, 1), d = pool3::sun();
            const double across = -(d.x * area.x + d.y * area.y + d.z);
            sent += across * truth::fresnelTransmittance(across / std::sqrt(sx * sx + sy * sy + 1), 1, pool3::kIor) /
                    (kSide * kSide);
        }
    }
    EXPECT_NEAR(mean / sent, 1, 2e-3);
    // A period further it is the same light.
    const auto at = [&](const std::string& shift) {
        return channel(test::evaluate(gl_, "photic_caustic_map.glsl",
                                      "vec4(photicCausticIrradiance(" + test::floorPoint(-1.5, 64) + " + " + shift +
                                          ", vec3(0, 0, 1)), 0)",
                                      64, 64, [&](const Uniforms& u) { water_->impl().setCausticMap(u, 0); }),
                       0);
    };
    const auto here = at("vec3(0)"), there = at("vec3(2, -4, 0)");
    EXPECT_LT(test::likeness(there, here).relative_l1, 2e-3);
}

TEST_F(CausticMap, HalvesAreCloseToFloats) {
    fill(test::pool3Water(128));
    draw(pool3::kFloor, 0, 1, 512);
    const auto floats = floorAt(pool3::kFloor, 128);
    CausticMapOptions options;
    options.bottom = pool3::kFloor, options.layers = 1, options.resolution = 512;
    ASSERT_TRUE(water_->updateCausticMap(options).ok());
    EXPECT_LT(test::likeness(floorAt(pool3::kFloor, 128), floats).relative_l1, 2e-3);
}

TEST_F(CausticMap, IsBoundedAndRefusesNonsense) {
    fill(test::pool3Water(64));
    CausticMapOptions options;
    options.layers = 0;
    EXPECT_FALSE(water_->updateCausticMap(options).ok());
    options = {};
    options.top = -2;
    EXPECT_FALSE(water_->updateCausticMap(options).ok());
    options = {};
    options.resolution = 1 << 20;
    const auto refused = water_->updateCausticMap(options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::Limit);
    options = {};
    options.resolution = 64;
    ASSERT_TRUE(water_->updateCausticMap(options).ok());
    EXPECT_EQ(water_->gpuBytes(), 64u * 64 * 16 + 80u * 80 * 32 + 64u * 64 * 8 * 8);
}

TEST_F(CausticMap, AbandonForgetsTheNames) {
    fill(test::pool3Water(64));
    CausticMapOptions options;
    options.resolution = 64;
    ASSERT_TRUE(water_->updateCausticMap(options).ok());
    water_->abandon();
    EXPECT_FALSE(water_->hasCausticMap());
    EXPECT_EQ(water_->gpuBytes(), 0u);
}

}  // namespace
}  // namespace photic::runtime
