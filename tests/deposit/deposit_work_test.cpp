// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/deposit_work.h"

#include <gtest/gtest.h>

namespace photic {
namespace {

GridFrame frameOf(int size, int layers) {
    return {glm::dmat3(1), glm::dvec3(0), glm::ivec3(0), glm::ivec3(size - 1, size - 1, layers - 1)};
}

/// One tube that goes up from below the grid, its corners a voxel apart.
/// @param fan  [voxels a layer] by which two of its rays lean away from the third
TubeSet tubeAt(double u, double v, double fan = 0) {
    TubeSet set;
    set.axis = 2, set.sense = 1;
    const double lean[3][2] = {{0, 0}, {fan, 0}, {0, fan}};
    for (int i = 0; i < 3; ++i) {
        set.corners.push_back({u + (i == 1), v + (i == 2), -1, lean[i][0], lean[i][1], 1e6});
        set.addSlope(lean[i][0], lean[i][1], 1);
    }
    set.tubes.push_back({{1, 1, 1}, 1, {0, 0, 1}});
    set.blocks.push_back({BlockTopology::fromTriangles(3, {{{0, 1, 2}}}), 0, 0});
    return set;
}

VoxeliseOptions at(int points) {
    VoxeliseOptions options;
    options.quadrature = points;
    return options;
}

TEST(DepositWork, ATubeIsLookedAtInEachSlabAndAtEachPoint) {
    EXPECT_EQ(depositWork(tubeAt(8, 8), frameOf(16, 16), at(1)).tubes, 1);
    EXPECT_EQ(depositWork(tubeAt(8, 8), frameOf(16, 48), at(1)).tubes, 3);
    EXPECT_EQ(depositWork(tubeAt(8, 8), frameOf(16, 48), at(4)).tubes, 12);
    EXPECT_EQ(depositWork(tubeAt(8, 8), frameOf(16, 48), at(0)).tubes, 3) << "upright light takes one point";
}

TEST(DepositWork, WhatPassesTheGridTakesNothing) {
    const DepositWork work = depositWork(tubeAt(30, 8), frameOf(16, 48), at(1));
    EXPECT_EQ(work.tubes, 0);
    EXPECT_EQ(work.cells, 0);
    EXPECT_GT(depositWork(tubeAt(30, 8), frameOf(64, 48), at(1)).tubes, 0);
}

// Sums drift with the mean slope: what leans otherwise comes by more voxels in a slab.
TEST(DepositWork, LightThatGoesApartComesByMoreVoxels) {
    const double straight = depositWork(tubeAt(8, 8), frameOf(64, 16), at(1)).cells;
    const double fan = depositWork(tubeAt(8, 8, 0.5), frameOf(64, 16), at(1)).cells;
    EXPECT_NEAR(straight, 0.5 * (1 * 3 + 2 * 3 + 2 * 2), 1e-9) << "two short sides and the long one";
    EXPECT_GT(fan, 4 * straight);
}

}  // namespace
}  // namespace photic
