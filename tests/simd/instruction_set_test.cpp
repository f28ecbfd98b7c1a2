// SPDX-License-Identifier: Apache-2.0
#include "bake/simd/instruction_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>

#include "bake/report/error.h"

namespace photic {
namespace {

constexpr const char* kVariable = "PHOTIC_INSTRUCTION_SET";

/// Keeps what the environment said before the test.
class Environment : public testing::Test {
protected:
    void SetUp() override {
        if (const char* value = std::getenv(kVariable)) before_ = value;
        unsetenv(kVariable);
    }
    void TearDown() override { before_ ? setenv(kVariable, before_->c_str(), 1) : unsetenv(kVariable); }
    static InstructionSet bestWith(const char* value) {
        setenv(kVariable, value, 1);
        return bestInstructionSet();
    }

private:
    std::optional<std::string> before_;
};

TEST_F(Environment, SetsAreInOrderAndTheBestIsTheLast) {
    const auto sets = instructionSets();
    ASSERT_FALSE(sets.empty());
    EXPECT_EQ(sets.front(), InstructionSet::Portable);
    for (std::size_t i = 1; i < sets.size(); ++i) {
        EXPECT_LT(sets[i - 1], sets[i]);
        EXPECT_LT(widestLanes(sets[i - 1]), widestLanes(sets[i]));
    }
    EXPECT_EQ(bestInstructionSet(), sets.back());
}

TEST_F(Environment, EnvironmentLowersTheSet) {
    const InstructionSet best = bestInstructionSet();
    for (const auto set : {InstructionSet::Portable, InstructionSet::Avx2, InstructionSet::Avx512})
        EXPECT_EQ(bestWith(name(set)), std::min(set, best)) << name(set);
    EXPECT_EQ(bestWith(""), best);
}

TEST_F(Environment, UnknownSetIsRefused) {
    for (const char* wrong : {"sse", "AVX2", "avx2 ", "scalar"}) {
        try {
            bestWith(wrong);
            FAIL() << wrong;
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::Usage);
            EXPECT_EQ(e.where(), kVariable);
            const std::string message = e.what();
            EXPECT_NE(message.find("'" + std::string(wrong) + "'"), std::string::npos) << message;
            EXPECT_NE(message.find("portable, avx2 or avx512"), std::string::npos) << message;
        }
    }
}

}  // namespace
}  // namespace photic
