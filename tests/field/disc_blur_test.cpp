// SPDX-License-Identifier: Apache-2.0
#include "bake/field/disc_blur.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

LayerKernel ellipse(double a, double b, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {glm::dmat2(a * c, a * s, -b * s, b * c)};
}

std::shared_ptr<const NeededVoxels> everything(const glm::ivec3& min, const glm::ivec3& max) {
    GridFrame frame;
    frame.min = min, frame.max = max;
    return std::make_shared<NeededVoxels>(NeededVoxels::everything(frame));
}

TEST(DiscStencil, KeepsEnergySymmetryAndSecondMoments) {
    for (const auto& kernel : {ellipse(0.05, 0.03, 0.4), ellipse(0.7, 0.7, 0), ellipse(0.9, 0.4, 1.1),
                               ellipse(3.2, 1.5, 0.6), ellipse(20, 7, 2)}) {
        const DiscStencil s = discStencil(kernel);
        ASSERT_GT(s.radius, 0);
        double sum = 0, xx = 0, yy = 0, xy = 0;
        for (int x = -s.radius; x <= s.radius; ++x)
            for (int y = -s.radius; y <= s.radius; ++y) {
                const double w = s.at(x, y);
                EXPECT_GE(w, 0);
                EXPECT_EQ(w, s.at(-x, -y));
                sum += w, xx += w * x * x, yy += w * y * y, xy += w * x * y;
            }
        EXPECT_NEAR(sum, 1, 1e-14);
        // A disc M u, |u| < 1, evenly bright, has the second moments M M^T / 4.
        const auto& m = kernel.disc_from_unit;
        EXPECT_NEAR(xx, (m[0].x * m[0].x + m[1].x * m[1].x) / 4, 1e-3 * xx + 3e-5);
        EXPECT_NEAR(yy, (m[0].y * m[0].y + m[1].y * m[1].y) / 4, 1e-3 * yy + 3e-5);
        // A lean needs diagonal neighbours: discs near a voxel's size show it in part.
        EXPECT_NEAR(xy, (m[0].x * m[0].y + m[1].x * m[1].y) / 4, 0.06 + 0.01 * std::fabs(xy));
    }
    EXPECT_EQ(discStencil(ellipse(0.019, 0.01, 0)).radius, 0);
    EXPECT_THROW(discStencil(ellipse(65, 1, 0)), Error);
}

TEST(DiscStencil, LargeDiscsAreEvenlyBright) {
    const double a = 12.3;
    const DiscStencil s = discStencil(ellipse(a, a, 0));
    for (int x = -8; x <= 8; ++x)
        for (int y = -8; y <= 8; ++y) EXPECT_NEAR(s.at(x, y) * M_PI * a * a, 1, 0.15) << x << ' ' << y;
    EXPECT_EQ(s.at(13, 13), 0);
}

TEST(BlurLayers, EachLayerGetsItsOwnKernelInEveryChannel) {
    LightField field(everything({0, 0, 3}, {31, 31, 20}), {1, true});
    const auto kernel = [](int k) { return k == 9 ? ellipse(0.001, 0.001, 0) : ellipse(0.1 * k, 0.05 * k, 0.1 * k); };
    for (int k = 3; k <= 20; ++k) {
        const glm::ivec3 v(14, 17, k);
        float* leaf = field.makeDense(field.needed().slotOf(v));
        for (int c = 0; c < 4; ++c) leaf[c * 512 + NeededVoxels::offsetInLeaf(v)] = float(c + k);
    }
    EXPECT_NEAR(blurLayers(field, kernel), 0, 1e-6);
    for (int k = 3; k <= 20; ++k) {
        const DiscStencil s = discStencil(kernel(k));
        for (int x = 0; x < 32; ++x)
            for (int y = 0; y < 32; ++y)
                for (int c = 0; c < 4; ++c) {
                    const double expected = k == 9 ? (x == 14 && y == 17 ? 1 : 0) : s.at(x - 14, y - 17);
                    ASSERT_NEAR(field.value({x, y, k}, c), expected * (c + k), 1e-5) << x << ' ' << y << ' ' << k;
                }
    }
}

