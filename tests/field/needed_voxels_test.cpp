// SPDX-License-Identifier: Apache-2.0
#include "bake/field/needed_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

#include "bake/report/error.h"

namespace photic {
namespace {

GridFrame boxFrame(const glm::ivec3& min, const glm::ivec3& max) {
    GridFrame frame;
    frame.min = min, frame.max = max;
    return frame;
}

std::int64_t bitsIn(const NeededVoxels& needed) {
    std::int64_t bits = 0;
    for (int slot = 0; slot < needed.leafCount(); ++slot)
        for (int i = 0; i < 512; ++i) bits += NeededVoxels::maskBit(needed.mask(slot), i);
    return bits;
}

// Every voxel of the frame and of a margin around it, against a predicate.
template <class Predicate>
void expectContents(const NeededVoxels& needed, Predicate expected) {
    const GridFrame& f = needed.frame();
    std::int64_t count = 0;
    for (int x = f.min.x - 9; x <= f.max.x + 9; ++x)
        for (int y = f.min.y - 9; y <= f.max.y + 9; ++y)
            for (int z = f.min.z - 9; z <= f.max.z + 9; ++z) {
                const bool e = expected(glm::ivec3(x, y, z));
                count += e;
                ASSERT_EQ(needed.contains({x, y, z}), e) << x << ' ' << y << ' ' << z;
            }
    EXPECT_EQ(needed.count(), count);
    EXPECT_EQ(bitsIn(needed), count);
}

TEST(NeededVoxels, EverythingClipsBorderLeavesThatAreNotAligned) {
    for (const auto& [min, max] : {std::pair{glm::ivec3(0), glm::ivec3(15)},
                                   {glm::ivec3(-3, 5, -17), glm::ivec3(12, 6, 9)},
                                   {glm::ivec3(1, 2, 3), glm::ivec3(4, 5, 6)},
                                   {glm::ivec3(7, 0, 8), glm::ivec3(8, 7, 23)}}) {
        const auto needed = NeededVoxels::everything(boxFrame(min, max));
        expectContents(needed, [&](const glm::ivec3& v) {
            return v.x >= min.x && v.x <= max.x && v.y >= min.y && v.y <= max.y && v.z >= min.z && v.z <= max.z;
        });
        EXPECT_TRUE(needed.isEverything());
    }
    const auto aligned = NeededVoxels::everything(boxFrame(glm::ivec3(-8), glm::ivec3(15)));
    for (int slot = 0; slot < aligned.leafCount(); ++slot) EXPECT_TRUE(aligned.leafFull(slot));
}

TEST(NeededVoxels, EverythingOfAHugeBoxCostsNothingPerLeaf) {
    const auto needed = NeededVoxels::everything(boxFrame(glm::ivec3(-2048), glm::ivec3(2047)));
    EXPECT_EQ(needed.count(), std::int64_t{1} << 36);
    EXPECT_EQ(needed.leafCount(), 1 << 27);
    EXPECT_LT(needed.bytes(), 4096);
    EXPECT_EQ(needed.slotOf({2047, 2047, 2047}), (1 << 27) - 1);
    EXPECT_EQ(needed.leafOrigin((1 << 27) - 1), glm::ivec3(2040));
}

TEST(NeededVoxels, AnEmptyFrameHasNoLeaves) {
    const auto needed = NeededVoxels::everything(GridFrame{});
    EXPECT_EQ(needed.leafCount(), 0);
    EXPECT_EQ(needed.count(), 0);
    EXPECT_EQ(needed.slotOf(glm::ivec3(0)), -1);
}

TEST(NeededVoxels, TooManyLeavesAreRefusedWithFigures) {
    const auto frame = boxFrame(glm::ivec3(0), glm::ivec3(1 << 20, 1 << 20, 3));
    try {
        NeededVoxels::everything(frame);
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::Input);
        EXPECT_NE(std::string(e.what()).find("1048577 x 1048577 x 4"), std::string::npos) << e.what();
    }
}

TEST(NeededVoxels, SlotsFollowCoordinatesWhateverTheOrderOfAdding) {
    std::mt19937 random(7);
    const auto frame = boxFrame({-200, -20, -9}, {150, 33, 300});
    std::vector<glm::ivec3> voxels;
    for (int i = 0; i < 4000; ++i)
        voxels.push_back({int(random() % 400) - 220, int(random() % 70) - 30, int(random() % 330) - 15});
    auto a = NeededVoxels::none(frame), b = NeededVoxels::none(frame);
    for (const auto& v : voxels) a.add(v);
    std::shuffle(voxels.begin(), voxels.end(), random);
    for (const auto& v : voxels) b.add(v);
    a.finish(), b.finish();
    std::set<std::tuple<int, int, int>> inside;
    for (const auto& v : voxels)
        if (v.x >= -200 && v.x <= 150 && v.y >= -20 && v.y <= 33 && v.z >= -9 && v.z <= 300)
            inside.insert({v.x, v.y, v.z});
    ASSERT_EQ(a.leafCount(), b.leafCount());
    for (int slot = 0; slot < a.leafCount(); ++slot) {
        EXPECT_EQ(a.leafOrigin(slot), b.leafOrigin(slot));
        EXPECT_EQ(a.mask(slot), b.mask(slot));
        EXPECT_EQ(a.slotOf(a.leafOrigin(slot) + 7), slot);
        if (slot > 0) {
            const auto p = a.leafOrigin(slot - 1), q = a.leafOrigin(slot);
            EXPECT_LT(std::tie(p.x, p.y, p.z), std::tie(q.x, q.y, q.z));
        }
    }
    expectContents(a, [&](const glm::ivec3& v) { return inside.count({v.x, v.y, v.z}) > 0; });
}

TEST(NeededVoxels, ColumnsAndLeavesAreClipped) {
    const auto frame = boxFrame({-3, -2, -1}, {9, 10, 20});
    auto needed = NeededVoxels::none(frame);
    needed.addColumn(4, 5, -100, 100);
    needed.addColumn(4, 11, -100, 100);
    NeededVoxels::Mask full;
    full.fill(~0ull);
    needed.addLeaf({8, 8, 16}, full);
    needed.addLeaf({16, 0, 0}, full);
    needed.addLeaf({-8, -8, -8}, full);
    needed.finish();
    expectContents(needed, [](const glm::ivec3& v) {
        const bool inside = v.x >= -3 && v.x <= 9 && v.y >= -2 && v.y <= 10 && v.z >= -1 && v.z <= 20;
        return inside &&
               ((v.x == 4 && v.y == 5) || (v.x >= 8 && v.y >= 8 && v.z >= 16) || (v.x < 0 && v.y < 0 && v.z < 0));
    });
}

}  // namespace
}  // namespace photic
