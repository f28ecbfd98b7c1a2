// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/half_float.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photic::runtime {
namespace {

/// A half's value by its definition.
double byDefinition(Half h) {
    const int exponent = h >> 10 & 31, mantissa = h & 1023;
    const double magnitude = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return h & 0x8000 ? -magnitude : magnitude;
}

TEST(HalfFloat, EveryHalfIsExactAndComesBack) {
    for (unsigned bits = 0; bits < 0x10000; ++bits) {
        const auto half = static_cast<Half>(bits);
        const float value = floatOfHalf(half);
        if ((bits & 0x7c00U) == 0x7c00U) {
            EXPECT_FALSE(std::isfinite(value)) << bits;
            continue;
        }
        EXPECT_EQ(value, byDefinition(half)) << bits;
        EXPECT_EQ(halfOfFloat(value), half) << bits;
    }
}

TEST(HalfFloat, RoundsToNearestAndTiesToEven) {
    for (unsigned bits = 0; bits < 0x7bff; ++bits) {
        const double low = byDefinition(static_cast<Half>(bits)), high = byDefinition(static_cast<Half>(bits + 1));
        const auto middle = static_cast<float>((low + high) / 2);
        EXPECT_EQ(halfOfFloat(middle), (bits & 1) ? bits + 1 : bits) << bits;
        EXPECT_EQ(halfOfFloat(std::nextafter(middle, 0.0F)), bits);
        EXPECT_EQ(halfOfFloat(std::nextafter(middle, 1e9F)), bits + 1);
    }
}

TEST(HalfFloat, LargeValuesBecomeInfinite) {
    EXPECT_EQ(halfOfFloat(65504.0F), 0x7bff);
    EXPECT_EQ(halfOfFloat(65519.0F), 0x7bff);
    EXPECT_EQ(halfOfFloat(65520.0F), 0x7c00);
    EXPECT_EQ(halfOfFloat(-1e30F), 0xfc00);
    EXPECT_TRUE(std::isnan(floatOfHalf(halfOfFloat(std::nanf("")))));
}

}  // namespace
}  // namespace photic::runtime
