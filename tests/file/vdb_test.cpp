// SPDX-License-Identifier: Apache-2.0
// Writing and reading through our own interface: round trips, damage, full disks.
#include "bake/file/vdb.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <functional>
#include <random>

#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

std::string messageOf(ErrorCode code, const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), code) << e.what();
        return e.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

// Largest differences of irradiance (relative) and direction over all voxels of `a`.
void expectSameLight(const LightVolume& a, const LightVolume& b, double tolerance) {
    const GridFrame& f = a.field.frame();
    ASSERT_EQ(a.field.channels().irradiance, b.field.channels().irradiance);
    EXPECT_LT(glm::length(f.origin_world - b.field.frame().origin_world), 1e-12);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_LT(glm::length(f.worldFromIndex()[axis] - b.field.frame().worldFromIndex()[axis]), 1e-12);
    double irradiance = 0, direction = 0;
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z) {
                const glm::ivec3 v(x, y, z);
                const double e = a.field.irradiance(v);
                ASSERT_EQ(e > 0, b.field.irradiance(v) > 0) << x << ' ' << y << ' ' << z;
                if (e == 0) continue;
                for (int c = 0; c < a.field.channels().irradiance; ++c)
                    irradiance =
                        std::max(irradiance, std::fabs(double(b.field.value(v, c)) / double(a.field.value(v, c)) - 1));
                direction =
                    std::max(direction, glm::length(a.field.flux(v) / e - b.field.flux(v) / b.field.irradiance(v)));
            }
    EXPECT_LT(irradiance, tolerance);
    EXPECT_LT(direction, 2 * tolerance);
}

TEST(Vdb, RoundTripsOfAllKinds) {
    const TemporaryFolder folder;
    const auto odd = [](const glm::ivec3& v) { return (v.x + 3 * v.y + v.z) % 4 != 0 && v.x != 5; };
    for (const bool sheared : {false, true})
        for (const bool coloured : {false, true}) {
            const GridFrame frame = (sheared ? leaningFrame : straightFrame)({-9, 3, -20}, {14, 17, 3}, 1.0 / 64);
            const LightVolume volume = testVolume(frame, coloured, odd);
            std::int64_t lit = 0;
            for (int x = -9; x <= 14; ++x)
                for (int y = 3; y <= 17; ++y)
                    for (int z = -20; z <= 3; ++z) lit += odd({x, y, z});
            for (const auto compression : {Compression::None, Compression::Mask, Compression::Blosc, Compression::Zip})
                for (const bool half : {true, false}) {
                    const std::string path = folder / "light.vdb";
                    EXPECT_EQ(writeVdb(path, volume, {compression, half}), lit);
                    const LightVolume back = readVdb(path);
                    EXPECT_EQ(back.reference_irradiance, 1000);
                    EXPECT_EQ(back.field.needed().count(), lit);
                    expectSameLight(volume, back, half ? 5e-4 : 1e-6);
                    // The ledger's side of it: sums survive.
                    EXPECT_NEAR(back.field.sum(0) / volume.field.sum(0), 1, half ? 1e-4 : 1e-6);
                }
        }
    EXPECT_EQ(folder.fileCount(), 1u);
}

TEST(Vdb, DirectionsNeverExceedOneAfterRounding) {
    // Unit directions of all kinds: rounding to nearest would lengthen half of them.
    LightVolume volume = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(31), 0.1), false);
    for (int slot = 0; slot < volume.field.leafCount(); ++slot) {
        float* leaf = volume.field.dense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::dvec3 d =
                glm::normalize(glm::dvec3(std::sin(i * 0.7 + slot), std::cos(i * 1.3), -1.1 - std::sin(slot * 0.9)));
            for (int a = 0; a < 3; ++a) leaf[(1 + a) * 512 + i] = float(double(leaf[i]) * d[a]);
        }
    }
    const TemporaryFolder folder;
    for (const bool half : {true, false}) {
        writeVdb(folder / "a.vdb", volume, {Compression::Mask, half});
        const LightVolume back = readVdb(folder / "a.vdb");
        double longest = 0, shortest = 2;
        for (int x = 0; x < 32; ++x)
            for (int y = 0; y < 32; ++y)
                for (int z = 0; z < 32; ++z) {
                    const double length = glm::length(back.field.flux({x, y, z})) / back.field.irradiance({x, y, z});
                    longest = std::max(longest, length), shortest = std::min(shortest, length);
                }
        EXPECT_LE(longest, 1 + 2e-7);
        EXPECT_GT(shortest, half ? 0.9985 : 0.999999);
    }
}

