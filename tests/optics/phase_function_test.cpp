// SPDX-License-Identifier: Apache-2.0
#include "bake/optics/phase_function.h"

#include <gtest/gtest.h>

namespace photic {
namespace {

TEST(PhaseFunction, IsNormalisedWithMeanCosineG) {
    for (const double g : {-0.9, -0.3, 0.0, 0.5, 0.8, 0.95, 0.99}) {
        // Midpoint rule in angle: the integrand is smooth and periodic, so it converges fast.
        const int n = 200000;
        double total = 0, cosine = 0;
        for (int k = 0; k < n; ++k) {
            const double angle = (k + 0.5) * std::numbers::pi / n, c = std::cos(angle);
            const double ring = 2 * std::numbers::pi * std::sin(angle) * std::numbers::pi / n * henyeyGreenstein(c, g);
            total += ring, cosine += ring * c;
        }
        EXPECT_NEAR(total, 1, 1e-6) << g;
        EXPECT_NEAR(cosine, g, 1e-6) << g;
    }
}

TEST(PhaseFunction, IsotropicIsConstant) {
    for (const double c : {-1.0, 0.0, 1.0}) EXPECT_DOUBLE_EQ(henyeyGreenstein(c, 0), 1 / (4 * std::numbers::pi));
}

TEST(PhaseFunction, PeaksForwards) {
    const double g = 0.8;
    EXPECT_NEAR(henyeyGreenstein(1, g), (1 - g * g) / (4 * std::numbers::pi * std::pow(1 - g, 3)), 1e-12);
    EXPECT_NEAR(henyeyGreenstein(1, g) / henyeyGreenstein(-1, g), std::pow((1 + g) / (1 - g), 3), 1e-9);
}

}  // namespace
}  // namespace photic
