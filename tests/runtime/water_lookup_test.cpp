// SPDX-License-Identifier: Apache-2.0
// The look-up of the water's slopes on the GPU, against its formulae in double and against light itself.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/runtime/water_fixture.h"
#include "tests/support/closed_forms.h"
#include "tests/support/pool3.h"

namespace photic::runtime {
namespace {

namespace pool3 = truth::pool3;
using test::channel;

class WaterLookup : public test::WithWater {
protected:
    void setLookup(const LookupOptions& options) { ASSERT_TRUE(water_->setLookup(options).ok()); }
    std::vector<float> run(const std::string& expression, int size) {
        return test::evaluate(gl_, "photic_water_lookup.glsl", expression, size, size,
                              [&](const Uniforms& u) { water_->impl().setLookup(u, 0); });
    }
    std::vector<double> onFloor(int size) {
        return channel(
            run("vec4(photicLookupIrradiance(" + test::floorPoint(pool3::kFloor, size) + ", vec3(0, 0, 1)), 0)", size),
            0);
    }
};

glm::dvec3 sun() { return pool3::sun(); }

LookupOptions plain(float tau, LookupAxes axes) {
    LookupOptions options;
    options.tightening = tau, options.tightening_per_metre = 0;
    options.axes = axes;
    options.gain_mode = LookupGain::Fixed;
    return options;
}

TEST_F(WaterLookup, OmegaFollowsThePapersFormula) {
    fill(test::pool3Water(64));
    for (const LookupAxes axes : {LookupAxes::One, LookupAxes::Both}) {
        for (const float reflected : {0.0f, 0.4f}) {
            LookupOptions options = plain(30, axes);
            options.reflected = reflected;
            setLookup(options);
            constexpr int kSize = 64;
            const auto pixels =
                run("vec4(photicLookupOmega(pixel / 64.0 * 1.2 - 0.6, 30.0), "
                    "photicLookupReflected(pixel / 64.0 * 1.2 - 0.6, 30.0), 0, 0)",
                    kSize);
            double worst = 0;
            for (int j = 0; j < kSize; ++j) {
                for (int i = 0; i < kSize; ++i) {
                    const glm::dvec2 slopes{(i + 0.5) / 64 * 1.2 - 0.6, (j + 0.5) / 64 * 1.2 - 0.6};
                    const float* p = &pixels[static_cast<std::size_t>(j * kSize + i) * 4];
                    const int count = static_cast<int>(axes);
                    worst = std::max(
                        {worst, std::fabs(p[0] - test::lookupOmega(slopes, sun(), pool3::kIor, 30, count, reflected)),
                         std::fabs(p[1] - test::lookupReflected(slopes, sun(), 30, count))});
                }
            }
            EXPECT_LT(worst, 2e-5) << "axes " << static_cast<int>(axes) << " reflected " << reflected;
        }
    }
}

TEST_F(WaterLookup, TiltedPlaneUnderTheZenithIsExact) {
    // A slope s under light straight down: a ray straight up meets the normal at theta = atan s and leaves at
    // asin(n sin theta) from it, so a = sin(asin(n sin theta) - theta).
    WaterLight light = test::pool3Light();
    light.direction[0] = light.direction[1] = 0, light.direction[2] = -1;
    ASSERT_TRUE(water_->setLight(light).ok());
    setLookup(plain(80, LookupAxes::One));
    for (const double slope : {0.05, 0.1, 0.2}) {
        fill(test::sampleWater(32, [&](double x, double) { return slope * x; }));
        const double theta = std::atan(slope), a = std::sin(std::asin(pool3::kIor * std::sin(theta)) - theta);
        const double still = truth::PlaneWater{1, 1, 1, pool3::kIor, 0}.horizontal(1.5);
        for (const double value : onFloor(8)) EXPECT_NEAR(value, still * std::exp(-80 * a * a), 2e-5) << slope;
    }
}

TEST_F(WaterLookup, StillWaterGivesWhatFresnelAndBeerSay) {
    fill(test::sampleWater(16, [](double, double) { return 0.0; }));
    WaterLight light = test::pool3Light();
    light.extinction[0] = 0.4f, light.extinction[1] = 0.1f, light.extinction[2] = 0;
    ASSERT_TRUE(water_->setLight(light).ok());
    setLookup(LookupOptions{});
    const auto below = run("vec4(photicLookupIrradiance(" + test::floorPoint(-1.5, 8) + ", vec3(0, 0, 1)), 0)", 8);
    const auto above = run("vec4(photicLookupIrradiance(" + test::floorPoint(0.5, 8) + ", vec3(0, 0, -1)), 0)", 8);
    const double cos_in = -sun().z;
    for (int c = 0; c < 3; ++c) {
        const truth::PlaneWater plane{1, cos_in, 1, pool3::kIor, light.extinction[c]};
        for (const double v : channel(below, c)) EXPECT_NEAR(v, plane.horizontal(1.5), 1e-5);
        const double mirrored = cos_in * (1 - truth::fresnelTransmittance(cos_in, 1, pool3::kIor));
        for (const double v : channel(above, c)) EXPECT_NEAR(v, mirrored, 1e-5);
    }
}

TEST_F(WaterLookup, TighteningGrowsWithDepthAndKeepsTheMean) {
    // Periodic water of many waves: slopes near enough to Gaussian for the mean to be kept to a few percent.
    fill(test::pool3Water(256));
    const double still = truth::PlaneWater{1, -sun().z, 1, pool3::kIor, 0}.horizontal(1.5);
    double spread[2];
    for (int i = 0; i < 2; ++i) {
        LookupOptions options;
        options.tightening = 60;
        options.tightening_per_metre = i == 0 ? 0.0f : 2.0f;
        setLookup(options);
        const auto values = onFloor(256);
        double mean = 0, square = 0;
        for (const double v : values) mean += v, square += v * v;
        mean /= static_cast<double>(values.size()), square /= static_cast<double>(values.size());
        EXPECT_NEAR(mean / still, 1, 0.1) << i;
        spread[i] = std::sqrt(square - mean * mean) / mean;
    }
    EXPECT_GT(spread[1], 1.3 * spread[0]);
}

TEST_F(WaterLookup, TriPlanarMixesThreeReadings) {
    fill(test::pool3Water(512));
    LookupOptions options = plain(100, LookupAxes::Both);
    options.projection = LookupProjection::TriPlanar;
    setLookup(options);
    const auto omega = [&](const std::string& normal) {
        return channel(
            run("vec4(photicLookupBelow(vec3(pixel / 16.0 - 0.5, -0.7), normalize(" + normal + "), 100.0))", 16), 0);
    };
    const auto x = omega("vec3(1, 0, 0)"), y = omega("vec3(0, 1, 0)"), z = omega("vec3(0, 0, 1)"),
               mixed = omega("vec3(-1, 2, 2)");
    double apart = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_NEAR(mixed[i], (x[i] + 2 * y[i] + 2 * z[i]) / 5, 1e-5);
        apart = std::max({apart, std::fabs(x[i] - y[i]), std::fabs(y[i] - z[i])});
    }
    EXPECT_GT(apart, 0.1) << "three readings alike show nothing";
    // The floor's reading is that of the slopes straight above.
    for (std::size_t i = 0; i < 16; ++i) {
        const glm::dvec3 s = pool3::surface((static_cast<double>(i) + 0.5) / 16 - 0.5, 0.5 / 16 - 0.5);
        EXPECT_NEAR(z[i], test::lookupOmega({s.y, s.z}, sun(), pool3::kIor, 100, 2, 0), 2e-3);
    }
}

TEST_F(WaterLookup, GodRaysSumCrossingsOfPlanesOverTheDistance) {
    // Still water: omega = 1, so gamma is the sum of rho over the crossings, counted here one by one.
    fill(test::sampleWater(16, [](double, double) { return 0.0; }));
    LookupOptions options;
    options.plane_distance = 0.2f, options.plane_fade = 0.5f, options.plane_samples = 32;
    setLookup(options);
    const glm::dvec3 eye{0.13, -0.4, -0.35}, direction = glm::normalize(glm::dvec3(0.7, 0.4, -0.2));
    const double limit = 2.6;
    const glm::dvec3 light = test::refracted(sun(), {0, 0, 1}, 1, pool3::kIor);
    double sum = 0, last = 0;
    int count = 0;
    std::vector<double> crossings;
    for (int axis = 0; axis < 2; ++axis) {
        const double lean = light[axis] / light.z;
        const double from = eye[axis] - lean * eye.z, along = direction[axis] - lean * direction.z;
        for (int k = -100; k <= 100; ++k) {
            const double t = (k * 0.2 - from) / along;
            if (t > 0 && t < limit) crossings.push_back(t);
        }
    }
    std::sort(crossings.begin(), crossings.end());
    for (const double t : crossings) {
        if (count++ == 32) break;
        const double depth = -(eye.z + t * direction.z), part = std::clamp(depth / 0.5, 0.0, 1.0);
        sum += part * part * (3 - 2 * part), last = t;
    }
    ASSERT_GT(crossings.size(), 10u);
    const auto pixels = run("vec4(photicGodRays(vec3(0.13, -0.4, -0.35), normalize(vec3(0.7, 0.4, -0.2)), 2.6))", 2);
    EXPECT_NEAR(pixels[0], sum / last, 2e-4);
}

TEST_F(WaterLookup, GodRaysStandStillWhenTheEyeMoves) {
    // Eyes along one line of sight, up to the same end, sample the same places.
    fill(test::pool3Water(128));
    LookupOptions options;
    options.plane_distance = 0.2f, options.plane_samples = 64;
    setLookup(options);
    const auto sumFrom = [&](double back) {
        const auto p = run("vec4(photicGodRays(vec3(0.03, -0.4, -0.8) - " + std::to_string(back) +
                               " * normalize(vec3(0.7, 0.4, -0.2)), normalize(vec3(0.7, 0.4, -0.2)), " +
                               std::to_string(1.5 + back) + "))",
                           1);
        return static_cast<double>(p[0]);
    };
    // Steps back that cross no plane change only the distance gone, D: gamma = sum / D, so 1 / gamma grows linearly.
    const double a = sumFrom(0), b = sumFrom(0.02), c = sumFrom(0.04);
    EXPECT_GT(a, 0.01);
    EXPECT_GT(1 / b - 1 / a, 0);
    EXPECT_NEAR((1 / c - 1 / a) / (1 / b - 1 / a), 2, 0.01);
}

TEST_F(WaterLookup, IsNotWhereTheLightIs) {
    // What the paper gives up for its speed, measured: docs/runtime.md prints these figures.
    fill(test::pool3Water(512));
    const auto truth = pool3::exactFloor().values;
    double best = 0;
    for (const float tau : {10.0f, 30.0f, 100.0f, 300.0f, 1000.0f}) {
        LookupOptions options;
        options.tightening = tau, options.tightening_per_metre = 0;
        setLookup(options);
        const auto like = test::likeness(onFloor(512), truth);
        best = std::max(best, like.correlation);
        std::printf("look-up, tau %6.0f: correlation %.3f, energy %.3f, relative L1 %.3f\n", tau, like.correlation,
                    like.energy, like.relative_l1);
    }
    EXPECT_GT(best, 0.05);
    EXPECT_LT(best, 0.9) << "better than thought: say so in docs/runtime.md";
}

TEST_F(WaterLookup, NonsenseIsRefused) {
    WaterLight light;
    light.direction[2] = 1;
    EXPECT_FALSE(water_->setLight(light).ok());
    light = {};
    light.ior = 0.9f;
    EXPECT_FALSE(water_->setLight(light).ok());
    LookupOptions options;
    options.plane_distance = 0;
    EXPECT_FALSE(water_->setLookup(options).ok());
    EXPECT_FALSE(water_->updateCausticMap({}).ok()) << "no heights yet";
}

}  // namespace
}  // namespace photic::runtime