TEST(Vdb, MetadataSurvivesWithItsTypes) {
    LightVolume volume = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(7), 0.25), false);
    volume.reference_irradiance = 1.0 / 3;
    volume.metadata = {{"method", "beams"},
                       {"options", "{\"levels\": 3}"},
                       {"paths", "caustic"},
                       {"quadrature", "2"},
                       {"prefilter", "true"},
                       {"ior", "1.333"},
                       {"frame", "17"},
                       {"ledger", "{\"power\": {\"emitted\": 12.5}}"},
                       {"scene_hash", "00ff12ab34cd56ef"},
                       {"up_axis", "Y"},
                       {"version", "99"}};
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", volume, {});
    const LightVolume back = readVdb(folder / "a.vdb");
    EXPECT_EQ(back.reference_irradiance, 1.0 / 3);
    auto expected = volume.metadata;
    expected["up_axis"] = "Z", expected["version"] = "1", expected["clamped"] = "0";  // the writer's, not the caller's
    for (const auto& [key, value] : expected) {
        ASSERT_TRUE(back.metadata.count(key)) << key;
        EXPECT_EQ(back.metadata.at(key), value) << key;
    }
}

TEST(Vdb, ScalarsShareTheTopologyAndDensityExtendsIt) {
    const GridFrame frame = straightFrame(glm::ivec3(-8), glm::ivec3(15), 0.1);
    LightVolume volume = testVolume(frame, false, [](const glm::ivec3& v) { return v.z < 3; });
    LightField density(volume.field.neededPtr(), {1, false}), caustic(volume.field.neededPtr(), {1, false});
    for (int slot = 0; slot < density.leafCount(); ++slot)
        if (density.needed().leafOrigin(slot).z < 8) {
            density.setConstant(slot, std::array<float, 1>{1});
            float* c = caustic.makeDense(slot);
            for (int i = 0; i < 512; ++i) c[i] = float(i);
        }
    volume.scalars.emplace("density", std::move(density));
    volume.scalars.emplace("caustic", std::move(caustic));
    const TemporaryFolder folder;
    EXPECT_EQ(writeVdb(folder / "a.vdb", volume, {}), 24 * 24 * 16);
    const LightVolume back = readVdb(folder / "a.vdb");
    ASSERT_EQ(back.scalars.size(), 2u);
    EXPECT_EQ(back.scalars.at("density").value({1, 2, 7}, 0), 1);
    EXPECT_EQ(back.scalars.at("density").value({1, 2, 8}, 0), 0);
    EXPECT_EQ(back.scalars.at("caustic").value({1, 2, 7}, 0), float(1 << 6 | 2 << 3 | 7));
    EXPECT_EQ(back.field.irradiance({1, 2, 7}), 0);
    EXPECT_GT(back.field.irradiance({1, 2, 2}), 0);
}

TEST(Vdb, DarkAndBlindingVolumes) {
    const TemporaryFolder folder;
    LightVolume dark =
        testVolume(straightFrame({3, 4, 5}, {30, 31, 32}, 0.1), false, [](const glm::ivec3&) { return false; });
    EXPECT_EQ(writeVdb(folder / "dark.vdb", dark, {}), 1);
    EXPECT_EQ(readVdb(folder / "dark.vdb").field.sum(0), 0);

    LightVolume bright = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(7), 0.1), false);
    float* leaf = bright.field.dense(0);
    leaf[0] = 7e7f, leaf[1] = std::numeric_limits<float>::infinity(), leaf[2] = std::numeric_limits<float>::quiet_NaN();
    for (const bool half : {true, false}) {
        writeVdb(folder / "bright.vdb", bright, {Compression::Mask, half});
        const LightVolume back = readVdb(folder / "bright.vdb");
        EXPECT_FLOAT_EQ(back.field.value({0, 0, 0}, 0), 65504e3f);
        EXPECT_FLOAT_EQ(back.field.value({0, 0, 1}, 0), 65504e3f);
        EXPECT_EQ(back.field.value({0, 0, 2}, 0), 0);
        EXPECT_EQ(back.metadata.at("clamped"), "3");
    }
}

