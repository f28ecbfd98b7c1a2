// SPDX-License-Identifier: Apache-2.0
// What photic export writes, as the run-time library reads it.
#include <gtest/gtest.h>

#include "bake/field/resample.h"
#include "bake/field/two_levels.h"
#include "bake/file/nvdb.h"
#include "bake/file/runtime_size.h"
#include "photic/runtime.h"
#include "photic/volume_bytes.h"
#include "runtime/src/brick_plan.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

TEST(NvdbRuntime, SamplesWhatWasWritten) {
    for (const bool sheared : {false, true}) {
        for (const bool coloured : {false, true}) {
            for (const auto precision : {NvdbPrecision::Half, NvdbPrecision::Float}) {
                const TemporaryFolder folder;
                const glm::ivec3 min(-9, 3, -20), max(14, 17, 3);
                LightVolume volume =
                    testVolume(sheared ? leaningFrame(min, max, 1.0 / 64) : straightFrame(min, max, 1.0 / 64), coloured,
                               [](const glm::ivec3& v) { return v.y != 7; });
                volume.metadata = {{"ior", "1.333"},
                                   {"frame", "7"},
                                   {"paths", "all"},
                                   {"absorption", "0.5"},
                                   {"scattering", "[0.1,0.2,0.3]"},
                                   {"anisotropy", "0.8"}};
                const NvdbWritten written = writeNvdb(folder / "a.nvdb", volume, {precision, NvdbCodec::None});
                const auto loaded = runtime::loadVolume(folder / "a.nvdb");
                ASSERT_TRUE(loaded) << loaded.error().message;
                const runtime::Volume& read = *loaded;
                EXPECT_EQ(read.coloured(), coloured);
                EXPECT_EQ(static_cast<std::int64_t>(read.litVoxelCount()), written.active_voxels);
                EXPECT_EQ(read.metadata().ior, 1.333);
                EXPECT_EQ(read.metadata().frame, 7);
                EXPECT_EQ(read.metadata().paths, "all");
                EXPECT_EQ(read.metadata().scattering.z, 0.3);
                EXPECT_EQ(read.metadata().absorption.y, 0.5);
                EXPECT_EQ(read.metadata().anisotropy, 0.8);
                // The budget counts what the library takes.
                const runtime::BrickPlan plan = runtime::planBricks(read.data());
                const RuntimeSize size = runtimeSize(volume);
                EXPECT_EQ(size.bricks, static_cast<std::int64_t>(plan.bricks.size()));
                EXPECT_EQ(size.pages, static_cast<std::int64_t>(plan.entries.size()));
                EXPECT_EQ(size.dense, plan.fill() > 0.7);
                // Between voxels, near borders and gaps too. Halves lose 2^-11 of values below 1700 W/m2.
                const GridFrame& frame = volume.field.frame();
                for (int i = 0; i < 2000; ++i) {
                    const glm::dvec3 index(-10 + 26 * std::fmod(i * 0.754877, 1), 2 + 17 * std::fmod(i * 0.569840, 1),
                                           -21 + 25 * std::fmod(i * 0.438579, 1));
                    const glm::dvec3 p = frame.worldFromIndex(index);
                    const auto expected = sampleTrilinear(volume.field, index);
                    const runtime::Light light = read.sample({p.x, p.y, p.z});
                    const std::size_t flux = coloured ? 3 : 1;
                    constexpr double kTolerance = 1.7;
                    ASSERT_NEAR(light.irradiance.x, double(expected[0]), kTolerance);
                    ASSERT_NEAR(light.irradiance.z, double(expected[coloured ? 2 : 0]), kTolerance);
                    ASSERT_NEAR(light.flux.x, double(expected[flux]), kTolerance);
                    ASSERT_NEAR(light.flux.y, double(expected[flux + 1]), kTolerance);
                    ASSERT_NEAR(light.flux.z, double(expected[flux + 2]), kTolerance);
                }
            }
        }
    }
}

// Two levels: the library takes as many bricks as the budget counted, of either kind, and reads the same light.
TEST(NvdbRuntime, TwoLevelsAreWhatTheBudgetCounts) {
    const TemporaryFolder folder;
    const LightVolume whole = testVolume(straightFrame({-20, -9, 3}, {50, 40, 44}, 1.0 / 64), false,
                                         [](const glm::ivec3& v) { return v.x + v.y > 0; });
    const TwoLevels levels(whole.field, nullptr, Monitor());
    TwoLevels::Made made = levels.with(levels.blockCount() / 2);
    LightVolume volume{std::move(made.field), whole.reference_irradiance, true, true, {}, whole.metadata};
    volume.metadata["coarse_blocks"] = made.blocks.text();
    writeNvdb(folder / "two.nvdb", volume, {NvdbPrecision::Half, NvdbCodec::Blosc});
    const auto loaded = runtime::loadVolume(folder / "two.nvdb");
    ASSERT_TRUE(loaded) << loaded.error().message;
    const runtime::BrickPlan plan = runtime::planBricks(loaded->data());
    const RuntimeSize size = runtimeSize(volume);
    EXPECT_GT(size.coarse, 5);
    EXPECT_EQ(size.coarse, static_cast<std::int64_t>(plan.coarse));
    EXPECT_EQ(size.bricks, static_cast<std::int64_t>(plan.bricks.size()));
    EXPECT_EQ(size.pages, static_cast<std::int64_t>(plan.entries.size()));
    EXPECT_FALSE(size.dense);
    const auto packed = runtime::packVolume(*loaded);
    ASSERT_TRUE(packed) << packed.error().message;
    EXPECT_EQ(size.bytes, static_cast<std::int64_t>(packed->info.bytes));
}

