// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "tests/cli/program.h"

namespace photic::test {
namespace {

/// Starts a bake that would take minutes, waits for it to trace, and stops it.
void interruptedBy(int signal) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 96;
    place.write("pool.toml", pool.text());
    place.write("pool.vdb", "the old volume");
    Program program(
        place, {"bake", "pool.toml", "--method", "photons", "--set", "photons.count=100000000000", "--progress=json"});
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    while (program.errSoFar().find("\"stage\":\"trace\"") == std::string::npos &&
           Clock::now() - start < std::chrono::seconds(20)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    kill(program.pid(), signal);
    const auto sent = Clock::now();
    const Outcome outcome = program.wait();
    EXPECT_LT(Clock::now() - sent, std::chrono::seconds(10));
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_EQ(outcome.events().back()["code"], 130);
    EXPECT_EQ(place.names(), (std::vector<std::string>{"pool.toml", "pool.vdb"}));
    EXPECT_EQ(place.read("pool.vdb"), "the old volume");
}

TEST(Interrupt, SigintEndsABakeCleanly) { interruptedBy(SIGINT); }
TEST(Interrupt, SigtermToo) { interruptedBy(SIGTERM); }

}  // namespace
}  // namespace photic::test
