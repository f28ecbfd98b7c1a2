// SPDX-License-Identifier: Apache-2.0
#include "bake/threads/parallel_for.h"
#include "bake/report/error.h"
#include "bake/threads/stop_loops.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace photic {
namespace {

class ParallelFor : public ::testing::TestWithParam<int> {
protected:
    void SetUp() override { setThreadCount(GetParam()); }
    void TearDown() override { setThreadCount(0); }
};

TEST_P(ParallelFor, VisitsEachIndexOnce) {
    for (const std::int64_t count : {0, 1, 2, 1000}) {
        std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
        parallelFor(count, [&](std::int64_t i) { ++visits[static_cast<std::size_t>(i)]; });
        for (const auto& n : visits) EXPECT_EQ(n, 1);
    }
}

TEST_P(ParallelFor, LoopsInsideLoopsEnd) {
    std::atomic<int> sum{0};
    parallelFor(20, [&](std::int64_t) { parallelFor(30, [&](std::int64_t j) { sum += static_cast<int>(j); }); });
    EXPECT_EQ(sum, 20 * 29 * 30 / 2);
}

TEST_P(ParallelFor, AFailureOfAnyBodyIsThrown) {
    EXPECT_THROW(parallelFor(100,
                             [](std::int64_t i) {
                                 if (i == 37) throw std::runtime_error("37");
                             }),
                 std::runtime_error);
}

TEST_P(ParallelFor, TinyNumbersAreTheSameOnEveryThread) {
    // 1e-20 squared has no normal float: a thread would keep it, another flush it.
    std::vector<float> products(1000, -1.0f);
    volatile float factor = 1e-20f;
    parallelFor(1000, [&](std::int64_t i) { products[static_cast<std::size_t>(i)] = factor * factor; });
    for (const float p : products) EXPECT_EQ(p, 0.0f);
    // Outside it is as it was.
    EXPECT_GT(factor * factor, 0.0f);
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelFor, ::testing::Values(1, 2, 5));

TEST(ThreadCount, IsWhatWasAskedForOrAllCores) {
    setThreadCount(3);
    EXPECT_EQ(threadCount(), 3);
    setThreadCount(0);
    EXPECT_GE(threadCount(), 1);
}

std::atomic<int> g_calls{0};

TEST(ParallelFor, EndsWhereItIsAskedTo) {
    for (const int threads : {1, 2}) {
        setThreadCount(threads);
        g_calls = 0;
        stopLoopsWhen([] { return g_calls >= 100; });
        EXPECT_THROW(parallelFor(100000, [](std::int64_t) { ++g_calls; }), Error);
        EXPECT_GE(g_calls, 100);
        EXPECT_LT(g_calls, 110);
        stopLoopsWhen(nullptr);
        parallelFor(1000, [](std::int64_t) { ++g_calls; });
        EXPECT_GE(g_calls, 1100);
    }
    setThreadCount(0);
}

}  // namespace
}  // namespace photic
