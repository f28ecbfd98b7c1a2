// SPDX-License-Identifier: Apache-2.0
#include "tests/support/pool3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

namespace photic::truth {
namespace {

TEST(Pool3, MapHasThePublishedFigures) {
    const FloorMap map = pool3::exactFloor();
    EXPECT_NEAR(std::accumulate(map.values.begin(), map.values.end(), 0.0) / (512 * 512), 0.853119, 1e-6);
    EXPECT_NEAR(*std::max_element(map.values.begin(), map.values.end()), 30.452, 1e-3);
}

TEST(Pool3, IndependentGeneratorConvergesToTheMap) {
    const FloorMap exact = pool3::exactFloor();
    double last = 0;
    for (const int mesh : {256, 512, 1024}) {
        const double error = relativeL1(pool3::traceFloor(mesh, 512, pool3::sun()).values, exact.values);
        RecordProperty("relative_l1_" + std::to_string(mesh), std::to_string(error));
        if (last > 0) {
            EXPECT_GT(std::log2(last / error), 1.8) << mesh;
        }
        last = error;
    }
    EXPECT_LT(last, 0.004);
}

TEST(Pool3, DiscMapIsTheMeanOfItsDirections) {
    // 16 of the directions stand in for 512: the same light, blurred by the disc, with seams of a sixteenth.
    const FloorMap disc = pool3::exactDiscFloor();
    std::vector<double> mean(512 * 512);
    for (const auto& direction : pool3::discDirections(pool3::sun(), 0.53, 16)) {
        const FloorMap map = pool3::traceFloor(512, 512, direction);
        for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += map.values[i] / 16;
    }
    EXPECT_LT(relativeL1(mean, disc.values), 0.03);
    EXPECT_GT(relativeL1(pool3::exactFloor().values, disc.values), 0.1);
}

TEST(Pool3, ErrorsAreMeasuredRelativeToTheReference) {
    EXPECT_DOUBLE_EQ(relativeL1({1, 3}, {2, 2}), 0.5);
    EXPECT_DOUBLE_EQ(relativeRmse({1, 5}, {2, 2}), std::sqrt(5.0) / 2);
}

TEST(Pool3, DiscDirectionsShareTheDisc) {
    const glm::dvec3 axis = pool3::sun();
    const auto directions = pool3::discDirections(axis, 0.53, 512);
    glm::dvec3 mean(0);
    double widest = 0, square = 0;
    for (const auto& d : directions) {
        mean += d / 512.0;
        const double angle = std::asin(glm::length(glm::cross(axis, d))) * 180 / M_PI;
        widest = std::max(widest, angle), square += angle * angle / 512;
    }
    EXPECT_LT(glm::length(glm::cross(axis, mean)), 2e-5);
    EXPECT_LT(widest, 0.265);
    EXPECT_NEAR(square, 0.265 * 0.265 / 2, 1e-5);  // second moment of a uniform disc
}

}  // namespace
}  // namespace photic::truth
