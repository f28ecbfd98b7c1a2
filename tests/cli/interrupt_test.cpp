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

/// A sequence that is interrupted still reports what was done and what was not.
TEST(Interrupt, IsReported) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    Program program(place, {"bake", "pool.toml", "--method", "photons", "--set", "photons.count=100000000000",
                            "--progress=json", "--report", "report.json"});
    const auto start = std::chrono::steady_clock::now();
    while (program.errSoFar().find("\"stage\":\"trace\"") == std::string::npos &&
           std::chrono::steady_clock::now() - start < std::chrono::seconds(20))
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(program.pid(), SIGTERM);
    EXPECT_EQ(program.wait().code, 130);
    ASSERT_TRUE(place.has("report.json"));
    EXPECT_EQ(nlohmann::json::parse(place.read("report.json"))["error"]["code"], 130);
}

/// The estimate may be wrong: what counts is what is held.
TEST(Interrupt, MoreMemoryThanIsAllowedEndsTheRun) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 208;
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--grids", "irradiance,direction,caustic"}).code, 0);
    const std::string before = place.read("pool.vdb");
    // Reading takes some 130 MB for the volume beside the program's own.
    const Outcome outcome = photic(place, {"post", "pool.vdb", "--as-light", "--step", "dissipate=0,0.9", "-o",
                                           "post.vdb", "--max-memory", "40MB"});
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_NE(outcome.err.find("--max-memory"), std::string::npos) << outcome.err;
    EXPECT_EQ(place.names(), (std::vector<std::string>{"pool.toml", "pool.vdb"}));
    EXPECT_EQ(place.read("pool.vdb"), before);
    // Loops end where they are, and not after all has been read: 180 MB.
    EXPECT_LT(outcome.most_bytes, 110e6);
}

/// Tubes without number: what is held is watched while they are laid, too.
TEST(Interrupt, ARefinementKeepsToTheMemoryThatIsAllowed) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 48;
    place.write("pool.toml", pool.text());
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = photic(place, {"bake", "pool.toml", "--tolerance", "1e-7", "--max-memory", "75MB"});
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_NE(outcome.err.find("--max-memory"), std::string::npos) << outcome.err;
    EXPECT_EQ(place.names(), std::vector<std::string>{"pool.toml"});
}

/// The same, told to stop: within two seconds on a machine that does nothing else, and here within ten.
TEST(Interrupt, ARefinementIsStopped) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 192;
    place.write("pool.toml", pool.text());
    Program program(place, {"bake", "pool.toml", "--tolerance", "1e-7", "--progress=json"});
    const auto start = std::chrono::steady_clock::now();
    while (program.errSoFar().find("\"stage\":\"light\"") == std::string::npos &&
           std::chrono::steady_clock::now() - start < std::chrono::seconds(20))
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(program.pid(), SIGTERM);
    const auto sent = std::chrono::steady_clock::now();
    EXPECT_EQ(program.wait().code, 130);
    EXPECT_LT(std::chrono::steady_clock::now() - sent, std::chrono::seconds(10));
}

TEST(Interrupt, SigintEndsABakeCleanly) { interruptedBy(SIGINT); }
TEST(Interrupt, SigtermToo) { interruptedBy(SIGTERM); }

}  // namespace
}  // namespace photic::test
