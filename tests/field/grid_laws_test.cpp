// SPDX-License-Identifier: Apache-2.0
#include "bake/field/grid_laws.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Flux = std::function<glm::dvec3(const glm::dvec3& world)>;

LightField fluxField(const GridFrame& frame, const Flux& flux) {
    LightField field(std::make_shared<NeededVoxels>(NeededVoxels::everything(frame)), {1, true});
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        float* leaf = field.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = field.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const glm::dvec3 f = flux(frame.worldFromIndex(v));
            leaf[i] = static_cast<float>(glm::length(f));
            for (int a = 0; a < 3; ++a) leaf[(1 + a) * 512 + i] = static_cast<float>(f[a]);
        }
    }
    return field;
}

GridFrame leaningFrame(double h) {
    const int n = static_cast<int>(std::lround(1 / h));
    return {{glm::dvec3(h, 0, 0), glm::dvec3(0, h, 0), glm::dvec3(0.3 * h, -0.2 * h, 0.8 * h)},
            {0.1, 0.2, 0.05},
            glm::ivec3(-n),
            glm::ivec3(n - 1)};
}

TEST(NetFlux, VanishesForEvenLightAndTellsALossFromIt) {
    const GridFrame frame = leaningFrame(1.0 / 16);
    const auto even = fluxField(frame, [](const glm::dvec3&) { return glm::dvec3(0.3, -0.4, -0.8); });
    EXPECT_LT(std::fabs(netFluxThroughBox(even, {-10, -9, -8}, {5, 6, 7})), 1e-7);
    // A tenth of the light vanishes in the middle of the box: the checker must see it.
    const auto lossy = fluxField(frame, [](const glm::dvec3& p) { return glm::dvec3(0, 0, p.z > 0 ? -1.0 : -0.9); });
    EXPECT_LT(netFluxThroughBox(lossy, {-10, -9, -8}, {5, 6, 7}), -0.01);
    // Light that spreads from a source inside leaves the box.
    const auto source = fluxField(frame, [](const glm::dvec3& p) { return p; });
    EXPECT_GT(netFluxThroughBox(source, {-8, -8, -8}, {7, 7, 7}), 0.5);
}

TEST(NetFlux, OfAPointSourceOutsideFallsWithTheSquareOfTheVoxel) {
    const glm::dvec3 source(2.5, 0.3, 0.4);
    std::vector<double> error;
    for (const int n : {8, 16, 32}) {
        const auto field = fluxField(leaningFrame(1.0 / n), [&](const glm::dvec3& p) {
            const glm::dvec3 r = p - source;
            return r / std::pow(glm::length(r), 3);
        });
        error.push_back(std::fabs(netFluxThroughBox(field, glm::ivec3(-n / 2), glm::ivec3(n / 2 - 1))));
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 1.8);
    EXPECT_GT(std::log2(error[1] / error[2]), 1.8);
}

TEST(LayerPower, IsTheDownwardPowerOfEachLayer) {
    const double h = 1.0 / 16;
    const auto field = fluxField(leaningFrame(h), [](const glm::dvec3& p) { return glm::dvec3(3, 4, -1 - p.z); });
    const auto power = layerPower(field);
    ASSERT_EQ(power.size(), 32u);
    // The layer's plane is horizontal however the columns lean: only the vertical flux counts.
    for (int k = 0; k < 32; ++k) {
        const double z = (k - 16) * 0.8 * h + 0.05;
        EXPECT_NEAR(power[static_cast<std::size_t>(k)], (1 + z) * 4, 1e-5);
    }
    std::vector<double> again;
    setThreadCount(1);
    again = layerPower(field);
    setThreadCount(0);
    EXPECT_EQ(power, again);
}

TEST(CheckLaws, HoldForGoodFieldsAndEachFailsOnItsOwnDamage) {
    const GridFrame frame = leaningFrame(1.0 / 8);
    const auto good = [&] {
        return fluxField(frame, [](const glm::dvec3& p) { return glm::dvec3(0.1, 0.2, -1 - 0.1 * p.x); });
    };
    for (const LawCheck& law : checkLaws(good())) EXPECT_TRUE(law.holds) << law.name << ' ' << law.value;
    EXPECT_TRUE(brokenLaws(good()).empty());

    const glm::ivec3 voxel(2, -3, 1);
    const int offset = NeededVoxels::offsetInLeaf(voxel);
    const std::array<std::function<void(float*)>, 3> damages{
        [&](float* leaf) { leaf[2 * 512 + offset] = std::numeric_limits<float>::quiet_NaN(); },
        [&](float* leaf) {
            leaf[offset] = -1e-3f;
            for (int c = 1; c < 4; ++c) leaf[c * 512 + offset] = 0;
        },
        [&](float* leaf) { leaf[3 * 512 + offset] *= 1.001f; }};
    for (std::size_t d = 0; d < damages.size(); ++d) {
        LightField field = good();
        damages[d](field.dense(field.needed().slotOf(voxel)));
        const auto laws = checkLaws(field);
        ASSERT_EQ(laws.size(), damages.size());
        for (std::size_t l = 0; l < laws.size(); ++l)
            EXPECT_EQ(laws[l].holds, l != d) << laws[l].name << ' ' << laws[l].value;
        const auto broken = brokenLaws(field);
        ASSERT_EQ(broken.size(), 1u);
        EXPECT_EQ(broken[0].name, laws[d].name);
    }
}

/// What sums of many colours leave behind a receiver is rounding, and no law is broken; a thousandth is no rounding.
TEST(CheckLaws, RoundingIsNoDamage) {
    for (const float left : {3e-6f, 1e-3f}) {
        LightField field(std::make_shared<const NeededVoxels>(NeededVoxels::everything(leaningFrame(1.0 / 8))),
                         {3, true});
        float* leaf = field.makeDense(0);
        leaf[7] = 2, leaf[512 + 7] = 1, leaf[2 * 512 + 7] = 0.5f, leaf[5 * 512 + 7] = -1;
        leaf[9] = leaf[512 + 9] = leaf[2 * 512 + 9] = -left, leaf[5 * 512 + 9] = -left;
        for (const LawCheck& law : checkLaws(field))
            EXPECT_EQ(law.holds, left < 1e-5f || law.name.starts_with("voxels")) << law.name << ' ' << law.value;
    }
}

TEST(OpposedLight, IsToldByTheLengthOfTheMeanDirection) {
    // Two beams alike, 2 a apart, in a quarter of the box: cos(a) long, and a wall between them gets sin(a) / 2 of
    // each.
    for (const double a : {0.0, 0.3, 0.6, 1.2}) {
        LightField field = fluxField(leaningFrame(1.0 / 16), [](const glm::dvec3&) { return glm::dvec3(0, 0, -1); });
        for (int slot = 0; slot < field.leafCount(); ++slot) {
            if (slot % 4 != 0) continue;
            float* leaf = field.makeDense(slot);
            for (int i = 0; i < 512; ++i) leaf[3 * 512 + i] = -static_cast<float>(std::cos(a));
        }
        const OpposedLight opposed = opposedLight(field);
        const bool told = std::cos(a) < 0.9;
        EXPECT_NEAR(opposed.share, told ? 0.25 : 0, 0.01) << a;
        EXPECT_NEAR(opposed.lost, told ? 0.5 * std::sin(a) : 0, 1e-6) << a;
    }
}

}  // namespace
}  // namespace photic
