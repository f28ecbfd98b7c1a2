// SPDX-License-Identifier: Apache-2.0
#include "bake/field/deviations.h"

#include <gtest/gtest.h>

namespace photic {
namespace {

TEST(Deviations, NoiseAloneIsChiSquaredOfOne) {
    Deviations d;
    for (const double sign : {-1.0, 1.0}) d.add(5 + sign * 0.1, 5, 0.1), d.add(50 + sign * 2, 50, 2);
    EXPECT_EQ(d.count(), 4u);
    EXPECT_NEAR(d.chi2(), 1, 1e-12);
    EXPECT_EQ(d.bias(), 0);
}

TEST(Deviations, FindTheBiasThatIsThere) {
    // Each is off by its noise and 3 % of it, in quadrature.
    Deviations d;
    for (const double light : {1.0, 20.0, 400.0}) d.add(light * (1 + std::hypot(0.01, 0.03)), light, 0.01 * light);
    EXPECT_NEAR(d.chi2(), 10, 1e-9);
    EXPECT_NEAR(d.chi2(0.03), 1, 1e-9);
    EXPECT_NEAR(d.bias(), 0.03, 1e-9);
}

TEST(Deviations, AnAmountIsForgivenWhereLightIsFaint) {
    Deviations d;
    d.add(0.02, 0.01, 1e-6), d.add(100.01, 100, 1e-6);
    EXPECT_NEAR(d.chi2(0, 0.01), 1, 1e-6);
    EXPECT_GT(d.chi2(0.01, 0), 1000) << "a share of faint light is little";
}

TEST(Deviations, NothingDeviatesByNothing) {
    EXPECT_EQ(Deviations().chi2(), 0);
    EXPECT_EQ(Deviations().bias(), 0);
}

}  // namespace
}  // namespace photic
