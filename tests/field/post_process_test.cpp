// SPDX-License-Identifier: Apache-2.0
#include "bake/field/post_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <random>

#include "bake/field/prefilter.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

std::shared_ptr<const NeededVoxels> everything(const glm::ivec3& min, const glm::ivec3& max) {
    GridFrame frame;
    frame.min = min, frame.max = max;
    return std::make_shared<NeededVoxels>(NeededVoxels::everything(frame));
}

template <class Value>
void fill(LightField& field, Value value) {
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        float* leaf = field.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = field.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (!field.needed().contains(v)) continue;
            for (int c = 0; c < field.channels().count(); ++c) leaf[c * 512 + i] = value(v, c);
        }
    }
}

// The blur of a trilinear look-up: [1/8, 3/4, 1/8] along each axis, mirrored where the next voxel is not needed.
double blurred(const LightField& field, const glm::ivec3& v, int channel) {
    const std::function<double(glm::ivec3, int)> along = [&](glm::ivec3 p, int axis) -> double {
        if (axis < 0) return double(field.value(p, channel));
        const double here = along(p, axis - 1);
        double sum = 0.75 * here;
        for (const int side : {-1, 1}) {
            glm::ivec3 q = p;
            q[axis] += side;
            sum += 0.125 * (field.needed().contains(q) ? along(q, axis - 1) : here);
        }
        return sum;
    };
    return along(v, 2);
}

TEST(Prefilter, IsTheInverseOfTheLookUpsBlur) {
    // Boxes that end within leaves, and a ball, whose runs of voxels all differ. Bright and smooth: nothing is clamped.
    GridFrame frame;
    frame.min = {-5, 2, -11}, frame.max = {20, 17, 14};
    auto ball = NeededVoxels::none(frame);
    for (int x = -5; x <= 20; ++x)
        for (int y = 2; y <= 17; ++y)
            for (int z = -11; z <= 14; ++z)
                if (glm::length(glm::dvec3(x, y, z) - glm::dvec3(7, 9, 1)) < 10.3) ball.add({x, y, z});
    ball.finish();
    for (const auto& needed : {everything(glm::ivec3(0), glm::ivec3(23)), everything(frame.min, frame.max),
                               everything({3, 3, 3}, {3, 4, 30}),
                               std::shared_ptr<const NeededVoxels>(std::make_shared<NeededVoxels>(ball))}) {
        LightField field(needed, {1, true});
        const auto value = [](const glm::ivec3& v, int c) {
            return c == 0 ? 10 + std::sin(0.9f * float(v.x)) +
                                std::cos(1.1f * float(v.y) + 0.3f) * std::sin(0.7f * float(v.z))
                          : float(c) + std::cos(0.8f * float(v.x + c) + 0.5f * float(v.y) - 1.2f * float(v.z));
        };
        fill(field, value);
        prefilterForTrilinear(field);
        double moved = 0;
        for (int slot = 0; slot < field.leafCount(); ++slot)
            for (int i = 0; i < 512; ++i) {
                const glm::ivec3 v = needed->leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
                if (!needed->contains(v)) continue;
                // A blur of one axis after the other is the inverse only where the needed voxels are a box: in a ball
                // the runs' ends differ from axis to axis, and only voxels away from its surface can be checked.
                if (!needed->isEverything() && glm::length(glm::dvec3(v) - glm::dvec3(7, 9, 1)) > 4.5) continue;
                for (int c = 0; c < 4; ++c) {
                    const double limit = needed->isEverything() ? 1e-5 : 1e-3;
                    ASSERT_NEAR(blurred(field, v, c), double(value(v, c)), limit) << v.x << ' ' << v.y << ' ' << v.z;
                    moved = std::max(moved, std::fabs(double(field.value(v, c)) - double(value(v, c))));
                }
            }
        EXPECT_GT(moved, 0.05);
    }
}

TEST(Prefilter, KeepsSumsAndConstants) {
    const auto needed = everything({1, 0, -3}, {30, 21, 19});
    LightField field(needed, {3, true});
    fill(field, [](const glm::ivec3& v, int c) { return 10 + 0.2f * float((v.x * 7 + v.y * 3 + v.z + c) % 5); });
    std::array<double, 6> before{};
    for (int c = 0; c < 6; ++c) before[static_cast<std::size_t>(c)] = field.sum(c);
    prefilterForTrilinear(field);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(field.sum(c) / before[static_cast<std::size_t>(c)], 1, 1e-6);

    LightField even(needed, {1, true});
    fill(even, [](const glm::ivec3&, int c) { return c == 0 ? 3.0f : -1.0f; });
    prefilterForTrilinear(even);
    for (const glm::ivec3 v : {glm::ivec3(1, 0, -3), glm::ivec3(15, 10, 5), glm::ivec3(30, 21, 19)}) {
        EXPECT_NEAR(even.value(v, 0), 3, 1e-5);
        EXPECT_NEAR(even.value(v, 2), -1, 1e-5);
    }
}