TEST(Vdb, ThreadsChangeNoByte) {
    const TemporaryFolder folder;
    const LightVolume volume = testVolume(leaningFrame(glm::ivec3(-20), glm::ivec3(43), 0.02), true,
                                          [](const glm::ivec3& v) { return v.x % 19 != 0; });
    for (const int threads : {1, 2}) {
        setThreadCount(threads);
        writeVdb(folder / std::to_string(threads), volume, {});
    }
    setThreadCount(0);
    EXPECT_EQ(bytesOf(folder / "1"), bytesOf(folder / "2"));
    // And a change of one value changes more than it: the number that tells files apart.
    LightVolume other = testVolume(leaningFrame(glm::ivec3(-20), glm::ivec3(43), 0.02), true,
                                   [](const glm::ivec3& v) { return v.x % 19 != 0; });
    other.field.dense(other.field.needed().slotOf({0, 0, 0}))[100] *= 1.5f;
    writeVdb(folder / "3", other, {});
    EXPECT_NE(bytesOf(folder / "1").substr(0, 64), bytesOf(folder / "3").substr(0, 64));
}

TEST(Vdb, EveryTruncationIsRefused) {
    const TemporaryFolder folder;
    setThreadCount(1);  // waking a pool for every short file takes longer than reading it
    for (const auto compression : {Compression::None, Compression::Mask, Compression::Blosc, Compression::Zip}) {
        const LightVolume volume =
            testVolume(straightFrame({0, 0, 0}, {9, 7, 7}, 0.1), false, [](const glm::ivec3& v) { return v.x != 3; });
        writeVdb(folder / "whole.vdb", volume, {compression, true});
        const std::string whole = bytesOf(folder / "whole.vdb");
        ASSERT_GT(whole.size(), 2000u);
        // A sweep over all of it, and every length at the end, where only the last value is missing.
        const std::size_t step = whole.size() / 150;
        for (std::size_t length = 0; length < whole.size();
             length += length + 20 >= whole.size() ? 1 : std::min(step, whole.size() - 20 - length)) {
            writeBytes(folder / "cut.vdb", whole.substr(0, length));
            const std::string message = messageOf(ErrorCode::Input, [&] { readVdb(folder / "cut.vdb"); });
            ASSERT_NE(message.find("cut.vdb"), std::string::npos);
        }
    }
    setThreadCount(0);
}

TEST(Vdb, DamagedFilesAreRefusedOrRead) {
    const TemporaryFolder folder;
    setThreadCount(1);
    std::mt19937 random(99);
    int refused = 0, read = 0;
    for (const auto compression : {Compression::None, Compression::Mask, Compression::Blosc, Compression::Zip}) {
        const LightVolume volume =
            testVolume(straightFrame({0, 0, 0}, {9, 7, 7}, 0.1), false, [](const glm::ivec3& v) { return v.x != 3; });
        writeVdb(folder / "whole.vdb", volume, {compression, true});
        const std::string whole = bytesOf(folder / "whole.vdb");
        // Half of the changes go to what is not a run of zeros, where the sizes stand.
        std::vector<std::size_t> telling;
        for (std::size_t i = 0; i < whole.size(); ++i)
            if (whole[i] != 0) telling.push_back(i);
        for (int n = 0; n < 100; ++n) {
            std::string bytes = whole;
            for (unsigned changes = 1 + random() % 3; changes > 0; --changes) {
                const std::size_t at = random() % 2 ? telling[random() % telling.size()] : random() % bytes.size();
                constexpr unsigned char extreme[] = {0x00, 0x7f, 0x80, 0xff};
                bytes[at] = static_cast<char>(random() % 2 ? extreme[random() % 4] : random() & 255);
            }
            writeBytes(folder / "damaged.vdb", bytes);
            try {
                readVdb(folder / "damaged.vdb");
                ++read;
            } catch (const Error& e) {
                EXPECT_EQ(e.code(), ErrorCode::Input);
                EXPECT_NE(std::string(e.what()).find("damaged.vdb"), std::string::npos);
                ++refused;
            }
        }
    }
    setThreadCount(0);
    EXPECT_GT(refused, 40);
    EXPECT_GT(read, 40);
}

