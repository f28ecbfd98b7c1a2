// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bake/methods/beams.h"
#include "bake/methods/eikonal.h"
#include "bake/methods/photons.h"
#include "bake/methods/wave.h"
#include "bake/optics/snell.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "tests/methods/eikonal_bakes.h"

namespace photic {
namespace {

using test::bakeEikonal;
using test::forLit;
using test::kMarching;
using test::options;
using test_scenes::boxFrame;
using test_scenes::CosineField;
using test_scenes::waterScene;

constexpr double kFirst = 1.77, kGrowth = 0.6;  // n^2 = kFirst - kGrowth z

std::shared_ptr<const IndexVolume> stratified() {
    IndexVolume::Samples samples;
    constexpr int count = 201;
    samples.size = {1, 1, count};
    samples.world_from_index[2].z = 0.01;
    samples.origin_world.z = -1.6;
    for (int k = 0; k < count; ++k)
        samples.values.push_back(static_cast<float>(std::sqrt(kFirst - kGrowth * (-1.6 + 0.01 * k))));
    return std::make_shared<IndexVolume>(std::move(samples), 1.333);
}

/// Flat water whose n^2 grows linearly downwards: rays are parabolas, and all is known in closed form.
struct Parabolas {
    double px, py;  // n times the direction across, which stays as it is
    double squared() const { return px * px + py * py; }
    double n2(double z) const { return kFirst - kGrowth * z; }
    double cosine(double z) const { return std::sqrt(1 - squared() / n2(z)); }
    double arrival(const glm::dvec3& p) const {
        const auto part = [&](double z) { return std::pow(n2(z) - squared(), 1.5); };
        return px * p.x + py * p.y + 2 / (3 * kGrowth) * (part(p.z) - part(0));
    }
    double curvature(double z) const { return kGrowth * squared() / (2 * n2(z) * n2(z) * cosine(z)); }
};

/// Arrival, direction, curvature and irradiance below flat water in which the index grows with depth, sides included.
TEST(EikonalIndex, StratifiedWaterFollowsItsParabolas) {
    const double zenith = 0.9;
    Scene scene = waterScene(zenith);
    scene.index = stratified();
    const Parabolas truth{scene.lights[0].direction.x, scene.lights[0].direction.y};
    const double enters =
        fresnelTransmittance(std::cos(zenith), truth.cosine(0), 1, std::sqrt(kFirst)) * std::cos(zenith);
    double last_t = 0, last_k = 0;
    for (const int n : {32, 64, 128}) {
        const BakeResult r = bakeEikonal(scene, {-0.25, -0.25, -1}, {n / 2, n / 2, n}, 1.0 / n);
        double t = 0, k = 0, sum_k = 0, turned = 0, light = 0;
        std::int64_t count = 0;
        forLit(r, [&](const glm::ivec3& v) {
            const glm::dvec3 p = r.field.frame().worldFromIndex(glm::dvec3(v));
            t += std::fabs(double(r.arrival_time->value(v, 0)) - truth.arrival(p));
            if (p.z < -4.0 / n) {
                k += std::fabs(double(r.caustic->value(v, 0)) - truth.curvature(p.z)), sum_k += truth.curvature(p.z);
            }
            const glm::dvec3 w = r.field.flux(v) / double(r.field.value(v, 0));
            turned = std::max(turned, std::fabs(w.z + truth.cosine(p.z)));
            light = std::max(light, std::fabs(double(r.field.value(v, 0)) * truth.cosine(p.z) / enters - 1));
            ++count;
        });
        t /= double(count), k /= sum_k;
        EXPECT_LT(turned, 6e-2 / n) << n;
        EXPECT_LT(light, 1.0 / n) << n;
        if (n > 32) {
            EXPECT_GT(std::log2(last_t / t), 1.7) << n << ": " << last_t << " " << t;
        }
        last_t = t, last_k = k;
    }
    EXPECT_LT(last_t * 128, 1e-4);  // cells
    EXPECT_LT(last_k, 1e-4);        // the index is stored in single precision
    EXPECT_EQ(bakeEikonal(scene, {-0.25, -0.25, -0.5}, {8, 8, 8}, 1.0 / 16).metadata.count("single_arrival_fraction"),
              0u);
}

/// SELFOC glass, n^2 = n0^2 (1 - g^2 x^2), under a front that falls straight in: rays swing to the axis.
TEST(EikonalIndex, AcrossTheLightItFocusesAsSelfocDoes) {
    constexpr double n0 = 1.5, g = 0.9;
    IndexVolume::Samples samples;
    constexpr int count = 401;
    samples.size = {count, 1, 1};
    samples.world_from_index[0].x = 0.01;
    samples.origin_world.x = -2;
    for (int i = 0; i < count; ++i) {
        const double x = -2 + 0.01 * i;
        samples.values.push_back(static_cast<float>(n0 * std::sqrt(std::max(0.3, 1 - g * g * x * x))));
    }
    Scene scene = waterScene(0);
    scene.lights[0].direction = {0, 0, -1};
    scene.index = std::make_shared<IndexVolume>(std::move(samples), 1.333);
    double last = 0;
    for (const int n : {32, 64, 128}) {
        const BakeResult r = bakeEikonal(scene, {-0.3125, -2.0 / n, -0.625}, {5 * n / 8, 4, 5 * n / 8}, 1.0 / n);
        double error = 0;
        std::int64_t counted = 0;
        forLit(r, [&](const glm::ivec3& v) {
            const glm::dvec3 p = r.field.frame().worldFromIndex(glm::dvec3(v));
            // The ray x = x0 cos(w s), z = -n(x0) s through the place, w = n0 g.
            const double w = n0 * g;
            double x0 = p.x, s = 0;
            for (int i = 0; i < 60; ++i) {
                s = -p.z / (n0 * std::sqrt(1 - g * g * x0 * x0));
                x0 = p.x / std::cos(w * s);
            }
            const double t = n0 * n0 * (s - g * g * x0 * x0 * (s / 2 + std::sin(2 * w * s) / (4 * w)));
            error += std::fabs(double(r.arrival_time->value(v, 0)) - t), ++counted;
        });
        error /= double(counted);
        if (n > 32) {
            EXPECT_GT(std::log2(last / error), 1.6) << n << ": " << last << " " << error;
        }
        last = error;
    }
    EXPECT_LT(last * 128, 5e-5);
}

/// An index that is constant after all gives what marching gives without a volume.
TEST(EikonalIndex, AConstantVolumeChangesLittle) {
    Scene scene = waterScene(0.4, std::make_shared<CosineField>(0.03, 6));
    const BakeResult without = bakeEikonal(scene, {-0.5, -0.125, -0.6}, {64, 16, 32}, 1.0 / 64, kMarching);
    scene.surfaces[0].ior_below = 1.2;  // the volume has the word
    scene.index = std::make_shared<IndexVolume>(layeredIndex({{0, 1.333}}));
    const BakeResult with = bakeEikonal(scene, {-0.5, -0.125, -0.6}, {64, 16, 32}, 1.0 / 64);
    double t = 0, light = 0, sum = 0;
    forLit(without, [&](const glm::ivec3& v) {
        t = std::max(t, std::fabs(double(with.arrival_time->value(v, 0) - without.arrival_time->value(v, 0))));
        light += std::fabs(double(with.field.value(v, 0) - without.field.value(v, 0)));
        sum += double(without.field.value(v, 0));
    });
    EXPECT_LT(t * 64, 2e-3);  // cells
    EXPECT_LT(light / sum, 2e-3);
}

TEST(EikonalIndex, SaysWhatDoesNotGoTogether) {
    Scene scene = waterScene(0.3);
    scene.index = stratified();
    for (const Method& method : {beamsMethod(), photonsMethod()})
        EXPECT_NE(method.refusal(scene).find("[[index]]"), std::string::npos) << method.name;
    EXPECT_EQ(eikonalMethod().refusal(scene), "");
    EXPECT_THROW(bakeEikonal(scene, {0, 0, -1}, {8, 8, 8}, 0.1, options({{"solver", std::string("foot_points")}})),
                 Error);
    EXPECT_THROW(bakeEikonal(scene, {0, 0, -1}, {8, 8, 8}, 0.1, options({{"preset", std::string("mercier")}})), Error);
    EXPECT_THROW(bakeEikonal(scene, {0, 0, -1}, {8, 8, 8}, 0.1, options({{"beyond", std::string("dark")}})), Error);
    scene.index = std::make_shared<IndexVolume>(layeredIndex({{0, 1.2}, {-1, 0.9}}));
    EXPECT_NE(eikonalMethod().refusal(scene).find("0.9"), std::string::npos);
}

Scene underPoint(double height, std::shared_ptr<const HeightField> field = std::make_shared<CosineField>(0, 1)) {
    Scene scene = waterScene(0, std::move(field));
    scene.lights[0].position = glm::dvec3(0, 0, height);
    scene.lights[0].direction = {0, 0, -1};
    return scene;
}

/// A lamp over flat water: Fermat's path and the area that a bundle of rays gets, by both solvers.
TEST(EikonalPoint, LampOverFlatWater) {
    constexpr double H = 0.8, n2 = 1.333;
    for (const GivenOptions& given : {GivenOptions{}, kMarching}) {
        const BakeResult r = bakeEikonal(underPoint(H), {-0.5, -0.5, -0.9}, {48, 48, 48}, 1.0 / 48, given);
        const bool marching = !given.empty();
        double t = 0, light = 0, turned = 0, count = 0;
        forLit(r, [&](const glm::ivec3& v) {
            const glm::dvec3 p = r.field.frame().worldFromIndex(glm::dvec3(v));
            const double R = std::hypot(p.x, p.y), s = -p.z;
            double low = 0, high = std::asin(1.0) - 1e-9;  // the angle in the air
            const auto below = [&](double a) { return std::asin(std::sin(a) / n2); };
            for (int i = 0; i < 80; ++i) {
                const double a = 0.5 * (low + high);
                (H * std::tan(a) + s * std::tan(below(a)) < R ? low : high) = a;
            }
            const double a = low, b = below(a);
            t = std::max(t, std::fabs(double(r.arrival_time->value(v, 0)) - H / std::cos(a) - n2 * s / std::cos(b)));
            const double widening = H / std::pow(std::cos(a), 2) + s / std::pow(std::cos(b), 3) * std::cos(a) / n2;
            const double per_angle = R > 1e-9 ? std::sin(a) / R : 1 / (H + s / n2);
            const double e =
                H * H * fresnelTransmittance(std::cos(a), std::cos(b), 1, n2) * per_angle / (widening * std::cos(b));
            light += std::fabs(double(r.field.value(v, 0)) / e - 1), ++count;
            const glm::dvec3 w = r.field.flux(v) / double(r.field.value(v, 0));
            turned = std::max(turned, std::fabs(w.z + std::cos(b)));
        });
        EXPECT_LT(t * 48, marching ? 5e-3 : 1e-5) << marching;  // cells; arrivals are stored as floats
        EXPECT_LT(light / count, marching ? 5e-3 : 1e-6) << marching;
        EXPECT_LT(turned, marching ? 1e-3 : 1e-5) << marching;
    }
}

/// A lamp far away is a sun, under waves too.
TEST(EikonalPoint, FarAwayItIsASun) {
    const auto field = std::make_shared<CosineField>(0.03, 6);
    const Scene sun = waterScene(0.4, field);
    Scene lamp = sun;
    constexpr double far = 1e5;
    lamp.lights[0].position = -far * sun.lights[0].direction;
    const BakeResult a = bakeEikonal(sun, {-0.5, -0.125, -0.6}, {64, 16, 32}, 1.0 / 64);
    const BakeResult b = bakeEikonal(lamp, {-0.5, -0.125, -0.6}, {64, 16, 32}, 1.0 / 64);
    forLit(a, [&](const glm::ivec3& v) {
        ASSERT_NEAR(double(b.field.value(v, 0)), double(a.field.value(v, 0)), 1e-3);  // the table's spacing differs
        ASSERT_NEAR(double(b.caustic->value(v, 0)), double(a.caustic->value(v, 0)), 5e-3);
    });
    EXPECT_NEAR(std::stod(b.metadata.at("first_caustic_z")), std::stod(a.metadata.at("first_caustic_z")), 5e-3);
    lamp.lights[0].type = LightType::Point;
    EXPECT_NE(waveMethod().refusal(lamp), "");
}

}  // namespace
}  // namespace photic