TEST(Prefilter, MeansOfTheInterpolantConvergeFaster) {
    // Voxel means of a smooth function, looked up trilinearly: the mean over a cell is then (nearly) the stored one.
    std::vector<double> plain, filtered;
    for (const int n : {16, 32, 64}) {
        const double h = 2 * M_PI / n;
        const auto mean = [&](int i) { return 2 + (std::cos(i * h) - std::cos((i + 1) * h)) / h; };
        LightField field(everything(glm::ivec3(0), glm::ivec3(n - 1, 7, 7)), {1, false});
        fill(field, [&](const glm::ivec3& v, int) { return static_cast<float>(mean(v.x)); });
        const auto error = [&] {
            double sum = 0;
            for (int i = n / 4; i < 3 * n / 4; ++i)
                sum +=
                    std::fabs(0.125 * double(field.value({i - 1, 4, 4}, 0)) + 0.75 * double(field.value({i, 4, 4}, 0)) +
                              0.125 * double(field.value({i + 1, 4, 4}, 0)) - mean(i));
            return sum / (n / 2);
        };
        plain.push_back(error());
        prefilterForTrilinear(field);
        filtered.push_back(error());
    }
    EXPECT_NEAR(std::log2(plain[0] / plain[1]), 2, 0.1);
    EXPECT_NEAR(std::log2(plain[1] / plain[2]), 2, 0.1);
    for (const double e : filtered) EXPECT_LT(e, 1e-6);  // single precision, at every resolution
}

/// Light in one voxel: it has no lit neighbour to take from, stays as it is, and nothing around it becomes lit.
TEST(Prefilter, DarknessEndsLight) {
    const auto needed = everything(glm::ivec3(0), glm::ivec3(63));
    LightField field(needed, {1, true});
    float* leaf = field.makeDense(needed->slotOf({31, 31, 31}));
    leaf[511] = 100, leaf[3 * 512 + 511] = -100;
    prefilterForTrilinear(field);
    int lit = 0;
    for (int slot = 0; slot < field.leafCount(); ++slot) lit += field.state(slot) != LeafState::Empty;
    EXPECT_EQ(lit, 1);
    EXPECT_EQ(field.value({31, 31, 31}, 0), 100);
    EXPECT_EQ(field.value({31, 31, 31}, 3), -100);
    EXPECT_EQ(field.value({30, 31, 31}, 0), 0);
}

/// A slab of even light with darkness on both sides and a step in the middle of one: even light stays even to its end.
TEST(Prefilter, EvenLightStaysEvenUpToDarkness) {
    const auto needed = everything({-4, -4, -30}, {20, 12, 9});
    LightField field(needed, {3, true});
    const auto light = [](const glm::ivec3& v, int c) {
        const float values[6] = {1, 2, 0.5f, 0.2f, 0, -1.1f};
        return v.z > (v.x < 7 ? -17 : -14) && v.z < 3 ? values[c] : 0.0f;
    };
    fill(field, light);
    prefilterForTrilinear(field);
    for (int x = -4; x <= 20; ++x)
        for (int y = -4; y <= 12; ++y)
            for (int z = -30; z <= 9; ++z)
                for (int c = 0; c < 6; ++c) {
                    const float expected = light({x, y, z}, c);
                    ASSERT_NEAR(field.value({x, y, z}, c), expected, 1e-6f) << x << ' ' << y << ' ' << z << ' ' << c;
                }
}

/// Spikes, steps and holes of three colours: nothing becomes negative, no colour's sum changes, and no more crosses a
/// face than the voxel before it could spare.
TEST(Prefilter, WhatIsHeldBackIsNotLost) {
    const auto needed = everything({-3, 1, -9}, {44, 33, 21});
    for (const int colours : {1, 3}) {
        LightField field(needed, {colours, true}), before(needed, {colours, true});
        std::mt19937 random(3);
        std::lognormal_distribution<float> spiky(0, 2);
        for (int slot = 0; slot < field.leafCount(); ++slot) {
            float *leaf = field.makeDense(slot), *kept = before.makeDense(slot);
            for (int i = 0; i < 512; ++i) {
                const bool dark = random() % 5 == 0;
                for (int c = 0; c < colours; ++c) leaf[c * 512 + i] = dark ? 0 : spiky(random);
                for (int c = 0; c < 3; ++c) leaf[(colours + c) * 512 + i] = 0.5f * leaf[i];
            }
            std::copy_n(leaf, 512 * field.channels().count(), kept);
        }
        prefilterForTrilinear(field);
        for (int c = 0; c < colours; ++c) EXPECT_NEAR(field.sum(c) / before.sum(c), 1, 1e-6) << c;
        double moved = 0;
        for (int x = -3; x <= 44; ++x)
            for (int y = 1; y <= 33; ++y)
                for (int z = -9; z <= 21; ++z) {
                    const glm::ivec3 v(x, y, z);
                    for (int c = 0; c < colours; ++c) {
                        ASSERT_GE(field.value(v, c), 0) << x << ' ' << y << ' ' << z;
                        if (before.value(v, c) == 0) {
                            ASSERT_EQ(field.value(v, c), 0);
                        }
                        moved += std::fabs(double(field.value(v, c) - before.value(v, c)));
                    }
                    ASSERT_LE(glm::length(field.flux(v)), field.irradiance(v) * (1 + 1e-6));
                }
        EXPECT_GT(moved, 0.1 * before.sum(0)) << "nothing was sharpened";
    }
}

