// SPDX-License-Identifier: Apache-2.0
#include "bake/field/light_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "bake/field/leaf_arena.h"
#include "bake/field/needed_voxels.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

std::shared_ptr<const NeededVoxels> everything(const glm::ivec3& min, const glm::ivec3& max) {
    GridFrame frame;
    frame.min = min, frame.max = max;
    return std::make_shared<NeededVoxels>(NeededVoxels::everything(frame));
}

TEST(LightField, StatesKeepTheirValues) {
    LightField field(everything({0, 0, 0}, {15, 7, 7}), {3, true});
    EXPECT_EQ(field.channels().count(), 6);
    EXPECT_EQ(field.state(0), LeafState::Empty);
    EXPECT_EQ(field.value({1, 2, 3}, 0), 0);

    const std::array<float, 6> light{3, 6, 9, 1, 2, -4};
    field.setConstant(0, light);
    EXPECT_EQ(field.state(0), LeafState::Constant);
    EXPECT_EQ(field.irradiance({7, 7, 7}), 6);
    EXPECT_EQ(field.flux({7, 7, 7}), glm::dvec3(1, 2, -4));
    EXPECT_EQ(field.irradiance({8, 7, 7}), 0);

    float* leaf = field.makeDense(0);
    EXPECT_EQ(leaf, field.dense(0));
    for (int c = 0; c < 6; ++c)
        for (int i = 0; i < 512; ++i) ASSERT_EQ(leaf[c * 512 + i], light[static_cast<std::size_t>(c)]);
    leaf[4 * 512 + NeededVoxels::offsetInLeaf({1, 2, 3})] = 11;
    EXPECT_EQ(field.flux({1, 2, 3}), glm::dvec3(1, 11, -4));

    bool was_empty = true;
    EXPECT_EQ(field.makeDenseUninitialised(0, was_empty), leaf);
    EXPECT_FALSE(was_empty);
    field.setEmpty(0);
    EXPECT_EQ(field.value({1, 2, 3}, 4), 0);

    // Memory of a leaf that was given back is not clean: makeDense must clear it.
    float* again = field.makeDense(1);
    EXPECT_EQ(again, leaf);
    EXPECT_TRUE(std::all_of(again, again + 6 * 512, [](float v) { return v == 0; }));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(again) % 64, 0u);
}

TEST(LightField, MemoryFollowsLight) {
    LightField field(everything(glm::ivec3(0), glm::ivec3(1023)), {1, true});
    EXPECT_LT(field.bytes(), 9 * field.leafCount() + 4096);
    const auto before = field.bytes();
    for (int slot = 0; slot < 100; ++slot) field.makeDense(slot * 7);
    EXPECT_EQ(field.bytes() - before, 100 * 4 * 512 * 4);
}

TEST(LightField, SumCountsNeededVoxelsOnly) {
    LightField field(everything({1, 2, 3}, {20, 9, 12}), {1, true});
    double expected = 0;
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (slot == 1) {
            field.setConstant(slot, std::array<float, 4>{2.5f, 0, 0, 0});
        } else if (slot != 2) {
            float* leaf = field.makeDense(slot);
            for (int i = 0; i < 512; ++i) leaf[i] = 0.25f + float(i % 17) + float(slot);
        }
        const glm::ivec3 o = field.needed().leafOrigin(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = o + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const bool inside = v.x >= 1 && v.x <= 20 && v.y >= 2 && v.y <= 9 && v.z >= 3 && v.z <= 12;
            if (inside)
                expected += double(field.value(v, 0));
            else
                EXPECT_EQ(field.value(v, 0), 0);
        }
    }
    EXPECT_NEAR(field.sum(0), expected, 1e-9 * expected);
    EXPECT_EQ(field.sum(1), 0);
}

TEST(LightField, LeavesFillFromManyThreadsAndSumsDoNotDependOnThem) {
    const auto needed = everything(glm::ivec3(0), glm::ivec3(127));
    double first = 0;
    for (const int threads : {1, 2, 4}) {
        setThreadCount(threads);
        LightField field(needed, {1, true});
        std::atomic<int> visits{0};
        forEachLeaf(*needed, [&](int slot) {
            bool was_empty = false;
            float* leaf = field.makeDenseUninitialised(slot, was_empty);
            EXPECT_TRUE(was_empty);
            for (int i = 0; i < 4 * 512; ++i) leaf[i] = 1.0f / float(1 + slot * 2048 + i);
            ++visits;
        });
        EXPECT_EQ(visits, field.leafCount());
        for (int slot = 0; slot < field.leafCount(); ++slot)
            ASSERT_EQ(field.dense(slot)[3], 1.0f / float(4 + slot * 2048));
        const double sum = field.sum(0);
        if (threads == 1) first = sum;
        EXPECT_EQ(sum, first) << threads << " threads";
    }
    setThreadCount(0);
}

TEST(LeafArena, RunningOutOfMemoryIsAnErrorWithFigures) {
    LeafArena arena(std::size_t{1} << 46, 1);  // more than an address space
    bool zeroed = false;
    try {
        arena.allocate(zeroed);
        arena.allocate(zeroed);
        arena.allocate(zeroed);
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::Failed);
        EXPECT_NE(std::string(e.what()).find("MiB"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace photic
