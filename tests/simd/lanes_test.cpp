// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bake/simd/dispatch.h"
#include "tests/simd/lane_results.h"

namespace photic {

PHOTIC_PER_SET(void laneOperations(int type, const double* a, const double* b, const double* c, const double* d,
                                   LaneResults& out))

namespace {

class Lanes : public testing::TestWithParam<InstructionSet> {
protected:
    void SetUp() override {
        for (std::size_t l = 0; l < 16; ++l) {
            const auto x = static_cast<double>(l);
            // All are floats, so that both kinds of lanes see the same numbers.
            a_[l] = 0.375f + 2.25f * static_cast<float>(l), b_[l] = static_cast<float>((l % 2 ? -1 : 1) * (1.5 * x));
            c_[l] = static_cast<float>(a_[l] * (1 + 1e-6)), d_[l] = static_cast<float>(b_[l] * (1 - 1e-6));
        }
    }
    LaneResults of(int type) const {
        LaneResults out;
        PHOTIC_CHOOSE(GetParam(), laneOperations)(type, a_.data(), b_.data(), c_.data(), d_.data(), out);
        return out;
    }
    LaneResults::Numbers a_{}, b_{}, c_{}, d_{};
};

TEST_P(Lanes, AgreeWithOneNumberAtATime) {
    constexpr int counts[kLaneTypes] = {2, 4, 8, 4, 8, 16};
    for (int type = 0; type < kLaneTypes; ++type) {
        SCOPED_TRACE(type);
        const LaneResults r = of(type);
        ASSERT_EQ(r.count, counts[type]);
        const bool floats = type >= 3;
        for (std::size_t l = 0; l < static_cast<std::size_t>(r.count); ++l) {
            const double a = a_[l], b = b_[l];
            EXPECT_EQ(r.least[l], std::min(a, b));
            EXPECT_EQ(r.most[l], std::max(a, b));
            EXPECT_EQ(r.absolute[l], std::fabs(b));
            EXPECT_EQ(r.clamped[l], std::clamp(b, -1.0, 1.0));
            EXPECT_EQ(r.root[l], floats ? double(std::sqrt(static_cast<float>(a))) : std::sqrt(a));
            EXPECT_EQ(r.whole[l], std::floor(a));
            EXPECT_EQ(r.index[l], static_cast<std::int32_t>(a));
            EXPECT_EQ(r.iota[l], static_cast<double>(l));
            EXPECT_EQ(r.gathered[l], a_[15 - l]);
            if (!floats) continue;
            EXPECT_NEAR(r.difference[l], a * b - c_[l] * d_[l], 2.4e-7 * std::fabs(a * b - c_[l] * d_[l]));
            EXPECT_NEAR(r.reciprocal[l] * a, 1, 1.2e-7);
            EXPECT_NEAR(r.power[l] / std::exp(-a), 1, 3e-7);
        }
        const auto end = b_.begin() + r.count;
        EXPECT_EQ(r.least_lane, *std::min_element(b_.begin(), end));
        EXPECT_EQ(r.most_lane, *std::max_element(b_.begin(), end));
        unsigned less = 0;
        for (std::size_t l = 0; l < static_cast<std::size_t>(r.count); ++l)
            less |= static_cast<unsigned>(a_[l] < b_[l]) << l;
        if (!floats) {
            EXPECT_EQ(r.less, less);
        }
    }
}

/// As minps and maxps: what is no number never wins as the first, always as the second.
TEST_P(Lanes, TakeTheSecondWhereOneIsNoNumber) {
    a_[1] = std::nan("");
    b_[0] = std::nan("");
    for (int type = 0; type < kLaneTypes; ++type) {
        const LaneResults r = of(type);
        EXPECT_TRUE(std::isnan(r.least[0]) && std::isnan(r.most[0])) << type;
        EXPECT_EQ(r.least[1], b_[1]) << type;
        EXPECT_EQ(r.most[1], b_[1]) << type;
    }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, Lanes, testing::ValuesIn(instructionSets()),
                         [](const auto& set) { return name(set.param); });

}  // namespace
}  // namespace photic
