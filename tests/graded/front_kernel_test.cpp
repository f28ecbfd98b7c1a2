// SPDX-License-Identifier: Apache-2.0
// A front's rays, many at a time and in single precision, against one at a time in double.
#include "bake/graded/front_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bake/graded/index_slices.h"
#include "bake/graded/ray_integrator.h"

namespace photic {
namespace {

constexpr int kLow = -12, kHigh = 40, kMargin = 3;  // voxels of the box, which are 1/32 m
constexpr double kVoxel = 1 / 32.0;
constexpr std::size_t kLanes = 16, kRows = 7;
enum Row { kU, kV, kSlopeU, kSlopeV, kLit, kMomentum, kLeft };

/// A spline as an index of its own.
class SplineOnly final : public GradedIndex {
public:
    explicit SplineOnly(const SplineIndex& spline) : spline_(spline) {}
    IndexSample at(const glm::dvec3& world) const override { return spline_.at(world); }
    bool contains(const glm::dvec3&) const override { return true; }
    std::optional<WorldBox> bounds() const override { return {}; }

private:
    const SplineIndex& spline_;
};

SplineIndex sampled(const GradedIndex& index, SplineFit fit = SplineFit::Auto) {
    SplineIndex::Nodes nodes;
    nodes.spacing = glm::dvec3(kVoxel);
    nodes.first_world = glm::dvec3(kLow - kMargin) * kVoxel;
    nodes.count = glm::ivec3(kHigh - kLow + 1 + 2 * kMargin);
    return {nodes, [&](const glm::dvec3& p) { return index.at(p).half_square; }, fit};
}

/// Some rays side by side, and what a march along an axis makes of them.
struct Bundle {
    int axis = 2, sense = 1, steps = 1;
    FrontRays rays;
    IndexSlices slices;
    FrontMedia media;
    std::vector<float> rows;

