// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bake/field/caustic_steps.h"
#include "bake/report/error.h"

namespace photic {
namespace {

GridFrame cube(int n) { return {glm::dmat3(0.1), glm::dvec3(0), glm::ivec3(0), glm::ivec3(n - 1)}; }

LightField filled(int n, float (*value)(const glm::ivec3&)) {
    LightField field(std::make_shared<const NeededVoxels>(NeededVoxels::everything(cube(n))), {1, false});
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z)
                field.makeDense(field.needed().slotOf({x, y, z}))[NeededVoxels::offsetInLeaf({x, y, z})] =
                    value({x, y, z});
    return field;
}

TEST(CausticSteps, SharpenIsAPower) {
    LightField field = filled(8, [](const glm::ivec3& v) { return static_cast<float>(v.x - 3); });
    sharpenCaustic(field, 0.5, 3, -1);
    EXPECT_FLOAT_EQ(field.value({0, 0, 0}, 0), 13.5f);
    EXPECT_FLOAT_EQ(field.value({2, 5, 5}, 0), 0.5f);
    EXPECT_FLOAT_EQ(field.value({5, 0, 0}, 0), 0.0f);
}

/// A cosine with zero slope at the sides is a standing wave: it stays where it is and swings as the scheme's own
/// frequency says, cos(omega t) with 4 sin^2(omega / 2) = c^2 4 sin^2(k / 2).
TEST(CausticSteps, DissipationIsAWave) {
    constexpr int n = 32;
    LightField field = filled(n, [](const glm::ivec3& v) {
        return static_cast<float>(10 + std::cos(2 * std::numbers::pi * (v.x + 0.5) / n));
    });
    const double c = 0.5, k = 2 * std::numbers::pi / n, omega = 2 * std::asin(c * std::sin(k / 2));
    dissipateCaustic(field, 2.0, c);  // below the layer at 2.0 m, number 20
    EXPECT_FLOAT_EQ(field.value({3, 4, 20}, 0), field.value({3, 4, 31}, 0));
    for (const int z : {19, 12, 3, 0}) {
        const int step = 20 - z;
        // At rest between the first two: the phase counts from half a step before.
        // Four passes of [1, 2, 1] / 4 take cos^2(k / 2) each.
        const double swing = std::pow(std::cos(k / 2), 8) * std::cos(omega * (step + 0.5)) / std::cos(omega / 2);
        for (const int x : {0, 7, 20})
            EXPECT_NEAR(double(field.value({x, 9, z}, 0)), 10 + swing * std::cos(k * (x + 0.5)), 1e-5) << z;
    }
}

TEST(CausticSteps, KeepsTheSumWhileNothingIsCut) {
    LightField field = filled(24, [](const glm::ivec3& v) { return v.x == 11 && v.y == 12 ? 5.0f : 1.0f; });
    dissipateCaustic(field, 1.55, 0.1);
    double top = 0, low = 0;
    for (int x = 0; x < 24; ++x)
        for (int y = 0; y < 24; ++y)
            top += double(field.value({x, y, 20}, 0)), low += double(field.value({x, y, 10}, 0));
    EXPECT_NEAR(low / top, 1, 1e-6);
    EXPECT_LT(field.value({11, 12, 10}, 0), 5.0f);
    EXPECT_GT(field.value({12, 12, 10}, 0), 1.0f);
}

TEST(CausticSteps, RefusesWhatIsNotStable) {
    LightField field = filled(8, [](const glm::ivec3&) { return 1.0f; });
    EXPECT_THROW(dissipateCaustic(field, 0.4, 0.71), Error);
    EXPECT_THROW(dissipateCaustic(field, 0.4, std::nan("")), Error);
    EXPECT_NO_THROW(dissipateCaustic(field, 0.4, 0.7));
}

}  // namespace
}  // namespace photic