TEST(BlurLayers, AFoldSeenThroughADiscConverges) {
    // E = x^(-1/2) right of a fold, as voxel means; truth: its convolution with the disc's profile, as voxel means.
    const double a = 0.08;  // the disc's radius in units of the domain, which is [-1/2, 1/2]
    const auto cumulative = [](double x) { return x > 0 ? 2 * std::sqrt(x) : 0.0; };
    std::vector<double> error;
    for (const int n : {64, 128, 256}) {
        const double h = 1.0 / n;
        LightField field(everything({0, 0, 0}, {n - 1, n - 1, 7}), {1, false});
        for (int slot = 0; slot < field.leafCount(); ++slot) {
            float* leaf = field.makeDense(slot);
            for (int i = 0; i < 512; ++i) {
                const double x = (field.needed().leafOrigin(slot).x + (i >> 6)) * h - 0.5;
                leaf[i] = static_cast<float>((cumulative(x + h) - cumulative(x)) / h);
            }
        }
        blurLayers(field, [&](int) { return ellipse(a / h, a / h, 0); });
        double sum = 0, total = 0;
        for (int i = n / 4; i < 3 * n / 4; ++i) {
            double truth = 0;
            constexpr int kSteps = 4000;
            for (int q = 0; q < kSteps; ++q) {
                const double u = -1 + (q + 0.5) * 2 / kSteps, weight = 2 / M_PI * std::sqrt(1 - u * u) * 2 / kSteps;
                const double x = i * h - 0.5 - a * u;
                truth += weight * (cumulative(x + h) - cumulative(x)) / h;
            }
            sum += std::fabs(double(field.value({i, n / 2, 4}, 0)) - truth);
            total += truth;
        }
        error.push_back(sum / total);
    }
    EXPECT_LT(error[2], 0.002);
    EXPECT_GT(std::log2(error[0] / error[1]), 1.0);
    EXPECT_GT(std::log2(error[1] / error[2]), 1.0);
}

TEST(BlurLayers, BordersAreDarkOrAlike) {
    const auto needed = everything({2, 3, 0}, {28, 30, 9});
    for (const BeyondNeeded beyond : {BeyondNeeded::Dark, BeyondNeeded::Alike}) {
        LightField field(needed, {1, true});
        for (int slot = 0; slot < field.leafCount(); ++slot) field.setConstant(slot, std::array<float, 4>{2, 0, 0, -2});
        const double change = blurLayers(
            field, [](int) { return ellipse(1.7, 1.7, 0); }, beyond);
        const double border = double(field.value({2, 3, 4}, 0)), middle = double(field.value({15, 15, 4}, 3));
        EXPECT_NEAR(middle, -2, 1e-6);
        if (beyond == BeyondNeeded::Dark) {
            EXPECT_LT(border, 1.2);
            // A disc of radius r loses 2 r / (3 pi) of a voxel's width of light on either side of a straight border: 4
            // sides.
            EXPECT_NEAR(change, -(2 * 1.7 / (3 * M_PI)) * (2.0 / 27 + 2.0 / 28), 0.006);
        } else {
            EXPECT_NEAR(border, 2, 1e-6);
            EXPECT_NEAR(change, 0, 1e-6);
        }
        EXPECT_EQ(field.value({1, 3, 4}, 0), 0);
    }
}

TEST(BlurLayers, SparseEqualsDenseAndThreadsChangeNothing) {
    const auto needed = everything(glm::ivec3(0), glm::ivec3(47, 39, 15));
    const auto kernel = [](int k) { return ellipse(2.3 + 0.1 * k, 9.4, 0.3); };
    std::vector<LightField> fields;
    for (const int variant : {0, 1, 2}) {
        setThreadCount(variant == 2 ? 2 : 1);
        LightField& field = fields.emplace_back(needed, FieldChannels{1, true});
        for (int slot = 0; slot < field.leafCount(); ++slot) {
            const bool lit = slot % 5 == 0, even = slot % 7 == 0;
            if (!lit && !even && variant != 0) continue;
            if (even && variant != 0) {
                field.setConstant(slot, std::array<float, 4>{1, 0, 0, -1});
                continue;
            }
            float* leaf = field.makeDense(slot);
            for (int i = 0; i < 4 * 512; ++i)
                leaf[i] = even ? (i < 512 ? 1.0f : i < 3 * 512 ? 0.0f : -1.0f) : lit ? float(i % 37) : 0.0f;
        }
        blurLayers(field, kernel);
    }
    setThreadCount(0);
    for (int x = 0; x < 48; ++x)
        for (int y = 0; y < 40; ++y)
            for (int z = 0; z < 16; ++z)
                for (int c = 0; c < 4; ++c) {
                    ASSERT_EQ(fields[0].value({x, y, z}, c), fields[1].value({x, y, z}, c));
                    ASSERT_EQ(fields[1].value({x, y, z}, c), fields[2].value({x, y, z}, c));
                }
}

}  // namespace
}  // namespace photic