// Light that repeats has two levels too: along x a period of whole blocks, along y one that ends within a block.
TEST(NvdbRuntime, TwoLevelsOfLightThatRepeats) {
    const TemporaryFolder folder;
    const glm::ivec3 min(-16, 0, 3), max(47, 39, 44);
    LightVolume whole = testVolume(straightFrame(min, max, 1.0 / 64), false, [](const glm::ivec3&) { return true; });
    whole.metadata["period"] = "[1,0.625,0]";
    EXPECT_EQ(periodVoxels(whole), glm::ivec3(64, 40, 0));
    const RepeatingVoxels repeats{min, {64, 40, 0}};
    const TwoLevels levels(whole.field, nullptr, Monitor(), repeats);
    for (const int part : {1, 2}) {
        TwoLevels::Made made = levels.with(levels.blockCount() / part);
        LightVolume volume{std::move(made.field), whole.reference_irradiance, true, true, {}, whole.metadata};
        volume.metadata["coarse_blocks"] = made.blocks.text();
        writeNvdb(folder / "two.nvdb", volume, {NvdbPrecision::Half, NvdbCodec::Blosc});
        const auto loaded = runtime::loadVolume(folder / "two.nvdb");
        ASSERT_TRUE(loaded) << loaded.error().message;
        const runtime::BrickPlan plan = runtime::planBricks(loaded->data());
        const RuntimeSize size = runtimeSize(volume);
        EXPECT_EQ(size.coarse, made.blocks.count());
        EXPECT_EQ(size.coarse, static_cast<std::int64_t>(plan.coarse));
        EXPECT_EQ(size.pages, static_cast<std::int64_t>(plan.entries.size()));
        EXPECT_EQ(size.bricks, static_cast<std::int64_t>(plan.bricks.size()));
        // No block reaches over the end of a period within it.
        for (int x = -1; x < 3; ++x)
            for (int z = 0; z < 3; ++z) EXPECT_FALSE(made.blocks.has({x, 2, z}));
        // All voxels of a block and of its far sides are the look-up of every second one, around the period's end too.
        int looked_at = 0;
        for (int n = 0; n < 64 * 33 * 42; ++n) {
            const glm::ivec3 v(min.x + n % 64, n / 64 % 33, 3 + n / (64 * 33));
            bool wide = false;
            for (int s = 0; s < 8; ++s) {
                glm::ivec3 b(v.x >> 4, v.y >> 4, v.z >> 4);
                bool shares = true;
                for (int a = 0; a < 3; ++a)
                    if (s >> a & 1) --b[a], shares = shares && (v[a] & 15) == 0;
                if (b.x < -1) b.x += 4;
                wide = wide || (shares && made.blocks.has(b));
            }
            if (!wide) continue;
            double mean = 0;
            for (int corner = 0; corner < 8; ++corner) {
                glm::ivec3 at = v;
                for (int a = 0; a < 3; ++a) at[a] += (v[a] & 1) == 0 ? 0 : corner >> a & 1 ? 1 : -1;
                mean += double(volume.field.value(repeats.wrapped(at), 0)) / 8;
            }
            ASSERT_NEAR(volume.field.value(v, 0), mean, 1e-3 * mean + 1e-3) << v.x << " " << v.y << " " << v.z;
            ++looked_at;
        }
        EXPECT_GT(looked_at, 20000);
        // What a game reads, across the ends.
        const auto packed = runtime::packVolume(*loaded);
        ASSERT_TRUE(packed) << packed.error().message;
        EXPECT_EQ(packed->info.coarse_bricks, static_cast<std::uint32_t>(made.blocks.count()));
        for (int i = 0; i < 1000; ++i) {
            const glm::dvec3 index(-18 + 68 * std::fmod(i * 0.754877, 1), -3 + 46 * std::fmod(i * 0.569840, 1),
                                   4 + 39 * std::fmod(i * 0.438579, 1));
            const glm::dvec3 p = volume.field.frame().worldFromIndex(index);
            const glm::ivec3 low(glm::floor(index));
            double expected = 0;
            for (int corner = 0; corner < 8; ++corner) {
                double weight = 1;
                glm::ivec3 at = low;
                for (int a = 0; a < 3; ++a) {
                    const bool far = corner >> a & 1;
                    at[a] += far, weight *= far ? index[a] - low[a] : 1 - index[a] + low[a];
                }
                expected += weight * double(volume.field.value(repeats.wrapped(at), 0));
            }
            ASSERT_NEAR(loaded->sample({p.x, p.y, p.z}).irradiance.x, expected, 2.5) << i;
        }
    }
}

