// SPDX-License-Identifier: Apache-2.0
// Look-ups by the thousand give what look-ups one by one give.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "photic/runtime.h"
#include "runtime/src/sample_many.h"
#include "tests/runtime/loaded_volume.h"

namespace photic::runtime {
namespace {

using test::NvdbEncoding;
using test::NvdbSpec;

/// Points around and inside the volume, and some that lie nowhere.
std::vector<Vec3> points(std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> at(-14, 24);
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back({at(random), at(random), at(random)});
    if (count > 7) out[3].y = std::nan(""), out[5].z = 1e300, out[7].x = -INFINITY;
    return out;
}

void expectNear(const Vec3& a, const Vec3& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

void expectSameAsOneByOne(const Volume& volume) {
    constexpr double kTolerance = 20 * 500 * 1e-6;  // of the largest value
    for (const std::size_t count : {0U, 1U, 31U, 32U, 33U, 3000U}) {
        const std::vector<Vec3> world = points(count);
        std::vector<Vec3> normals = points(count);
        if (count > 2) normals[2] = {0, 0, 0};
        std::vector<Light> light(count);
        std::vector<Vec3> irradiance(count);
        volume.sample(world, light);
        volume.irradiance(world, normals, irradiance);
        // The processor's own conversion of halves changes no bit.
        std::vector<Light> portable(count);
        sampleMany(volume.data(), world, portable, HalfConversion::Never);
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_EQ(light[i].irradiance.x, portable[i].irradiance.x);
            EXPECT_EQ(light[i].irradiance.z, portable[i].irradiance.z);
            EXPECT_EQ(light[i].flux.y, portable[i].flux.y);
            const Light one = volume.sample(world[i]);
            expectNear(light[i].irradiance, one.irradiance, kTolerance);
            expectNear(light[i].flux, one.flux, kTolerance);
            if (std::isnan(normals[i].y) || std::isinf(normals[i].x) || normals[i].z > 1e9) continue;
            expectNear(irradiance[i], volume.irradiance(world[i], normals[i]), 2 * kTolerance);
        }
    }
}

TEST(SampleMany, IsTheSameAsOneByOne) {
    NvdbSpec spec;
    spec.min = {-5, 3, -11};
    spec.max = {20, 17, 9};
    spec.values = test::swirl;
    spec.world_from_index = {1, 0, 0.1, 0, 1, -0.05, 0, 0, 1};
    for (const char* json :
         {R"({"reference_irradiance": 500})", R"({"reference_irradiance": 500, "period": [26, 15, 0]})"}) {
        for (const bool coloured : {false, true}) {
            spec.coloured = coloured;
            spec.json = json;
            expectSameAsOneByOne(test::loaded(spec));
        }
    }
    expectSameAsOneByOne(Volume());
}

TEST(SampleMany, WithoutDirectionsToo) {
    NvdbSpec spec;
    spec.values = test::swirl;
    spec.encoding = NvdbEncoding::Direction;
    spec.json = R"({"reference_irradiance": 500})";
    expectSameAsOneByOne(test::loaded(spec));
}

TEST(SampleMany, OfSpansTheShortestCounts) {
    NvdbSpec spec;
    spec.values = test::swirl;
    const Volume volume = test::loaded(spec);
    const std::vector<Vec3> world(10, Vec3{8, 8, 8});
    std::vector<Light> light(4);
    volume.sample(world, light);
    EXPECT_GT(light[3].irradiance.x, 0);
    std::vector<Vec3> irradiance(10, Vec3{-1, -1, -1});
    volume.irradiance(world, std::vector<Vec3>(3, Vec3{0, 0, 1}), irradiance);
    EXPECT_GE(irradiance[2].x, 0);
    EXPECT_EQ(irradiance[3].x, -1);
}

TEST(SampleMany, NormalsNeedNotBeUnit) {
    NvdbSpec spec;
    spec.values = test::swirl;
    const Volume volume = test::loaded(spec);
    const Vec3 place = {7.3, 8.6, 5.1};
    const double unit = volume.irradiance(place, {0.6, 0, 0.8}).x;
    EXPECT_GT(unit, 0);
    EXPECT_NEAR(volume.irradiance(place, {1.2, 0, 1.6}).x, unit, 1e-12 * unit);
    EXPECT_EQ(volume.irradiance(place, {0, 0, 0}).x, 0);
}

}  // namespace
}  // namespace photic::runtime
