// SPDX-License-Identifier: Apache-2.0
#include "bake/field/coarsen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/field/resample.h"

namespace photic {
namespace {

template <class Light>
LightField fieldOf(const GridFrame& frame, Light light, int floor_index) {
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y) needed.addColumn(x, y, floor_index, frame.max.z);
    needed.finish();
    LightField field(std::make_shared<const NeededVoxels>(std::move(needed)), {1, true});
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        float* leaf = field.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = field.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (!field.needed().contains(v)) continue;
            leaf[i] = static_cast<float>(light(frame.worldFromIndex(v)));
            leaf[3 * 512 + i] = -leaf[i];
        }
    }
    return field;
}

GridFrame box(int n) {
    GridFrame frame;
    frame.setWorldFromIndex(glm::dmat3(1, 0, 0, 0, 1, 0, 0.3, 0, 1) / double(n));  // leaning: the map must not matter
    frame.origin_world = {0.25 / n, 0.5 / n, -0.5 / n};
    frame.min = glm::ivec3(-n / 2 - 3, -n / 2, -n / 2), frame.max = glm::ivec3(n / 2 + 1, n / 2 - 1, n / 2 - 1);
    return frame;
}

// Root mean square of look-ups in `coarse` at the needed voxels' centres, against what they hold.
double error(const LightField& fine, const LightField& coarse, int factor) {
    double sum = 0;
    std::int64_t count = 0;
    const GridFrame& f = fine.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z) {
                const glm::ivec3 v(x, y, z);
                if (!fine.needed().contains(v)) continue;
                const double e = double(sampleTrilinear(coarse, (glm::dvec3(v) + 0.5) / double(factor) - 0.5)[0]) -
                                 double(fine.value(v, 0));
                sum += e * e, ++count;
            }
    return std::sqrt(sum / static_cast<double>(count));
}

// The plain alternative: means over the needed voxels of each cell.
LightField means(const LightField& fine, const LightField& like, int factor) {
    LightField out(like.neededPtr(), like.channels());
    for (int slot = 0; slot < out.leafCount(); ++slot) {
        float* leaf = out.makeDense(slot);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = out.needed().leafOrigin(slot) + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            float sum = 0;
            int count = 0;
            for (int n = 0; n < factor * factor * factor; ++n) {
                const glm::ivec3 w = v * factor + glm::ivec3(n % factor, n / factor % factor, n / factor / factor);
                if (fine.needed().contains(w)) sum += fine.value(w, 0), ++count;
            }
            leaf[i] = count > 0 ? sum / static_cast<float>(count) : 0.0f;
        }
    }
    return out;
}

TEST(Coarsen, LinearLightIsKeptToItsVeryBorders) {
    const LightField fine = fieldOf(
        box(32), [](const glm::dvec3& p) { return 5 + p.x - 2 * p.y + 3 * p.z; }, -11);
    for (const int factor : {2, 4}) {
        const LightField coarse = coarsened(fine, factor, Monitor{});
        EXPECT_LT(error(fine, coarse, factor), 2e-3) << factor;
        // In its place in the world.
        const glm::dvec3 p = coarse.frame().worldFromIndex({0, 0, 0});
        EXPECT_NEAR(coarse.irradiance({0, 0, 0}), 5 + p.x - 2 * p.y + 3 * p.z, 2e-3);
        EXPECT_NEAR(coarse.flux({0, 0, 0}).z, -coarse.irradiance({0, 0, 0}), 2e-3);
    }
}

TEST(Coarsen, ErrorsFallWithTheSquareAndAreBelowThoseOfMeans) {
    const auto wave = [](const glm::dvec3& p) { return 2 + std::sin(9 * p.x) * std::cos(7 * p.y + 5 * p.z); };
    std::vector<double> errors;
    for (const int n : {16, 32, 64}) {
        const LightField fine = fieldOf(box(n), wave, -n / 2);
        const LightField coarse = coarsened(fine, 2, Monitor{});
        errors.push_back(error(fine, coarse, 2));
        EXPECT_LT(errors.back(), 0.5 * error(fine, means(fine, coarse, 2), 2));
    }
    EXPECT_GT(std::log2(errors[0] / errors[1]), 1.7);
    EXPECT_GT(std::log2(errors[1] / errors[2]), 1.7);
}

TEST(Coarsen, SpikesStayLawful) {
    const LightField fine = fieldOf(
        box(16), [](const glm::dvec3& p) { return std::fabs(p.x) < 0.04 ? 50.0 : 0.0; }, -8);
    const LightField coarse = coarsened(fine, 2, Monitor{});
    const GridFrame& f = coarse.frame();
    double most = 0;
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z) {
                ASSERT_GE(coarse.irradiance({x, y, z}), 0);
                ASSERT_LE(glm::length(coarse.flux({x, y, z})), coarse.irradiance({x, y, z}) * (1 + 1e-5));
                most = std::max(most, coarse.irradiance({x, y, z}));
            }
    EXPECT_GT(most, 25);
}

}  // namespace
}  // namespace photic