// Of two lobes the same blocks are coarse, each with bricks of its own.
TEST(NvdbRuntime, TwoLevelsOfTwoLobes) {
    const TemporaryFolder folder;
    LightVolume whole = testVolume(straightFrame({-20, -9, 3}, {50, 40, 44}, 1.0 / 64), false,
                                   [](const glm::ivec3& v) { return v.x + v.y > 0; });
    LightField second(whole.field.neededPtr(), whole.field.channels());
    for (int slot = 0; slot < second.leafCount(); ++slot) {
        if (whole.field.state(slot) == LeafState::Empty || whole.field.needed().leafOrigin(slot).z < 16) continue;
        float* to = second.makeDense(slot);
        for (int i = 0; i < 512; ++i) to[i] = 0.2F * whole.field.dense(slot)[i], to[3 * 512 + i] = 0.9F * to[i];
    }
    const TwoLevels levels(whole.field, &second, Monitor());
    TwoLevels::Made made = levels.with(levels.blockCount() / 2);
    ASSERT_TRUE(made.second);
    LightVolume volume{std::move(made.field), whole.reference_irradiance, true, true, {}, whole.metadata};
    volume.second = std::move(made.second);
    volume.metadata["coarse_blocks"] = made.blocks.text();
    volume.metadata["lobe_axis"] = "[0,0,-1]";
    writeNvdb(folder / "two.nvdb", volume, {NvdbPrecision::Half, NvdbCodec::Blosc});
    const auto loaded = runtime::loadVolume(folder / "two.nvdb");
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_TRUE(loaded->hasSecondLobe());
    const runtime::BrickPlan first = runtime::planBricks(loaded->data()),
                             other = runtime::planBricks(loaded->secondLobe().data());
    const RuntimeSize size = runtimeSize(volume);
    EXPECT_GT(other.coarse, 2U);
    EXPECT_EQ(size.coarse, static_cast<std::int64_t>(first.coarse + other.coarse));
    EXPECT_EQ(size.bricks, static_cast<std::int64_t>(first.bricks.size() + other.bricks.size()));
    // What a game reads is what is in the fields, at all voxels of either lobe.
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 index(-19 + 68 * std::fmod(i * 0.754877, 1), -8 + 47 * std::fmod(i * 0.569840, 1),
                               4 + 39 * std::fmod(i * 0.438579, 1));
        const glm::dvec3 p = volume.field.frame().worldFromIndex(index);
        const double expected =
            double(sampleTrilinear(volume.field, index)[0]) + double(sampleTrilinear(*volume.second, index)[0]);
        ASSERT_NEAR(loaded->sample({p.x, p.y, p.z}).irradiance.x, expected, 2.5);
    }
}

TEST(NvdbRuntime, PackedFilesAreAboutAsLargeAsTheirBricksAndHoldTheSame) {
    // A whole box; a floor's band across eight of the tree's blocks; both in colour.
    const glm::ivec3 min(-40, -40, -20), max(39, 39, 19);
    for (const bool band : {false, true}) {
        for (const bool coloured : {false, true}) {
            const TemporaryFolder folder;
            const LightVolume volume =
                testVolume(straightFrame(min, max, 1.0 / 64), coloured,
                           [&](const glm::ivec3& v) { return !band || (v.z >= -2 && v.z <= 1); });
            writeNvdb(folder / "plain.nvdb", volume, {NvdbPrecision::Half, NvdbCodec::None});
            writeNvdb(folder / "packed.nvdb", volume, {NvdbPrecision::Half, NvdbCodec::Blosc});
            const auto bytes = static_cast<double>(std::filesystem::file_size(folder / "packed.nvdb"));
            EXPECT_LE(bytes, 1.3 * static_cast<double>(runtimeSize(volume).bytes)) << band << coloured;
            const auto plain = runtime::loadVolume(folder / "plain.nvdb"),
                       packed = runtime::loadVolume(folder / "packed.nvdb");
            ASSERT_TRUE(plain) << plain.error().message;
            ASSERT_TRUE(packed) << packed.error().message;
            ASSERT_EQ(plain->litVoxelCount(), packed->litVoxelCount());
            for (int i = 0; i < 500; ++i) {
                const glm::dvec3 index(-41 + 82 * std::fmod(i * 0.754877, 1), -41 + 82 * std::fmod(i * 0.569840, 1),
                                       -21 + 42 * std::fmod(i * 0.438579, 1));
                const glm::dvec3 p = volume.field.frame().worldFromIndex(index);
                const runtime::Light a = plain->sample({p.x, p.y, p.z}), b = packed->sample({p.x, p.y, p.z});
                ASSERT_EQ(a.irradiance.x, b.irradiance.x);
                ASSERT_EQ(a.flux.z, b.flux.z);
            }
        }
    }
}

}  // namespace
}  // namespace photic
