// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/flat_blocks.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace photic {
namespace {

SplineIndex ball(SplineFit fit) {
    SplineIndex::Nodes nodes;
    nodes.count = {64, 40, 64};
    return {nodes, [](const glm::dvec3& p) { return glm::distance(p, {20, 20, 20}) < 9 ? 1.0 : 0.5; }, fit};
}

TEST(FlatBlocks, LightThatGoesStraightThroughThemBendsNowhere) {
    const SplineIndex index = ball(SplineFit::Plain);
    const FlatBlocks blocks(index, {});
    EXPECT_EQ(blocks.count(), glm::ivec3(8, 5, 8));
    int flat = 0;
    for (int i = 0; i < 8 * 5 * 8; ++i) flat += blocks.flat({i % 8, i / 8 % 5, i / 40}) ? 1 : 0;
    EXPECT_GT(flat, 8 * 5 * 8 / 2);
    EXPECT_LT(flat, 8 * 5 * 8);
    // Places everywhere: whatever bends is in a block that is not flat.
    int bends = 0;
    for (double x = 0.3; x < 63; x += 0.7)
        for (double y = 0.3; y < 39; y += 0.7)
            for (double z = 0.3; z < 63; z += 0.7) {
                const glm::dvec3 p(x, y, z);
                if (glm::length(index.at(p).gradient) < 1e-6) continue;
                ++bends;
                ASSERT_FALSE(blocks.flat(blocks.blockOf(p))) << x << " " << y << " " << z;
            }
    EXPECT_GT(bends, 1000);
}

TEST(FlatBlocks, AMediumThatEndsInABlockIsNotFlat) {
    SplineIndex::Nodes nodes;
    nodes.count = {32, 32, 32};
    const SplineIndex index(
        nodes, [](const glm::dvec3&) { return 0.5; }, SplineFit::Plain);
    std::vector<std::uint8_t> media(32 * 32 * 32, 0);
    EXPECT_TRUE(FlatBlocks(index, media).flat({1, 1, 1}));
    media[(12 * 32 + 12) * 32 + 12] = 1;
    EXPECT_FALSE(FlatBlocks(index, media).flat({1, 1, 1}));
    EXPECT_TRUE(FlatBlocks(index, media).flat({3, 1, 1}));
    // Places beyond the nodes belong to the rim's blocks.
    EXPECT_EQ(FlatBlocks(index, media).blockOf({-5, 40, 12}), glm::ivec3(0, 3, 1));
}

}  // namespace
}  // namespace photic
