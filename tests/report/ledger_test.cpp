// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bake/report/bake_report.h"
#include "bake/report/error.h"
#include "bake/report/monitor.h"

namespace photic {
namespace {

TEST(PowerLedger, EveryTermIsAccountedFor) {
    // A term that is added to the struct and forgotten in a sum shows here.
    double value = 1, sum = 0;
    PowerLedger power;
    for (double PowerLedger::*const term : PowerLedger::kTerms) {
        if (term == &PowerLedger::emitted) continue;
        power.*term = value, sum += value, value *= 2;
    }
    EXPECT_EQ(sizeof(PowerLedger), sizeof(double) * std::size(PowerLedger::kTerms));
    EXPECT_DOUBLE_EQ(power.accounted(), sum);
    power.emitted = sum;
    EXPECT_EQ(power.imbalance(), 0);
    power.emitted = 2 * sum;
    EXPECT_DOUBLE_EQ(power.imbalance(), 0.5);
    EXPECT_EQ(PowerLedger{}.imbalance(), 0) << "without light";
}

TEST(GivenUpPower, EveryTermIsSummed) {
    GivenUpPower power;
    double value = 1, sum = 0;
    for (double GivenUpPower::*const term : GivenUpPower::kTerms) power.*term = value, sum += value, value *= 2;
    EXPECT_EQ(sizeof(GivenUpPower), sizeof(double) * std::size(GivenUpPower::kTerms));
    EXPECT_EQ(power.sum(), sum);
}

TEST(PathLedger, IsRelativeWhereLightWasExpected) {
    EXPECT_DOUBLE_EQ((PathLedger{1.5, 1.0}.imbalance()), 0.5);
    EXPECT_DOUBLE_EQ((PathLedger{0.25, 0.0}.imbalance()), 0.25) << "light that nobody expected";
}

TEST(Monitor, ACancelledOneEndsTheWork) {
    class Impatient : public Monitor {
        bool cancelled() const override { return true; }
    };
    EXPECT_NO_THROW(Monitor().checkCancelled());
    try {
        Impatient().checkCancelled();
        ADD_FAILURE() << "went on";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Cancelled);
        EXPECT_EQ(static_cast<int>(error.code()), 130);
    }
}

}  // namespace
}  // namespace photic