/// A line of voxels: what crosses a face is at most an eighth of twice the largest value, so light stays near by.
TEST(Prefilter, LightStaysNearBy) {
    const auto needed = everything({0, 0, 0}, {0, 0, 99});
    LightField field(needed, {1, false});
    std::mt19937 random(11);
    std::vector<double> values;
    for (int z = 0; z < 100; ++z) values.push_back(z % 17 == 3 ? 50 : 1 + (random() % 100) * 0.01);
    for (int z = 0; z < 100; ++z)
        field.makeDense(needed->slotOf({0, 0, z}))[NeededVoxels::offsetInLeaf({0, 0, z})] =
            static_cast<float>(values[static_cast<std::size_t>(z)]);
    prefilterForTrilinear(field);
    double gap = 0, worst = 0;
    for (int z = 0; z < 100; ++z) {
        const double after = double(field.value({0, 0, z}, 0));
        EXPECT_GE(after, 0.5 - 1e-6);  // half of the least around it
        gap += after - values[static_cast<std::size_t>(z)], worst = std::max(worst, std::fabs(gap));
    }
    EXPECT_NEAR(gap, 0, 1e-3);
    EXPECT_LT(worst, 2);  // of spikes of 50 between voxels of 1 to 2
}

TEST(Prefilter, IsTheSameForAnyNumberOfThreads) {
    const auto needed = everything({-3, 0, 2}, {60, 50, 40});
    std::vector<LightField> fields;
    for (const int threads : {1, 2}) {
        setThreadCount(threads);
        LightField& field = fields.emplace_back(needed, FieldChannels{1, true});
        fill(field, [](const glm::ivec3& v, int c) { return float((v.x * 31 + v.y * 17 + v.z * 5 + c * 3) % 23); });
        prefilterForTrilinear(field);
    }
    setThreadCount(0);
    for (int slot = 0; slot < fields[0].leafCount(); ++slot)
        ASSERT_EQ(std::memcmp(fields[0].dense(slot), fields[1].dense(slot), 4 * 512 * sizeof(float)), 0) << slot;
}

TEST(RestoreFluxBound, ShortensAndTouchesNothingElse) {
    LightField field(everything(glm::ivec3(0), glm::ivec3(15, 7, 7)), {3, true});
    float* leaf = field.makeDense(0);
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 512; ++i) {
        for (int c = 0; c < 3; ++c) leaf[c * 512 + i] = std::fabs(normal(random));
        for (int c = 3; c < 6; ++c) leaf[c * 512 + i] = normal(random);
    }
    field.setConstant(1, std::array<float, 6>{1, 2, 3, 0, 0, -8});
    std::vector<float> before(leaf, leaf + 6 * 512);
    restoreFluxBound(field);
    int shortened = 0;
    for (int i = 0; i < 512; ++i) {
        const glm::ivec3 v(i >> 6, i >> 3 & 7, i & 7);
        const std::size_t s = static_cast<std::size_t>(i);
        const glm::dvec3 old(before[3 * 512 + s], before[4 * 512 + s], before[5 * 512 + s]);
        const glm::dvec3 flux = field.flux(v);
        EXPECT_LE(glm::length(flux), field.irradiance(v) * (1 + 1e-6));
        if (glm::length(old) > field.irradiance(v) * (1 + 1e-6)) {
            EXPECT_NEAR(glm::length(flux), field.irradiance(v), 1e-5);
            EXPECT_NEAR(glm::dot(glm::normalize(flux), glm::normalize(old)), 1, 1e-6);
            ++shortened;
        } else {
            EXPECT_LT(glm::length(flux - old), 1e-6);
        }
    }
    EXPECT_GT(shortened, 50);
    EXPECT_NEAR(field.flux({8, 0, 0}).z, -2, 1e-5);
}

TEST(CollapseConstantLeaves, KeepsSumsToItsTolerance) {
    LightField field(everything(glm::ivec3(0), glm::ivec3(31, 7, 6)), {1, true});
    for (int slot = 0; slot < 4; ++slot) {
        float* leaf = field.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            leaf[i] = slot == 0 ? 5 + 0.01f * float(i % 3) : slot == 1 ? float(i) : slot == 2 ? 1e-9f : 5;
            leaf[3 * 512 + i] = slot == 3 ? -float(i % 7) : -leaf[i];
        }
    }
    const double sum = field.sum(0), down = field.sum(3);
    EXPECT_EQ(collapseConstantLeaves(field, 0.01, 1e-6), 2);
    EXPECT_EQ(field.state(0), LeafState::Constant);
    EXPECT_EQ(field.state(1), LeafState::Dense);
    EXPECT_EQ(field.state(2), LeafState::Empty);
    EXPECT_EQ(field.state(3), LeafState::Dense);  // even light from uneven directions
    EXPECT_NEAR(field.sum(0), sum, 1e-3);
    EXPECT_NEAR(field.sum(3), down, 1e-3);
}

}  // namespace
}  // namespace photic
