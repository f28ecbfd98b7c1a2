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
    double error[2];
    for (int k = 0; k < 2; ++k) {
        const Bake b =
            bake(sceneOf("min = [-0.4, -0.4, -1.4]\nmax = [0.4, 0.4, 0]\nresolution = " + std::to_string(28 << k),
                         kDown, medium(fmt::format("{{ kind = \"selfoc\", n0 = {}, g = {} }}", kN0, kG))));
        EXPECT_LT(b.report().power.imbalance(), 1e-9);
        const GridFrame& frame = b.field().frame();
        const double h = frame.worldFromIndex()[0][0];
        const glm::ivec3 size = frame.size();
        const auto columnOf = [&](double x) { return std::lround((x - frame.worldFromIndex(glm::dvec3(0)).x) / h); };
        double difference = 0, sum = 0, power = 0, wanted = 0;
        for (int z = frame.min.z; z <= frame.max.z; ++z) {
            const double middle = frame.worldFromIndex(glm::dvec3(0, 0, z)).z;
            if (middle > kTop || middle < kBottom) continue;
            std::vector<double> truth(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y), 0.0);
            for (int i = 0; i < kStarts * kStarts; ++i) {
                const double x0 = kHalf * (2.0 * (i % kStarts + 0.5) / kStarts - 1),
                             y0 = kHalf * (2.0 * (i / kStarts + 0.5) / kStarts - 1),
                             root = std::sqrt(1 - kG * kG * (x0 * x0 + y0 * y0));
                for (int p = 0; p < kPlanes; ++p) {
                    const double depth = -middle + h * ((p + 0.5) / kPlanes - 0.5), along = std::cos(kG * depth / root),
                                 x = x0 * along, y = y0 * along;
                    const auto u = columnOf(x) - frame.min.x, v = columnOf(y) - frame.min.y;
                    if (u < 0 || v < 0 || u >= size.x || v >= size.y) continue;
                    // Fluence: over the cosine of the ray, n0 root / n.
                    truth[static_cast<std::size_t>(v) * static_cast<std::size_t>(size.x) +
                          static_cast<std::size_t>(u)] += std::sqrt(1 - kG * kG * (x * x + y * y)) / root;
                }
            }
            const double a_start = 4 * kHalf * kHalf / (double(kStarts) * kStarts) / (kPlanes * h * h);
            for (int y = frame.min.y; y <= frame.max.y; ++y)
                for (int x = frame.min.x; x <= frame.max.x; ++x) {
                    const glm::dvec3 place = frame.worldFromIndex(glm::dvec3(x, y, z));
                    if (std::hypot(place.x, place.y) > kReach) continue;
                    const double mean =
                        a_start * truth[static_cast<std::size_t>(y - frame.min.y) * static_cast<std::size_t>(size.x) +
                                        static_cast<std::size_t>(x - frame.min.x)];
                    difference += std::fabs(b.fluence({x, y, z}) - mean), sum += mean;
                    power += b.fluence({x, y, z}), wanted += mean;
                }
        }
        error[k] = difference / sum;
        EXPECT_NEAR(power / wanted, 1, 0.01);
    }
    fmt::print("  through the focus, 28 and 56 voxels: {:.2f} and {:.2f} % on average\n", 100 * error[0],
               100 * error[1]);
    EXPECT_LT(error[1], 0.05);
    EXPECT_GT(std::log2(error[0] / error[1]), 0.5);
}

}  // namespace
}  // namespace photic
