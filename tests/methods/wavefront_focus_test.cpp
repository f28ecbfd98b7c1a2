// SPDX-License-Identifier: Apache-2.0
// Voxel means through a focus, against rays in closed form: where irradiance itself has no bound, its means have.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

// n^2 = n0^2 (1 - g^2 r^2): a ray that comes in at (x, y) is at (x, y) cos(g depth / root), root = sqrt(1 - g^2 r0^2),
// so that the focus is drawn out along the axis, from depth pi / 2 g on towards the light.
TEST(WavefrontFocus, MeansThroughTheFocusOfASelfocRodConverge) {
    constexpr double kN0 = 1.5, kG = 1.4, kHalf = 0.4, kReach = 0.1, kTop = -0.85, kBottom = -1.25;
    constexpr int kStarts = 1000, kPlanes = 4;  // a side; a layer
    // Layers evaluated at one point, and at four, against means over voxels; and at one point against means over the
    // layers' middles, which is the error of the tubes alone; and how far those are from the former, which no light
    // that is evaluated there can be better than.
    double error[2], at_four[2], of_tubes[2], of_middles[2], unhalved[2];
    for (int k = 0; k < 2; ++k) {
        Scene scene = sceneOf("min = [-0.4, -0.4, -1.4]\nmax = [0.4, 0.4, 0]\nresolution = " + std::to_string(28 << k),
                              kDown, medium(fmt::format("{{ kind = \"selfoc\", n0 = {}, g = {} }}", kN0, kG)));
        const Bake b = bake(scene);
        EXPECT_LT(b.report().power.imbalance(), 1e-9);
        scene.bake.quadrature = 4;
        const Bake four = bake(scene);
        scene.bake.quadrature = 1, scene.bake.tolerance = 1e6;  // no tube is halved for its bend
        const Bake launched = bake(scene);
        const GridFrame& frame = b.field().frame();
        const double h = frame.worldFromIndex()[0][0];
        const glm::ivec3 size = frame.size();
        const auto columnOf = [&](double x) { return std::lround((x - frame.worldFromIndex(glm::dvec3(0)).x) / h); };
        double difference = 0, of_four = 0, beside_middle = 0, middle_beside = 0, of_launched = 0, sum = 0,
               sum_in_middles = 0, power = 0, wanted = 0;
        for (int z = frame.min.z; z <= frame.max.z; ++z) {
            const double middle = frame.worldFromIndex(glm::dvec3(0, 0, z)).z;
            if (middle > kTop || middle < kBottom) continue;
            const auto columns = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
            std::vector<double> truth(columns, 0.0), in_middle(columns, 0.0);
            for (int i = 0; i < kStarts * kStarts; ++i) {
                const double x0 = kHalf * (2.0 * (i % kStarts + 0.5) / kStarts - 1),
                             y0 = kHalf * (2.0 * (i / kStarts + 0.5) / kStarts - 1),
                             root = std::sqrt(1 - kG * kG * (x0 * x0 + y0 * y0));
                const auto addAt = [&](double depth, double share, std::vector<double>& to) {
                    const double along = std::cos(kG * depth / root), x = x0 * along, y = y0 * along;
                    const auto u = columnOf(x) - frame.min.x, v = columnOf(y) - frame.min.y;
                    if (u < 0 || v < 0 || u >= size.x || v >= size.y) return;
                    // Fluence: over the cosine of the ray, n0 root / n.
                    to[static_cast<std::size_t>(v) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(u)] +=
                        share * std::sqrt(1 - kG * kG * (x * x + y * y)) / root;
                };
                for (int p = 0; p < kPlanes; ++p)
                    addAt(-middle + h * ((p + 0.5) / kPlanes - 0.5), 1.0 / kPlanes, truth);
                addAt(-middle, 1, in_middle);
            }
            const double a_start = 4 * kHalf * kHalf / (double(kStarts) * kStarts) / (h * h);
            for (int y = frame.min.y; y <= frame.max.y; ++y)
                for (int x = frame.min.x; x <= frame.max.x; ++x) {
                    const glm::dvec3 place = frame.worldFromIndex(glm::dvec3(x, y, z));
                    if (std::hypot(place.x, place.y) > kReach) continue;
                    const auto column = static_cast<std::size_t>(y - frame.min.y) * static_cast<std::size_t>(size.x) +
                                        static_cast<std::size_t>(x - frame.min.x);
                    const double mean = a_start * truth[column], there = a_start * in_middle[column];
                    difference += std::fabs(b.fluence({x, y, z}) - mean), sum += mean;
                    beside_middle += std::fabs(b.fluence({x, y, z}) - there), sum_in_middles += there;
                    middle_beside += std::fabs(there - mean);
                    of_four += std::fabs(four.fluence({x, y, z}) - mean);
                    of_launched += std::fabs(launched.fluence({x, y, z}) - mean);
                    power += b.fluence({x, y, z}), wanted += mean;
                }
        }
        error[k] = difference / sum, at_four[k] = of_four / sum;
        of_tubes[k] = beside_middle / sum_in_middles, of_middles[k] = middle_beside / sum;
        unhalved[k] = of_launched / sum;
        EXPECT_NEAR(power / wanted, 1, 0.01);
    }
    fmt::print(
        "  through the focus, 28 and 56 voxels: {:.2f} and {:.2f} % on average, at four points {:.2f} and {:.2f}; "
        "light "
        "in the layers' middles is {:.2f} and {:.2f} % from that of voxels, and tubes {:.2f} and {:.2f} % from it; "
        "without halving {:.2f} and {:.2f} %\n",
        100 * error[0], 100 * error[1], 100 * at_four[0], 100 * at_four[1], 100 * of_middles[0], 100 * of_middles[1],
        100 * of_tubes[0], 100 * of_tubes[1], 100 * unhalved[0], 100 * unhalved[1]);
    EXPECT_LT(error[0], 0.025);
    EXPECT_LT(error[1], 0.018);
    EXPECT_LT(at_four[1], 0.01);
    EXPECT_GT(std::log2(at_four[0] / at_four[1]), 0.5);
    // What one point a layer costs goes down more slowly, whatever the tubes are: that is what halving leaves.
    EXPECT_LT(std::log2(of_middles[0] / of_middles[1]), 0.5);
    for (int k = 0; k < 2; ++k) EXPECT_LT(of_tubes[k], of_middles[k]);
    EXPECT_LT(unhalved[1], 0.05);
    EXPECT_GT(std::log2(unhalved[0] / unhalved[1]), 0.5);
}

}  // namespace
}  // namespace photic
