// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/slabs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "bake/deposit/voxelise.h"

namespace photic {
namespace {

TEST(EdgeKernel, MeanClampedIsTheMeanOfTheClampedPlane) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> corner(-2, 3);
    for (int trial = 0; trial < 200; ++trial) {
        const double a = corner(random), b = trial % 5 ? corner(random) : a, c = trial % 7 ? corner(random) : b;
        double sum = 0;
        constexpr int n = 200;
        int count = 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j, ++count) {
                // Centroids of both orientations of small triangles; the second does not exist on the hypotenuse.
                const double p = (i + 1.0 / 3) / n, q = (j + 1.0 / 3) / n;
                sum += std::clamp(a + (b - a) * p + (c - a) * q, 0.0, 1.0);
                if (i + j + 1 < n) {
                    const double r = (i + 2.0 / 3) / n, s = (j + 2.0 / 3) / n;
                    sum += std::clamp(a + (b - a) * r + (c - a) * s, 0.0, 1.0);
                    ++count;
                }
            }
        EXPECT_NEAR(meanClamped(a, b, c), sum / count, 2e-4) << a << " " << b << " " << c;
    }
    EXPECT_NEAR(meanClamped(0.5, 0.5, 0.5), 0.5, 1e-15);
    EXPECT_NEAR(meanClamped(-1e-9, 1e-9, 0), 1e-9 / 4, 1e-10);
}

TEST(EdgeKernel, FractionInsideAgreesWithSampling) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-6, 16);
    for (int trial = 0; trial < 100; ++trial) {
        const double x[3] = {place(random), place(random), place(random)},
                     y[3] = {place(random), place(random), place(random)};
        int inside = 0, count = 0;
        constexpr int n = 150;
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j, ++count) {
                const double p = (i + 1.0 / 3) / n, q = (j + 1.0 / 3) / n;
                const double px = x[0] + (x[1] - x[0]) * p + (x[2] - x[0]) * q,
                             py = y[0] + (y[1] - y[0]) * p + (y[2] - y[0]) * q;
                inside += px > 0 && px < 10 && py > 0 && py < 10;
            }
        EXPECT_NEAR(fractionInside(x, y, 10, 10), static_cast<double>(inside) / count, 0.012);
    }
}

TEST(Slabs, AThinBandIsOneNarrowSlab) {
    GridFrame frame;
    frame.min = {0, 0, -128}, frame.max = {63, 63, 0};
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = 0; x < 64; ++x)
        for (int y = 0; y < 64; ++y) needed.addColumn(x, y, -66, -63);
    needed.finish();
    const auto groups = planSlabs(needed, 2, 64, 16);
    ASSERT_EQ(groups.size(), 1u);
    ASSERT_EQ(groups[0].slabs.size(), 1u);
    EXPECT_EQ(groups[0].slabs[0].first, -66);
    EXPECT_EQ(groups[0].slabs[0].active, 4);
    EXPECT_EQ(groups[0].slabs[0].lanes, 4);
    EXPECT_TRUE(groups[0].rectangle);
}

TEST(Slabs, CoverEveryLayerOnceAndShareNoLeaf) {
    for (const int lanes : {4, 8, 16}) {
        GridFrame frame;
        frame.min = {-5, 3, -37}, frame.max = {90, 70, 61};
        const auto groups = planSlabs(NeededVoxels::everything(frame), 2, 64, lanes);
        int next = frame.min.z, last_leaf = -1000;
        for (const SlabGroup& group : groups) {
            EXPECT_GT(group.slabs.front().first >> 3, last_leaf);
            for (const Slab& slab : group.slabs) {
                EXPECT_EQ(slab.first, next);
                EXPECT_LE(slab.active, slab.lanes);
                EXPECT_LE(slab.lanes, lanes);
                next = slab.first + slab.active;
            }
            last_leaf = (next - 1) >> 3;
        }
        EXPECT_EQ(next, frame.max.z + 1);
    }
}

}  // namespace
}  // namespace photic
