// SPDX-License-Identifier: Apache-2.0
// Frames are loaded ahead, shown at their time, looped and blended.
#include "photic/sequence.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/runtime/gpu_fixture.h"

namespace photic::runtime {
namespace {

/// Frame n is light of n + 1 everywhere, straight down.
class Sequences : public test::WithGpu {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("photic_sequence_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        for (int n = 0; n < 4; ++n) {
            test::NvdbSpec spec;
            const auto e = static_cast<float>(n + 1);
            spec.values = [e](int, int, int) { return test::LightValues{0, 0, -e, e}; };
            const auto bytes = test::makeNvdb(spec);
            paths_.push_back((folder_ / ("frame_" + std::to_string(n) + ".nvdb")).string());
            std::ofstream(paths_.back(), std::ios::binary)
                .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        }
        options_.frames_per_second = 2;
        test::WithGpu::SetUp();
    }
    void TearDown() override {
        std::filesystem::remove_all(folder_);
        test::WithGpu::TearDown();
    }

    VolumeSequence open() {
        auto sequence = VolumeSequence::open(paths_, options_);
        EXPECT_TRUE(sequence.ok());
        return std::move(*sequence);
    }
    static double light(const Moment& m) {
        const Vec3 p = {8, 8, 8};
        return (1 - m.weight) * m.volumes[0].sample(p).irradiance.x + m.weight * m.volumes[1].sample(p).irradiance.x;
    }

    std::filesystem::path folder_;
    std::vector<std::string> paths_;
    SequenceOptions options_;
};

double valueAt(VolumeSequence& sequence, double seconds, double (*light)(const Moment&)) {
    const auto moment = sequence.at(seconds, WhenLate::Wait);
    EXPECT_TRUE(moment.ok());
    return moment ? light(*moment) : -1;
}

TEST_F(Sequences, LoopBlendsTheLastIntoTheFirst) {
    VolumeSequence sequence = open();
    EXPECT_EQ(sequence.frameCount(), 4);
    // Two frames a second: 1, 2, 3, 4 at 0, 0.5, 1, 1.5 s, then 1 again.
    for (const auto& [seconds, expected] : {std::pair{0.0, 1.0},
                                            {0.25, 1.5},
                                            {1.5, 4.0},
                                            {1.75, 2.5},
                                            {2.0, 1.0},
                                            {200.125, 1.25},
                                            {-0.25, 2.5},
                                            {-2.0, 1.0}}) {
        EXPECT_NEAR(valueAt(sequence, seconds, light), expected, 1e-9) << seconds;
    }
}

TEST_F(Sequences, HoldStaysAtItsEnds) {
    options_.end = SequenceEnd::Hold;
    VolumeSequence sequence = open();
    for (const auto& [seconds, expected] : {std::pair{-3.0, 1.0}, {0.25, 1.5}, {1.5, 4.0}, {77.0, 4.0}}) {
        EXPECT_NEAR(valueAt(sequence, seconds, light), expected, 1e-9) << seconds;
    }
}

TEST_F(Sequences, NeverWaitsUnlessAsked) {
    VolumeSequence sequence = open();
    const auto first = sequence.at(0);
    ASSERT_TRUE(first.ok());
    EXPECT_TRUE(first->late);  // the thread has only just been asked
    ASSERT_NEAR(valueAt(sequence, 0, light), 1, 1e-9);
    // Far ahead, nothing of it loaded: what was shown last, until it is there.
    const auto jumped = sequence.at(1.0);
    ASSERT_TRUE(jumped.ok());
    EXPECT_NEAR(light(*jumped), jumped->late ? 1 : 3, 1e-9);
    double value = 0;
    for (int i = 0; i < 2000 && value != 3; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        const auto moment = sequence.at(1.0);
        ASSERT_TRUE(moment.ok());
        if (!moment->late) value = light(*moment);
    }
    EXPECT_NEAR(value, 3, 1e-9);
}

TEST_F(Sequences, NextFramesAreLoadedAhead) {
    options_.ahead = 2;
    VolumeSequence sequence = open();
    ASSERT_NEAR(valueAt(sequence, 0, light), 1, 1e-9);
    // Frames 2 and 3 come without being asked for; a second is long for files of half a megabyte.
    std::this_thread::sleep_for(std::chrono::seconds(1));
    std::filesystem::remove(paths_[2]);
    std::filesystem::remove(paths_[3]);
    // They are shown though their files are gone.
    EXPECT_NEAR(valueAt(sequence, 1.25, light), 3.5, 1e-9);
}

TEST_F(Sequences, FramesThatDoNotLoadAreErrors) {
    std::filesystem::remove(paths_[2]);
    VolumeSequence sequence = open();
    EXPECT_NEAR(valueAt(sequence, 0, light), 1, 1e-9);
    const auto missing = sequence.at(1.0, WhenLate::Wait);
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find(paths_[2]), std::string::npos);
    EXPECT_NEAR(valueAt(sequence, 0.25, light), 1.5, 1e-9);
    EXPECT_FALSE(VolumeSequence::open({}).ok());
    options_.frames_per_second = 0;
    EXPECT_FALSE(VolumeSequence::open(paths_, options_).ok());
}

TEST_F(Sequences, StopsWhileLoading) {
    for (int i = 0; i < 20; ++i) {
        VolumeSequence sequence = open();
        (void)sequence.at(0.1 * i);
    }
}

TEST_F(Sequences, GpuShowsTheSame) {
    GpuSequence sequence(*gpu_, open());
    for (const auto& [seconds, expected] : {std::pair{0.0, 1.0}, {0.25, 1.5}, {1.75, 2.5}, {0.9, 2.8}}) {
        auto lit = sequence.at(seconds, WhenLate::Wait);
        ASSERT_TRUE(lit.ok()) << lit.error().message;
        double sum = 0, weights = 0;
        for (const LitVolume& v : *lit) {
            sum += static_cast<double>(v.weight) * static_cast<double>(sample(*v.volume, {{8, 8, 8, 0}})[0][3]);
            weights += static_cast<double>(v.weight);
        }
        EXPECT_NEAR(sum, expected, 1e-5) << seconds;
        EXPECT_NEAR(weights, 1, 1e-6);
    }
}

}  // namespace
}  // namespace photic::runtime