TEST(Vdb, WhatCannotBeReadSaysWhy) {
    const TemporaryFolder folder;
    EXPECT_NE(messageOf(ErrorCode::Input, [&] { readVdb(folder / "none.vdb"); }).find("No such file"),
              std::string::npos);
    EXPECT_NE(messageOf(ErrorCode::Input, [&] { readVdb(folder / ""); }).find("folder"), std::string::npos);
    writeBytes(folder / "text.vdb", "this is not a volume at all, but long enough to hold a header of one, if it were");
    EXPECT_NE(messageOf(ErrorCode::Input, [&] { readVdb(folder / "text.vdb"); }).find("no .vdb"), std::string::npos);
}

TEST(Vdb, WhatCannotBeWrittenLeavesEverythingAsItWas) {
    const TemporaryFolder folder;
    const LightVolume volume = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(15), 0.1), false);
    EXPECT_NE(
        messageOf(ErrorCode::Failed, [&] { writeVdb(folder / "no/such/folder.vdb", volume, {}); }).find("No such file"),
        std::string::npos);
    std::filesystem::create_directory(folder / "d.vdb");
    EXPECT_NE(messageOf(ErrorCode::Failed, [&] { writeVdb(folder / "d.vdb", volume, {}); }).find("directory"),
              std::string::npos);
    LightVolume nothing = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(7), 0.1), false);
    nothing.has_irradiance = nothing.has_direction = false;
    messageOf(ErrorCode::Failed, [&] { writeVdb(folder / "a.vdb", nothing, {}); });
    EXPECT_EQ(folder.fileCount(), 1u);
}

TEST(Vdb, AFullDiskLeavesTheOldFile) {
    const TemporaryFolder folder;
    const std::string path = folder / "light.vdb";
    const LightVolume small = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(7), 0.1), false);
    const LightVolume large = testVolume(straightFrame(glm::ivec3(0), glm::ivec3(63), 0.1), false);
    writeVdb(path, small, {});
    const std::string before = bytesOf(path);
    writeVdb(folder / "full.vdb", large, {});
    const auto full = std::filesystem::file_size(folder / "full.vdb");
    std::filesystem::remove(folder / "full.vdb");
    // A limit on the size of files stands in for the disk: in a process of its own, since it stays.
    for (const std::uintmax_t limit :
         {std::uintmax_t{0}, std::uintmax_t{1}, std::uintmax_t{5000}, full / 2, full - 1}) {
        const pid_t child = fork();
        if (child == 0) {
            setThreadCount(1);  // the pool's threads did not come along
            std::signal(SIGXFSZ, SIG_IGN);
            const rlimit size{limit, limit};
            setrlimit(RLIMIT_FSIZE, &size);
            int status = 1;
            try {
                writeVdb(path, large, {});
            } catch (const Error& e) {
                status = e.code() == ErrorCode::Failed && std::string(e.what()).find("too large") != std::string::npos
                             ? 0
                             : 2;
            } catch (...) {
                status = 3;
            }
            _exit(status);
        }
        int status = -1;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status << " at " << limit;
        EXPECT_EQ(bytesOf(path), before);
        EXPECT_EQ(folder.fileCount(), 1u);
    }
    writeVdb(path, large, {});
    EXPECT_EQ(bytesOf(path).size(), full);
}

TEST(VoxelEncoding, HalfPrecisionIsThatOfHalfFloats) {
    EXPECT_EQ(halfPrecision(1.0f + 1.0f / 2048), 1.0f);  // ties to even
    EXPECT_EQ(halfPrecision(1.0f + 3.0f / 2048), 1.0f + 2.0f / 1024);
    EXPECT_EQ(halfPrecision(-0.3333f), -0.333251953125f);
    EXPECT_EQ(halfPrecisionBelow(-0.3333f), -0.333251953125f);
    EXPECT_EQ(halfPrecisionBelow(1.9999f), 2.0f - 1.0f / 1024);
}

TEST(VoxelEncoding, LightTooFaintToDivideByHasNoDirection) {
    const float irradiance[4] = {1e-40f, 1e-38f, 2e-38f, 0.0f}, f[4] = {-1e-40f, -1e-38f, -2e-38f, 0.0f}, none[4] = {};
    float dx[4], dy[4], dz[4];
    encodeDirections(irradiance, none, none, f, 4, false, dx, dy, dz);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(dx[i], 0);
    EXPECT_EQ(dz[0], 0);
    EXPECT_EQ(dz[1], 0);
    EXPECT_EQ(dz[2], -1);
    EXPECT_EQ(dz[3], 0);
}

}  // namespace
}  // namespace photic