    int u() const { return (axis + 1) % 3; }
    int v() const { return (axis + 2) % 3; }
    void add(const glm::dvec3& voxel, const glm::dvec3& momentum, bool attenuated = false) {
        const std::size_t i = rays.size();
        rays.resize(i + 1, attenuated);
        rays.u[i] = float(voxel[u()]), rays.v[i] = float(voxel[v()]), rays.w[i] = float(voxel[axis]);
        rays.pu[i] = float(momentum[u()]), rays.pv[i] = float(momentum[v()]);
        rays.pw[i] = float(sense * momentum[axis]), rays.lit[i] = 0;
    }
    void march(const SplineIndex& spline, int first, int layers, int channels = 1) {
        collapseIndex(spline, {axis, glm::ivec3(kLow - kMargin)}, first, layers, sense, steps, slices);
        FrontMarch march;
        march.slices = &slices, march.media = &media;
        for (float& size : march.voxel) size = float(kVoxel);
        march.first_w = first, march.layers = layers, march.sense = sense, march.node_w = kLow - kMargin;
        march.least_lit = 0.05f, march.channels = channels;
        rows.assign(rays.size() * kRows * kLanes, -1.0f);
        frontKernel()(march, rays, 0, rays.u.size(), rows.data(), kRows * kLanes);
    }
    float row(std::size_t ray, Row which, int lane) const {
        return rows[(ray * kRows + which) * kLanes + static_cast<std::size_t>(lane)];
    }
};

TEST(FrontKernel, TakesTheStepsThatRaysTakeOneByOne) {
    const auto eye = makeFishEye({0.4, 0.45, 0.5}, 1.6, 1.3, {});
    const SplineIndex spline = sampled(*eye);
    EXPECT_EQ(spline.fit(), SplineFit::Through);
    const SplineOnly on_spline(spline);
    for (const int axis : {0, 1, 2})
        for (const int sense : {1, -1})
            for (const int steps : {1, 2}) {
                Bundle bundle{axis, sense, steps};
                std::vector<GradedRay> truth;
                const double start = sense > 0 ? -0.5 : 31.5;
                for (int i = 0; i < 21; ++i) {
                    glm::dvec3 voxel, way;
                    voxel[bundle.u()] = 3.3 + 1.2 * i, voxel[bundle.v()] = 25.1 - 0.9 * i, voxel[axis] = start;
                    way[bundle.u()] = 0.1 * std::sin(1.0 * i), way[bundle.v()] = 0.15, way[axis] = sense;
                    truth.push_back(startRay(on_spline, voxel * kVoxel, glm::normalize(way)));
                    bundle.add(voxel, truth.back().momentum);
                }
                for (const int chunk : {0, 1}) {
                    const int first = sense > 0 ? 16 * chunk : 16 - 16 * chunk;
                    bundle.march(spline, first, 16);
                    for (int layer = 0; layer < 16; ++layer) {
                        const int lane = sense > 0 ? layer : 15 - layer;
                        for (std::size_t i = 0; i < truth.size(); ++i) {
                            GradedRay& ray = truth[i];
                            const double way = (first + lane) * kVoxel - ray.position[axis];
                            for (int s = 0; s < steps; ++s) {
                                // The first step to the first layer is half as long: the kernel takes it in one.
                                if (chunk == 0 && layer == 0 && steps == 2 && s == 0) continue;
                                const double step = chunk == 0 && layer == 0 ? way : way / steps;
                                ASSERT_TRUE(stepBetweenPlanes(on_spline, axis, step, ray));
                            }
                            const glm::dvec3 voxel = ray.position / kVoxel;
                            EXPECT_NEAR(double(bundle.row(i, kU, lane)), voxel[bundle.u()], 4e-3);
                            EXPECT_NEAR(double(bundle.row(i, kV, lane)), voxel[bundle.v()], 4e-3);
                            EXPECT_NEAR(double(bundle.row(i, kSlopeU, lane)),
                                        ray.momentum[bundle.u()] / ray.momentum[axis], 5e-4);
                            EXPECT_NEAR(double(bundle.row(i, kMomentum, lane)), glm::length(ray.momentum), 5e-4);
                            EXPECT_EQ(bundle.row(i, kLeft, lane), 1.0f);
                        }
                    }
                }
                for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT(bundle.rays.stopped[i], 0);
            }
}

TEST(FrontKernel, ARayThatStartsOnTheWayWaitsForItsLayer) {
    const auto air = makeLinearSquare(glm::dvec3(0), 1, glm::dvec3(0), {});
    const SplineIndex spline = sampled(*air);
    Bundle bundle{2, 1};
    bundle.add({10, 12, 5.25}, glm::normalize(glm::dvec3(0.5, -0.25, 1)));
    bundle.march(spline, 0, 16);
    for (int lane = 0; lane < 16; ++lane) {  // before its start it is where it would come from
        EXPECT_NEAR(bundle.row(0, kU, lane), 10 + 0.5f * (float(lane) - 5.25f), 1e-4f);
        EXPECT_NEAR(bundle.row(0, kV, lane), 12 - 0.25f * (float(lane) - 5.25f), 1e-4f);
        EXPECT_EQ(bundle.row(0, kLit, lane), 0.0f);
    }
    EXPECT_EQ(bundle.rays.w[0], 15.0f);
}

TEST(FrontKernel, StopsARayWhereItTurnsAwayAndLeavesItThere) {
    // n^2 falls by 4 a metre, an eighth a voxel: a ray that goes up at 39 degrees is level some 24 voxels on.
    const auto slope = makeLinearSquare({0, 0, 10.3 * kVoxel}, 2.5, {0, 0, -4}, {});
    const SplineIndex spline = sampled(*slope);
    Bundle bundle{2, 1};
    const double n = slope->indexAt({0, 0, -0.5 * kVoxel});
    bundle.add({5, 5, -0.5}, n * glm::normalize(glm::dvec3(1, 0, 0.8)));
    bundle.add({5, 5, -0.5}, n * glm::dvec3(0, 0, 1));
    bundle.march(spline, 0, 16);
    // p_z^2 = p_z0^2 - 4 z; it passes 60 degrees where p_z^2 = p_x^2 / 3.
    const double px2 = n * n / 1.64, pz2 = px2 * 0.64, layers = (pz2 - px2 / 3) / 4 / kVoxel;
    EXPECT_NEAR(bundle.rays.stopped[0], -0.5 + layers, 1.01);
    const int lane = bundle.rays.stopped[0];
    ASSERT_GT(lane, 0);
    EXPECT_EQ(bundle.rays.w[0], float(lane - 1));
    EXPECT_EQ(bundle.rays.stopped[1], -1);
    const float u = bundle.rays.u[0];
    bundle.march(spline, 16, 16);
    EXPECT_EQ(bundle.rays.u[0], u);
    EXPECT_EQ(bundle.rays.stopped[0], lane);
    EXPECT_EQ(bundle.rays.stopped[1], -1);
}

TEST(FrontKernel, TellsWhoHasBeenInAMediumAndWhatItTook) {
    const WorldBox box{glm::dvec3(-0.1, -0.1, 4.5 * kVoxel), glm::dvec3(9.5 * kVoxel, 2, 8.5 * kVoxel)};
    const auto block = makeLinearSquare(glm::dvec3(0), 1.3, glm::dvec3(0), box);
    const SplineIndex spline = sampled(*block);
    EXPECT_EQ(spline.fit(), SplineFit::Plain);
    const glm::ivec3 count = spline.nodes().count;
    std::vector<std::uint8_t> nodes;
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                nodes.push_back(block->contains(glm::dvec3(kLow - kMargin + glm::ivec3(x, y, z)) * kVoxel) ? 1 : 0);
    Bundle bundle{2, -1};
    bundle.media.of_node = nodes.data();
    bundle.media.stride_u = 1, bundle.media.stride_v = static_cast<std::size_t>(count.x);
    bundle.media.stride_w = static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y);
    bundle.media.extinction[1][0] = 3;
    for (const double x : {3.0, 20.0}) bundle.add({x, 5, 15.5}, {0, 0, -1}, true);
    bundle.march(spline, 0, 16);
    EXPECT_EQ(bundle.row(0, kLit, 12), 0.0f);
    EXPECT_EQ(bundle.row(0, kLit, 6), 1.0f);
    EXPECT_EQ(bundle.row(1, kLit, 0), 0.0f);
    // Four layers of the block; where its index is smoothed the step is still a voxel long.
    EXPECT_NEAR(bundle.row(0, kLeft, 0), std::exp(-3 * 4 * kVoxel), 0.02);
    EXPECT_EQ(bundle.row(1, kLeft, 0), 1.0f);
}

}  // namespace
}  // namespace photic
