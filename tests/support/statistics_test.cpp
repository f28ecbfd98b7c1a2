// SPDX-License-Identifier: Apache-2.0
#include "tests/support/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photic::truth {
namespace {

TEST(Statistics, TailsAreThoseOfTheTables) {
    EXPECT_NEAR(studentTail(2.1314495, 15), 0.025, 1e-5);
    EXPECT_NEAR(studentTail(4.0727652, 15), 0.0005, 1e-6);
    EXPECT_NEAR(studentTail(1, 1), 0.25, 1e-12);  // Cauchy
    EXPECT_NEAR(normalTail(1.959964), 0.025, 1e-8);
}

TEST(Statistics, StudentBecomesNormal) {
    EXPECT_NEAR(normalFromStudent(2.1314495, 15), 1.95996, 1e-4);
    EXPECT_NEAR(normalFromStudent(-4.0727652, 15), -3.29053, 1e-4);
    EXPECT_NEAR(normalFromStudent(3, 1000000), 3, 1e-4);
    EXPECT_NEAR(normalFromStudent(0, 15), 0, 1e-9);
    // The law of t with 63 degrees, integrated: the transformed variable has variance 1, t itself 63/61.
    double square = 0, plain = 0, mass = 0;
    const double c = std::exp(std::lgamma(32.0) - std::lgamma(31.5)) / std::sqrt(63 * M_PI);
    for (double t = -12; t < 12; t += 0.01) {
        const double density = c * std::pow(1 + t * t / 63, -32) * 0.01, z = normalFromStudent(t, 63);
        square += density * z * z, plain += density * t * t, mass += density;
    }
    EXPECT_NEAR(mass, 1, 1e-6);
    EXPECT_NEAR(square, 1, 1e-4);
    EXPECT_NEAR(plain, 63.0 / 61, 1e-4);
}

}  // namespace
}  // namespace photic::truth
