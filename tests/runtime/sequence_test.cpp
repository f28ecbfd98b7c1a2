// SPDX-License-Identifier: Apache-2.0
// Frames are loaded ahead, shown at their time, looped and blended.
#include "photic/sequence.h"

#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "photic/volume_load.h"
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
    // Far ahead: the nearest that is loaded, until it is there itself.
    const auto jumped = sequence.at(1.0);
    ASSERT_TRUE(jumped.ok());
    EXPECT_GE(light(*jumped), jumped->late ? 2 - 1e-9 : 3 - 1e-9);
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

TEST_F(Sequences, NeighboursStandInForFramesThatDoNotLoad) {
    for (const bool missing : {true, false}) {
        if (missing) {
            std::filesystem::remove(paths_[2]);
        } else {
            std::ofstream(paths_[2], std::ios::binary) << "NanoVDB0, but cut short";
        }
        VolumeSequence sequence = open();
        EXPECT_NEAR(valueAt(sequence, 0, light), 1, 1e-9);
        // Frames 1 and 3 are 2 and 4: frame 2 lies in the middle of them.
        for (const auto& [seconds, expected] : {std::pair{0.75, 2.5}, {1.0, 3.0}, {1.25, 3.5}}) {
            const auto moment = sequence.at(seconds, WhenLate::Wait);
            ASSERT_TRUE(moment.ok());
            EXPECT_NEAR(light(*moment), expected, 1e-9) << seconds;
            ASSERT_TRUE(moment->failure.has_value()) << seconds;
            EXPECT_NE(moment->failure->message.find(paths_[2]), std::string::npos);
        }
        const auto whole = sequence.at(0.25, WhenLate::Wait);
        ASSERT_TRUE(whole.ok());
        EXPECT_NEAR(light(*whole), 1.5, 1e-9);
        EXPECT_FALSE(whole->failure.has_value());
    }
}

TEST_F(Sequences, HeldEndsStandInToo) {
    options_.end = SequenceEnd::Hold;
    std::filesystem::remove(paths_[0]);
    std::filesystem::remove(paths_[3]);
    VolumeSequence sequence = open();
    for (const auto& [seconds, expected] : {std::pair{0.0, 2.0}, {0.4, 2.0}, {0.75, 2.5}, {1.25, 3.0}, {9.0, 3.0}})
        EXPECT_NEAR(valueAt(sequence, seconds, light), expected, 1e-9) << seconds;
}

TEST_F(Sequences, OnlyWhenNoFrameLoadsItIsAnError) {
    for (std::size_t n = 0; n < 3; ++n) std::filesystem::remove(paths_[n]);
    {
        VolumeSequence sequence = open();
        for (const double seconds : {0.0, 0.6, 1.1, 1.7}) EXPECT_NEAR(valueAt(sequence, seconds, light), 4, 1e-9);
    }
    std::filesystem::remove(paths_[3]);
    VolumeSequence sequence = open();
    const auto nothing = sequence.at(0.2, WhenLate::Wait);
    ASSERT_FALSE(nothing.ok());
    EXPECT_NE(nothing.error().message.find(paths_[0]), std::string::npos);
    EXPECT_FALSE(VolumeSequence::open({}).ok());
    options_.frames_per_second = 0;
    EXPECT_FALSE(VolumeSequence::open(paths_, options_).ok());
}

// Loading that takes longer than frames last: files that give their bytes only when the test says so.
TEST_F(Sequences, ShowsTheNearestFrameWhereLoadingIsSlow) {
    std::string contents[2];
    for (const std::size_t n : {1, 2}) {
        std::ifstream in(paths_[n], std::ios::binary);
        contents[n - 1].assign(std::istreambuf_iterator<char>(in), {});
        std::filesystem::remove(paths_[n]);
        ASSERT_EQ(::mkfifo(paths_[n].c_str(), 0600), 0);
    }
    const auto feed = [&](std::size_t n) {
        std::ofstream(paths_[n], std::ios::binary)
            .write(contents[n - 1].data(), static_cast<std::streamsize>(contents[n - 1].size()));
    };
    VolumeSequence sequence = open();
    const auto shownUntil = [&](double seconds, double expected, bool late) {
        for (int i = 0; i < 4000; ++i) {
            const auto moment = sequence.at(seconds);
            if (moment && moment->late == late && std::fabs(light(*moment) - expected) < 1e-9) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return false;
    };
    // Frame 0 is there, frame 1 is still being loaded: frame 0 is shown, at all times.
    EXPECT_TRUE(shownUntil(0, 1, true));
    for (const double seconds : {0.3, 0.6, 1.0, 1.4}) EXPECT_TRUE(shownUntil(seconds, 1, true)) << seconds;
    // Meanwhile it is time for frame 2: frame 1 has come and is nearer.
    (void)sequence.at(1.0);
    feed(1);
    EXPECT_TRUE(shownUntil(1.0, 2, true));
    feed(2);
    EXPECT_TRUE(shownUntil(1.0, 3, false));
}

TEST_F(Sequences, OneVolumeLoadsBesideTheGame) {
    auto load = VolumeLoad::start(paths_[2]);
    ASSERT_TRUE(load.ok());
    for (int i = 0; i < 4000 && !load->done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_TRUE(load->done());
    for (int again = 0; again < 2; ++again) {
        const auto volume = load->take();
        ASSERT_TRUE(volume.ok());
        EXPECT_NEAR(volume->sample({8, 8, 8}).irradiance.x, 3, 1e-9);
    }
    auto missing = VolumeLoad::start(paths_[2] + ".none");
    ASSERT_TRUE(missing.ok());
    EXPECT_EQ(missing->take().error().code, ErrorCode::File);
    // Left before it is done: waits, and nothing else.
    for (int i = 0; i < 10; ++i) (void)VolumeLoad::start(paths_[1]);
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

// Texels go a few at a time, those of the next frame while the ones before are shown.
TEST_F(Sequences, GpuFramesComeInParts) {
    constexpr std::uint64_t kBytes = 3000;  // of some twenty thousand
    options_.frames_per_second = 1;
    GpuSequence sequence(*gpu_, open(), {}, kBytes);
    const auto valueNow = [&](double seconds) {
        const auto lit = sequence.at(seconds);
        EXPECT_TRUE(lit.ok());
        double sum = 0;
        for (const LitVolume& v : *lit)
            sum += static_cast<double>(v.weight) * static_cast<double>(sample(*v.volume, {{8, 8, 8, 0}})[0][3]);
        return sum;
    };
    int calls = 0;
    double value = 0;
    const auto waitFor = [&](double seconds, double expected) {
        for (calls = 0; calls < 4000; ++calls) {
            value = valueNow(seconds);
            if (std::fabs(value - expected) < 1e-5) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return false;
    };
    // No single call sends a frame; nothing is shown until one is whole.
    EXPECT_EQ(valueNow(0), 0);
    EXPECT_TRUE(waitFor(0, 1));
    EXPECT_GT(calls, 2);
    // Given time, the frame after the next is there before it is shown.
    EXPECT_TRUE(waitFor(0.5, 1.5));
    for (int i = 0; i < 500; ++i) {
        EXPECT_NEAR(valueNow(0.5), 1.5, 1e-5);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_NEAR(valueNow(1.5), 2.5, 1e-5);
    // A jump: what was shown stays until the frames of then have come.
    const double jumped = valueNow(3.0);
    EXPECT_GE(jumped, 2 - 1e-5);
    EXPECT_TRUE(waitFor(3.0, 4));
}

}  // namespace
}  // namespace photic::runtime
