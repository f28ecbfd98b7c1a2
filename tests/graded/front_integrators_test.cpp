// SPDX-License-Identifier: Apache-2.0
// A front's rays by the slower integrators, against rays that are followed one by one in the parameter s.
#include "bake/graded/front_integrators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "bake/graded/index_slices.h"
#include "bake/graded/ray_integrator.h"

namespace photic {
namespace {

constexpr int kLow = -4, kHigh = 36;  // voxels, which are 1/32 m
constexpr double kVoxel = 1 / 32.0;
constexpr std::size_t kLanes = 16;
enum Row { kU, kV, kSlopeU, kSlopeV, kLit, kMomentum, kLeft };

SplineIndex sampled(const GradedIndex& index) {
    SplineIndex::Nodes nodes;
    nodes.spacing = glm::dvec3(kVoxel);
    nodes.first_world = glm::dvec3(kLow) * kVoxel;
    nodes.count = glm::ivec3(kHigh - kLow + 1);
    return {nodes, [&](const glm::dvec3& p) { return index.at(p).half_square; }, SplineFit::Through};
}

struct Marched {
    FrontRays rays;
    double miss = 0;  ///< [voxels], largest, in the last plane
    double late = 0;  ///< optical path [voxels], likewise
};

/// 21 rays through 32 layers, and how far they are from the truth there.
Marched march(FrontIntegrator integrator, int steps, int axis, int sense) {
    const auto eye = makeFishEye({0.4, 0.45, 0.5}, 1.6, 1.3, {});
    const SplineIndex spline = sampled(*eye);
    const SplineGradedIndex index(spline);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    Marched out;
    std::vector<GradedRay> truth;
    const double start = sense > 0 ? -0.5 : 31.5, last = sense > 0 ? 31 : 0;
    out.rays.resize(21, false, true);
    for (std::size_t i = 0; i < 21; ++i) {
        glm::dvec3 voxel, way;
        voxel[u] = 3.25 + 1.25 * double(i), voxel[v] = 25.5 - 1.0 * double(i), voxel[axis] = start;
        way[u] = 0.1 * std::sin(1.0 * double(i)), way[v] = 0.15, way[axis] = sense;
        GradedRay ray = startRay(index, voxel * kVoxel, glm::normalize(way));
        out.rays.u[i] = float(voxel[u]), out.rays.v[i] = float(voxel[v]), out.rays.w[i] = float(start);
        out.rays.pu[i] = float(ray.momentum[u]), out.rays.pv[i] = float(ray.momentum[v]);
        out.rays.pw[i] = float(sense * ray.momentum[axis]);
        const double plane = last * kVoxel;
        while (std::fabs(plane - ray.position[axis]) > 1e-12)
            stepRungeKutta(index, std::clamp((plane - ray.position[axis]) / ray.momentum[axis], -0.002, 0.002), ray);
        truth.push_back(ray);
    }
    IndexSlices slices;
    FrontMarch at;
    for (float& size : at.voxel) size = float(kVoxel);
    at.slices = &slices, at.layers = 16, at.sense = sense, at.least_lit = 0.05f;
    at.node_w = kLow;
    std::vector<float> rows(21 * (kLeft + 2) * kLanes);
    for (const int chunk : {0, 1}) {
        at.first_w = sense > 0 ? 16 * chunk : 16 - 16 * chunk;
        if (integrator == FrontIntegrator::Planes) {
            collapseIndex(spline, {axis, glm::ivec3(kLow)}, at.first_w, 16, sense, steps, slices);
            frontKernel()(at, out.rays, 0, out.rays.u.size(), rows.data(), (kLeft + 2) * kLanes);
        } else {
            marchFrontBy(integrator, {&spline, {u, v, axis}, glm::ivec3(kLow), steps}, at, out.rays, 0, 21, rows.data(),
                         (kLeft + 2) * kLanes);
        }
    }
    for (std::size_t i = 0; i < 21; ++i) {
        const glm::dvec3 voxel = truth[i].position / kVoxel;
        EXPECT_LT(out.rays.stopped[i], 0);
        EXPECT_NEAR(double(out.rays.w[i]), last, 1e-4);
        out.miss = std::max(out.miss, std::hypot(double(out.rays.u[i]) - voxel[u], double(out.rays.v[i]) - voxel[v]));
        out.late = std::max(out.late, std::fabs(double(out.rays.time[i]) - truth[i].optical_path) / kVoxel);
        const auto* row = &rows[i * (kLeft + 2) * kLanes];
        const std::size_t lane = sense > 0 ? 15 : 0;
        EXPECT_NEAR(double(row[kU * kLanes + lane]), double(out.rays.u[i]), 1e-4);
        EXPECT_NEAR(double(row[kSlopeV * kLanes + lane]), truth[i].momentum[v] / truth[i].momentum[axis], 1e-3);
        EXPECT_EQ(row[kLit * kLanes + lane], 1.0f);
    }
    return out;
}

// Single precision holds a place to 4e-6 voxels, and is what rays are kept in between slabs.
TEST(FrontIntegrators, GoWhereTheRaysGo) {
    for (const int axis : {0, 1, 2})
        for (const int sense : {1, -1})
            for (const auto& [integrator, steps] : {std::pair{FrontIntegrator::RungeKutta, 1},
                                                    {FrontIntegrator::Yoshida, 2},
                                                    {FrontIntegrator::Controlled, 1}}) {
                const Marched far = march(integrator, steps, axis, sense);
                EXPECT_LT(far.miss, 1e-4) << int(integrator) << " along " << axis;
                EXPECT_LT(far.late, 1e-4) << int(integrator) << " along " << axis;
            }
}

TEST(FrontIntegrators, TheDefaultComesNearerWithShorterSteps) {
    // Of second order until single precision, in which the kernel keeps slopes and momenta, is what is left.
    double miss[3];
    for (int k = 0; k < 3; ++k) miss[k] = march(FrontIntegrator::Planes, 1 << k, 2, 1).miss;
    EXPECT_LT(miss[0], 6e-3);
    EXPECT_LT(miss[1], 0.8 * miss[0]);
    EXPECT_LT(miss[2], 0.8 * miss[1]);
}

TEST(FrontIntegrators, ARayThatTurnsAwayStops) {
    const auto slope = makeLinearSquare(glm::dvec3(0.5), 1.5, {0, 0, -3}, {});
    const SplineIndex spline = sampled(*slope);
    FrontRays rays;
    rays.resize(1, false);
    rays.u[0] = 8, rays.v[0] = 8, rays.w[0] = -0.5f;
    const double n = std::sqrt(2 * slope->halfSquareAt({0.25, 0.25, -0.5 * kVoxel}));
    rays.pu[0] = float(n * 0.6), rays.pv[0] = 0, rays.pw[0] = float(n * 0.8);
    IndexSlices slices;
    FrontMarch at;
    at.slices = &slices, at.layers = 16;
    for (float& size : at.voxel) size = float(kVoxel);
    std::vector<float> rows(kLanes * (kLeft + 1));
    for (at.first_w = 0; at.first_w < 32 && rays.stopped[0] < 0; at.first_w += 16)
        marchFrontBy(FrontIntegrator::RungeKutta, {&spline, {0, 1, 2}, glm::ivec3(kLow), 1}, at, rays, 0, 1,
                     rows.data(), rows.size());
    ASSERT_GE(rays.stopped[0], 0);
    // p_z^2 falls by 3 a metre from 0.64 n^2, and p_x stays: 60 degrees are passed where p_z^2 = p_x^2 / 3.
    const double turns = (0.64 - 0.12) * n * n / 3 / kVoxel - 0.5;
    EXPECT_NEAR(double(rays.w[0]), turns, 1);
}

}  // namespace
}  // namespace photic
