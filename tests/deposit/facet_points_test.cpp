// SPDX-License-Identifier: Apache-2.0
// At how many points the layers of light are evaluated that facets throw.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/vec2.hpp>
#include <numbers>
#include <random>

#include "bake/deposit/voxelise.h"

namespace photic {
namespace {

// Adds a block of one tube that is a half plane of even light to a box about (16, 16): it ends at the line through the
// middle in the direction of `edge`, and nowhere else near.
void addHalfPlane(TubeSet& set, const glm::dvec2& edge, const glm::dvec2& slope, bool faceted) {
    TubeBlock block;
    block.topology = BlockTopology::fromTriangles(3, {{{0, 1, 2}}});
    block.first_corner = static_cast<std::uint32_t>(set.corners.size());
    block.first_tube = static_cast<std::uint32_t>(set.tubes.size());
    block.faceted = faceted;
    set.blocks.push_back(block);
    const glm::dvec2 across(-edge.y, edge.x);
    for (const glm::dvec2& p : {-200.0 * edge, 200.0 * edge, 300.0 * across})
        set.corners.push_back({16 + p.x, 16 + p.y, 7.5, slope.x, slope.y, -1e30});
    TubeConstants tube{};
    tube.power[0] = 0.5f * 400 * 300, tube.length = 1, tube.travel[2] = -1;
    set.tubes.push_back(tube);
    set.addSlope(slope.x, slope.y, tube.power[0]);
}

LightField laid(const TubeSet& set, int quadrature) {
    GridFrame frame;
    frame.min = {0, 0, 0}, frame.max = {31, 31, 7};
    LightField field(std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), {1, false});
    VoxeliseOptions options;
    options.has_edges = true, options.quadrature = quadrature;
    DepositTotals totals;
    Monitor monitor;
    voxelise(set, field, options, totals, monitor);
    EXPECT_NEAR(field.sum(0) / totals.expected, 1, 1e-6);
    return field;
}

glm::dvec2 anyDirection(std::mt19937& random) {
    const double turn = std::uniform_real_distribution<>(0, 2 * std::numbers::pi)(random);
    return {std::cos(turn), std::sin(turn)};
}

TEST(FacetPoints, EdgesOfLightAreToldWithinWhatIsSaid) {
    std::mt19937 random(7);
    for (const double slope : {0.08, 0.25, 0.6, 1.1, 1.5}) {
        double squares = 0, passed = 0;
        for (int i = 0; i < 40; ++i) {
            TubeSet set;
            const glm::dvec2 edge = anyDirection(random);
            addHalfPlane(set, edge, slope * anyDirection(random), true);
            const LightField told = laid(set, 0), truth = laid(set, 12);
            for (int x = 0; x <= 31; ++x)
                for (int y = 0; y <= 31; ++y)
                    for (int z = 0; z <= 7; ++z) {
                        const double light = truth.value({x, y, z}, 0);
                        if (light < 1e-5 || light > 1 - 1e-5) continue;
                        squares += std::pow(told.value({x, y, z}, 0) - light, 2), ++passed;
                    }
        }
        ASSERT_GT(passed, 1000);
        EXPECT_LT(std::sqrt(squares / passed), 6e-4) << "slope " << slope;
    }
}

TEST(FacetPoints, AreTheBlocksOwn) {
    TubeSet set;
    addHalfPlane(set, {1, 0}, {0.05, 0}, true);
    addHalfPlane(set, {1, 0}, {0, 1.4}, true);
    addHalfPlane(set, {1, 0}, {0, 2.0}, true);
    addHalfPlane(set, {1, 0}, {0.05, 0}, false);
    EXPECT_EQ(pointsOfBlocks(set, true), (std::vector<int>{1, 8, 12, pointsAcrossLayer(set, true)}));
    EXPECT_EQ(pointsAcrossLayer(set, true), 4);
    // However many they are, all light is laid.
    const LightField four = laid(set, 4), own = laid(set, 0);
    EXPECT_NEAR(four.sum(0) / own.sum(0), 1, 1e-5);
}

// What a point misplaces counts by the light that is there: faint light is laid at two points instead of four.
TEST(PointsOfBlocks, AreFewerWhereTheBlocksLightIsFaint) {
    TubeSet set;
    for (const float share : {1.0f, 0.5f, 0.05f, 1e-4f}) {
        addHalfPlane(set, {1, 0}, {0, 0.6}, false);
        set.blocks.back().share = share;
    }
    EXPECT_EQ(pointsOfBlocks(set, true), (std::vector<int>{4, 4, 2, 2}));
    // Where one does for all of the light it does for some of it.
    EXPECT_EQ(pointsOfBlocks(set, false), (std::vector<int>{1, 1, 1, 1}));
}

}  // namespace
}  // namespace photic
