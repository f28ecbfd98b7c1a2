// SPDX-License-Identifier: Apache-2.0
#include "bake/optics/beer_lambert.h"

#include <gtest/gtest.h>

namespace photic {
namespace {

TEST(BeerLambert, MeanTransmittanceAgreesWithExtendedPrecision) {
    for (double x = 1e-18; x < 700; x *= 1.07) {
        const long double exact = -std::expm1(-static_cast<long double>(x)) / x;
        EXPECT_NEAR(meanTransmittance(x) / static_cast<double>(exact), 1, 3e-16) << x;
    }
    EXPECT_EQ(meanTransmittance(0), 1);
}

TEST(BeerLambert, NoJumpWhereTheSeriesEnds) {
    const double below = meanTransmittance(std::nextafter(0.02, 0)), above = meanTransmittance(0.02);
    EXPECT_NEAR(below / above, 1, 4e-16);
}

TEST(BeerLambert, SegmentsAddUp) {
    const double sigma = 0.37;
    double sum = 0;
    for (int k = 0; k < 1000; ++k) sum += meanTransmittance(sigma, 0.004 * k, 0.004) * 0.004;
    EXPECT_NEAR(sum, (1 - std::exp(-sigma * 4.0)) / sigma, 1e-13);
}

TEST(BeerLambert, StepsNeedNoExponential) {
    double transmittance = 1;
    for (int k = 0; k < 1000; ++k) transmittance *= 1 - 0.003 * meanTransmittance(0.003);
    EXPECT_NEAR(transmittance, std::exp(-3.0), 1e-14);
}

TEST(BeerLambert, ClearMediumTransmitsAll) { EXPECT_EQ(meanTransmittance(0.0, 5.0, 2.0), 1); }

}  // namespace
}  // namespace photic
