// SPDX-License-Identifier: Apache-2.0
#include "bake/field/two_levels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/field/coarsen.h"
#include "bake/field/resample.h"

namespace photic {
namespace {

/// Smooth light with a sharp line along y near x = 20, on the voxels for which `needed` holds.
template <class Needed>
LightField lineOfLight(const Needed& wanted) {
    GridFrame frame;
    frame.min = glm::ivec3(-20, -5, 0), frame.max = glm::ivec3(60, 50, 40);
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z)
                if (wanted(x, y, z)) needed.add({x, y, z});
    needed.finish();
    LightField field(std::make_shared<const NeededVoxels>(std::move(needed)), {1, true});
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        float* leaf = field.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = field.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (!field.needed().contains(v)) continue;
            leaf[i] = static_cast<float>(10 + 3 * std::sin(0.1 * v.y + 0.05 * v.z) +
                                         200 * std::exp(-std::pow(v.x - 20.4, 2)));
            leaf[512 * 3 + i] = -0.99f * leaf[i];
        }
    }
    return field;
}

double error(const LightField& was, const LightField& is) {
    double sum = 0, of = 0;
    for (int slot = 0; slot < was.leafCount(); ++slot)
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = was.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (!was.needed().contains(v)) continue;
            sum += std::fabs(double(is.value(v, 0)) - double(was.value(v, 0))), of += double(was.value(v, 0));
        }
    return sum / of;
}

TEST(TwoLevels, MarkedBlocksAreLookUpsOfEverySecondVoxel) {
    const LightField field = lineOfLight([](int, int, int) { return true; });
    const TwoLevels levels(field, nullptr, Monitor());
    ASSERT_GT(levels.blockCount(), 40);
    const TwoLevels::Made made = levels.with(levels.blockCount() / 2);
    EXPECT_EQ(made.blocks.count(), levels.blockCount() / 2);
    int looked_at = 0;
    for (int bx = -2; bx < 4; ++bx)
        for (int by = -1; by < 4; ++by)
            for (int bz = 0; bz < 3; ++bz) {
                if (!made.blocks.has({bx, by, bz})) continue;
                for (int n = 0; n < 17 * 17 * 17; ++n) {
                    const glm::ivec3 v = 16 * glm::ivec3(bx, by, bz) + glm::ivec3(n % 17, n / 17 % 17, n / 289);
                    for (int c = 0; c < 4; ++c) {
                        double mean = 0;
                        for (int corner = 0; corner < 8; ++corner) {
                            glm::ivec3 at = v;
                            for (int a = 0; a < 3; ++a) at[a] += (v[a] & 1) == 0 ? 0 : corner >> a & 1 ? 1 : -1;
                            mean += double(made.field.value(at, c)) / 8;
                        }
                        ASSERT_NEAR(made.field.value(v, c), mean, 1e-4) << v.x << " " << v.y << " " << v.z;
                    }
                    ++looked_at;
                }
            }
    EXPECT_GT(looked_at, 20 * 17 * 17 * 17);
    // Outside of them and their far sides nothing has changed.
    EXPECT_EQ(error(field, levels.with(0).field), 0);
}

// The smooth blocks come first: with half of them error is a hundredth of what it is with all.
TEST(TwoLevels, SharpLightIsKeptLongest) {
    const LightField field = lineOfLight([](int, int, int) { return true; });
    const TwoLevels levels(field, nullptr, Monitor());
    double last = 0;
    for (const int part : {4, 2, 1}) {
        const double now = error(field, levels.with(levels.blockCount() / part).field);
        EXPECT_GE(now, last);
        last = now;
    }
    EXPECT_GT(last, 0.02);
    EXPECT_LT(error(field, levels.with(levels.blockCount() / 2).field), last / 100);
}

// A floor's band: what lies outside of it nobody asked for, and it darkens nothing inside.
TEST(TwoLevels, BandsKeepTheirLightToTheirEnds) {
    const LightField field = lineOfLight([](int x, int, int z) { return z >= 4 && z < 8 && x > 26; });
    const TwoLevels levels(field, nullptr, Monitor());
    EXPECT_LT(error(field, levels.with(levels.blockCount()).field), 1e-3);
}

TEST(TwoLevels, BlocksAsTextAreTheSameBlocks) {
    CoarseBlocks blocks({-3, 2, 0}, {4, 5, 1});
    EXPECT_TRUE(blocks.empty());
    for (const glm::ivec3& b : {glm::ivec3(-3, 2, 0), glm::ivec3(0, 3, 1), glm::ivec3(4, 5, 1)}) blocks.mark(b);
    const CoarseBlocks read = CoarseBlocks::fromText(blocks.text());
    EXPECT_EQ(read.count(), 3);
    EXPECT_TRUE(read.has({0, 3, 1}));
    EXPECT_FALSE(read.has({0, 3, 0}));
    EXPECT_FALSE(read.has({50, 3, 0}));
    EXPECT_EQ(read.text(), blocks.text());
    for (const char* text : {"", "1,2,3", "0,0,0,1,1,1:", "0,0,0,1,1,1:g", "0,0,0,-1,1,1:f"})
        EXPECT_THROW(CoarseBlocks::fromText(text), Error) << text;
}

}  // namespace
}  // namespace photic
