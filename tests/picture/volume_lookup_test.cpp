// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/volume_lookup.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/picture/volumes.h"

namespace photic {
namespace {

using test::cubicFrame;
using test::makeVolume;

// A field that is linear in the world's coordinates: trilinear interpolation must return it exactly.
std::vector<double> linearAt(const glm::dvec3& p) {
    const double e = 5 + 0.5 * p.x - 0.25 * p.y + 0.125 * p.z;
    return {e, 0.5 * p.x, -0.25 * p.y, -e + p.z};
}

void expectLinear(const GridFrame& frame) {
    const LightVolume volume =
        makeVolume(frame, 1, [&](const glm::ivec3& v) { return linearAt(frame.worldFromIndex(glm::dvec3(v))); });
    const VolumeLookup lookup(volume);
    for (int i = 0; i < 200; ++i) {
        // A Kronecker sequence between the outermost voxel centres.
        const glm::dvec3 t = glm::fract(glm::dvec3(0.8192, 0.6711, 0.5497) * static_cast<double>(i + 1));
        const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(frame.min) + t * glm::dvec3(frame.size() - 1));
        const auto expected = linearAt(p);
        const LookedUpLight sample = lookup.at(p);
        EXPECT_NEAR(sample.irradiance.x, expected[0], 2e-6);
        EXPECT_NEAR(sample.flux.x, expected[1], 2e-6);
        EXPECT_NEAR(sample.flux.y, expected[2], 2e-6);
        EXPECT_NEAR(sample.flux.z, expected[3], 2e-6);
    }
}

TEST(VolumeLookup, ReproducesALinearField) { expectLinear(cubicFrame(0.25, {-9, -3, 2}, {10, 14, 12})); }

TEST(VolumeLookup, ReproducesALinearFieldOnAShearedGrid) {
    GridFrame frame = cubicFrame(0.25, {-4, -4, -4}, {11, 11, 11});
    frame.setWorldFromIndex({0.25, 0, 0, 0, 0.25, 0, 0.1, -0.07, 0.5});
    expectLinear(frame);
}

TEST(VolumeLookup, TakesVoxelsThatAreNotActiveAsDark) {
    const GridFrame frame = cubicFrame(1, {0, 0, 0}, {15, 15, 15});
    const auto one = [](const glm::ivec3&) { return std::vector<double>{1, 0, 0, -1}; };
    const LightVolume volume = makeVolume(frame, 1, one, [](const glm::ivec3& v) { return v.z < 8; });
    const VolumeLookup lookup(volume);
    // Voxel centres lie at i + 1/2; between the last active layer (7.5) and the first dark one (8.5) light fades
    // linearly.
    EXPECT_NEAR(lookup.at({5, 5, 7.5}).irradiance.x, 1.0, 1e-12);
    EXPECT_NEAR(lookup.at({5, 5, 8.0}).irradiance.x, 0.5, 1e-12);
    EXPECT_NEAR(lookup.at({5, 5, 8.25}).irradiance.x, 0.25, 1e-12);
    EXPECT_EQ(lookup.at({5, 5, 8.5}).irradiance.x, 0.0);
    EXPECT_EQ(lookup.at({-40, 5, 5}).irradiance.x, 0.0);
    EXPECT_EQ(lookup.at({1e300, NAN, 5}).irradiance.x, 0.0);
}

TEST(VolumeLookup, ReceiverGetsTheFluxThroughItsFront) {
    const GridFrame frame = cubicFrame(1, {0, 0, 0}, {7, 7, 7});
    const LightVolume volume = makeVolume(frame, 1, [](const glm::ivec3&) {
        return std::vector<double>{2, 0.9, 0, -1.2};
    });
    const VolumeLookup lookup(volume);
    EXPECT_NEAR(lookup.receiverIrradiance({4, 4, 4}, {0, 0, 1}).x, 1.2, 1e-6);
    EXPECT_NEAR(lookup.receiverIrradiance({4, 4, 4}, {-1, 0, 0}).x, 0.9, 1e-6);
    EXPECT_EQ(lookup.receiverIrradiance({4, 4, 4}, {0, 0, -1}).x, 0.0);
    const glm::dvec3 n = glm::normalize(glm::dvec3(-3, 0, 4));
    EXPECT_NEAR(lookup.receiverIrradiance({4, 4, 4}, n).x, 0.9 * 0.6 + 1.2 * 0.8, 1e-6);
}

TEST(VolumeLookup, ColouredReceiverScalesEachChannelByTheDirection) {
    const GridFrame frame = cubicFrame(1, {0, 0, 0}, {7, 7, 7});
    // Mean irradiance 2, flux (0, 0, -1): direction (0, 0, -1/2).
    const LightVolume volume =
        makeVolume(frame, 3, [](const glm::ivec3&) { return std::vector<double>{3, 2, 1, 0, 0, -1}; });
    const glm::dvec3 e = VolumeLookup(volume).receiverIrradiance({4, 4, 4}, {0, 0, 1});
    EXPECT_NEAR(e.x, 1.5, 1e-6);
    EXPECT_NEAR(e.y, 1.0, 1e-6);
    EXPECT_NEAR(e.z, 0.5, 1e-6);
}

TEST(VolumeLookup, WithoutDirectionAReceiverGetsTheFluenceRate) {
    const GridFrame frame = cubicFrame(1, {0, 0, 0}, {7, 7, 7});
    LightVolume volume = makeVolume(frame, 1, [](const glm::ivec3&) { return std::vector<double>{2, 0, 0, -1}; });
    volume.has_direction = false;
    EXPECT_NEAR(VolumeLookup(volume).receiverIrradiance({4, 4, 4}, {1, 0, 0}).x, 2.0, 1e-6);
}

}  // namespace
}  // namespace photic
