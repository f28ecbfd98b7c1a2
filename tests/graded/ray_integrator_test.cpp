// SPDX-License-Identifier: Apache-2.0
// Rays through indices whose rays are known in closed form.
#include "bake/graded/ray_integrator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

namespace photic {
namespace {

constexpr double kPi = std::numbers::pi;

/// A Luneburg lens whose radius is 32 voxels of 1 m, lit along z.
constexpr double kRadius = 32;

/// Its formula without its rim, so that a step may begin or end on it.
class LensWithoutRim final : public GradedIndex {
public:
    IndexSample at(const glm::dvec3& world) const override {
        const glm::dvec3 r = world / kRadius;
        return {1 - 0.5 * glm::dot(r, r), r * (-1 / kRadius)};
    }
    bool contains(const glm::dvec3&) const override { return true; }
    std::optional<WorldBox> bounds() const override { return {}; }
};
const LensWithoutRim kLens;

/// Where a ray at x0 enters the lens.
GradedRay entering(double x0) { return {{x0, 0, -std::sqrt(kRadius * kRadius - x0 * x0)}, {0, 0, 1}, 0}; }

/// The ray after s: r(s) = r0 cos(s/R) + R p0 sin(s/R). It leaves at s = pi R / 2, in (0, 0, R).
GradedRay exactLuneburg(const GradedRay& start, double s) {
    const double c = std::cos(s / kRadius), q = std::sin(s / kRadius);
    const glm::dvec3& r0 = start.position;
    // T is the integral of n^2 = 2 - r^2 / R^2 = 2 - (r0^2 c^2 + R^2 q^2 + 2 R r0.p0 c q) / R^2 over s.
    const double turn = s / kRadius, squares = glm::dot(r0, r0) / (kRadius * kRadius);
    const double cosines = 0.5 * turn + 0.25 * std::sin(2 * turn), sines = turn - cosines;
    const double mixed = 2 * glm::dot(r0, start.momentum) / kRadius * 0.5 * q * q;
    return {r0 * c + kRadius * q * start.momentum, start.momentum * c - r0 * (q / kRadius),
            kRadius * (2 * turn - squares * cosines - sines - mixed)};
}

/// From the rim to the next plane, and plane by plane on to that of the focus.
GradedRay marched(double x0, double layer) {
    GradedRay ray = entering(x0);
    const double plane = layer * std::ceil(ray.position.z / layer + 1e-9);
    EXPECT_TRUE(stepBetweenPlanes(kLens, 2, plane - ray.position.z, ray));
    const int layers = static_cast<int>(std::lround((kRadius - plane) / layer));
    for (int i = 0; i < layers; ++i) EXPECT_TRUE(stepBetweenPlanes(kLens, 2, layer, ray));
    return ray;
}

/// How far the rays of an aperture pass by the focus [voxels].
double rmsMiss(double layer, double aperture) {
    double sum = 0;
    constexpr int kRays = 61;
    for (int i = 0; i < kRays; ++i) {
        const GradedRay ray = marched(aperture * kRadius * (2.0 * i / (kRays - 1) - 1), layer);
        const double miss = ray.position.x * ray.momentum.z / glm::length(ray.momentum);
        sum += miss * miss / kRays;
    }
    return std::sqrt(sum);
}

TEST(PlaneStep, FocusesALuneburgLens) {
    const double half = rmsMiss(0.5, 0.9), whole = rmsMiss(1, 0.9);
    EXPECT_LT(half, 2e-3);
    EXPECT_LT(whole, 6e-3);
    EXPECT_NEAR(std::log2(whole / half), 2, 0.2);
    EXPECT_NEAR(std::log2(half / rmsMiss(0.25, 0.9)), 2, 0.2);
}

TEST(PlaneStep, LeavesALuneburgLensInTheRightDirectionAtTheRightTime) {
    // The focus is blind to errors at entry; the direction there is not: p = (-x0, 0, sqrt(R^2 - x0^2)) / R.
    // T counts from the rim: R (1 + pi / 2) from the plane before the lens, less what the ray comes in over.
    double direction[3], path[3];
    for (int k = 0; k < 3; ++k) {
        direction[k] = path[k] = 0;
        for (const double share : {0.2, 0.5, 0.8}) {
            const GradedRay ray = marched(share * kRadius, std::ldexp(1.0, -k));
            const double root = std::sqrt(1 - share * share);
            direction[k] = std::max(direction[k], glm::length(ray.momentum - glm::dvec3(-share, 0, root)));
            path[k] = std::max(path[k], std::fabs(ray.optical_path - kRadius * (kPi / 2 + root)));
        }
    }
    EXPECT_LT(direction[0], 1e-3);
    EXPECT_LT(path[0], 1.2e-2);  // of 82 voxels
    for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(std::log2(direction[k] / direction[k + 1]), 2, 0.3);
        EXPECT_NEAR(std::log2(path[k] / path[k + 1]), 2, 0.3);
    }
}

TEST(PlaneStep, TellsWhereARayTurns) {
    // n^2 falls by 1 a metre along z: a ray at 45 degrees turns 0.5 m up.
    const auto slope = makeLinearSquare(glm::dvec3(0), 1, {0, 0, -1}, {});
    const double p = std::sqrt(0.5);
    GradedRay ray{{0, 0, 0}, {p, 0, p}, 0};
    int steps = 0;
    while (stepBetweenPlanes(*slope, 2, 0.01, ray)) ++steps;
    EXPECT_NEAR(steps * 0.01, 0.5, 0.03);
    const GradedRay kept = ray;
    EXPECT_FALSE(stepBetweenPlanes(*slope, 2, 0.01, ray));
    EXPECT_EQ(ray.position, kept.position);
    EXPECT_FALSE(stepBetweenPlanes(*slope, 2, -0.01, ray));  // against the ray
}

using Step = void (*)(const GradedIndex&, double, GradedRay&);

/// Miss of the focus [voxels] after `steps` over pi R / 2.
double missAfter(Step step, int steps, double x0) {
    GradedRay ray = entering(x0);
    for (int i = 0; i < steps; ++i) step(kLens, kPi / 2 * kRadius / steps, ray);
    return glm::length(ray.position - glm::dvec3(0, 0, kRadius));
}

TEST(Integrators, RungeKuttaFindsTheFocusToAMillionthOfAVoxel) {
    double sum = 0;
    for (int i = 0; i <= 20; ++i) {
        const double miss = missAfter(stepRungeKutta, 100, 0.9 * kRadius * (i / 10.0 - 1));
        sum += miss * miss / 21;
    }
    EXPECT_LT(std::sqrt(sum), 1e-6);
}

TEST(Integrators, HaveTheOrdersThatTheyAreNamedFor) {
    // Inside a fish-eye, whose force is not linear, so that no order comes for free.
    const auto eye = makeFishEye(glm::dvec3(0), 2, 1, {});
    const auto run = [&](Step step, int steps) {
        GradedRay ray = startRay(*eye, {0.7, 0, -0.3}, glm::normalize(glm::dvec3(0.2, 0.5, 1)));
        for (int i = 0; i < steps; ++i) step(*eye, 0.5 / steps, ray);
        return ray;
    };
    const GradedRay truth = run(stepRungeKutta, 4096);
    const Step yoshida = [](const GradedIndex& index, double step, GradedRay& ray) { stepYoshida(index, step, ray); };
    for (const auto& [step, order] : {std::pair{Step(stepRungeKutta), 4.0}, {yoshida, 4.0}}) {
        double error[3];
        for (int k = 0; k < 3; ++k) {
            const GradedRay ray = run(step, 16 << k);
            error[k] = glm::length(ray.position - truth.position) + glm::length(ray.momentum - truth.momentum) +
                       std::fabs(ray.optical_path - truth.optical_path);
        }
        EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.35);
        EXPECT_NEAR(std::log2(error[1] / error[2]), order, 0.35);
    }
    // The paper's, over the same optical path.
    double error[3];
    for (int k = 0; k < 3; ++k) {
        GradedRay ray = startRay(*eye, {0.7, 0, -0.3}, glm::normalize(glm::dvec3(0.2, 0.5, 1)));
        for (int i = 0; i < 64 << k; ++i) stepEqualTime(*eye, truth.optical_path / (64 << k), ray);
        error[k] = glm::length(ray.position - truth.position);
    }
    EXPECT_NEAR(std::log2(error[0] / error[1]), 1, 0.15);
    EXPECT_NEAR(std::log2(error[1] / error[2]), 1, 0.15);
}

TEST(Integrators, AgreeWithTheLuneburgLensInAllThatARayHas) {
    for (const double share : {-0.9, 0.3, 0.7}) {
        const GradedRay start = entering(share * kRadius);
        GradedRay rk = start, yoshida = start;
        const double s = 0.8 * kRadius;
        for (int i = 0; i < 200; ++i) stepRungeKutta(kLens, s / 200, rk), stepYoshida(kLens, s / 200, yoshida);
        const GradedRay exact = exactLuneburg(start, s);
        EXPECT_LT(glm::length(rk.position - exact.position), 1e-7);
        EXPECT_LT(glm::length(rk.momentum - exact.momentum), 1e-9);
        EXPECT_NEAR(rk.optical_path, exact.optical_path, 1e-6);
        EXPECT_LT(glm::length(yoshida.position - exact.position), 2e-6);
        EXPECT_NEAR(yoshida.optical_path, exact.optical_path, 2e-6);
    }
}

TEST(Integrators, TheErrorControlledStepHoldsItsTolerance) {
    for (const double tolerance : {1e-4, 1e-7}) {
        GradedRay ray = entering(0.6 * kRadius);
        const int steps = stepControlled(kLens, kPi / 2 * kRadius, tolerance, ray);
        EXPECT_LT(glm::length(ray.position - glm::dvec3(0, 0, kRadius)), 2 * tolerance);
        EXPECT_LT(steps, tolerance < 1e-5 ? 40 : 12);
    }
}

TEST(Integrators, AFishEyeImagesAPointThroughItsCentre) {
    const double n0 = 1.8, a = 0.75;
    const auto eye = makeFishEye({0.1, -0.2, 0.05}, n0, a, {});
    const glm::dvec3 center(0.1, -0.2, 0.05), x(0.3, 0.1, 0.2);
    const glm::dvec3 image = -a * a / glm::dot(x, x) * x;
    const double path =
        n0 * a *
        std::asin(a * glm::distance(x, image) / std::sqrt((a * a + glm::dot(x, x)) * (a * a + glm::dot(image, image))));
    for (const glm::dvec3 towards : {glm::dvec3(1, 0, 0), {0.2, -0.7, 0.3}, {0, 0.3, -1}}) {
        GradedRay ray = startRay(*eye, center + x, glm::normalize(towards));
        double nearest = 1e9, at_path = 0;
        while (ray.optical_path < 0.6 * n0 * a * kPi) {
            stepRungeKutta(*eye, 1e-3, ray);
            const double miss = glm::distance(ray.position, center + image);
            if (miss < nearest) nearest = miss, at_path = ray.optical_path;
        }
        EXPECT_LT(nearest, 5e-4);  // half a step
        EXPECT_NEAR(at_path, path, 1e-3);
    }
}

TEST(Integrators, ASelfocRodCrossesItsAxisWhereItShould) {
    const double n0 = 1.6, g = 0.8;
    const auto rod = makeSelfocRod({.n0 = n0, .g = g});
    for (const double x0 : {0.05, 0.2, 0.4}) {
        GradedRay ray = startRay(*rod, {x0, 0, 0}, {0, 0, 1});
        GradedRay before = ray;
        while (ray.position.x > 0) before = ray, stepRungeKutta(*rod, 1e-3, ray);
        const double share = before.position.x / (before.position.x - ray.position.x);
        const double z = before.position.z + share * (ray.position.z - before.position.z);
        EXPECT_NEAR(z, kPi / (2 * g) * std::sqrt(1 - g * g * x0 * x0), 1e-6);
    }
}

TEST(GradedIndices, HaveTheGradientsOfTheirValues) {
    const WorldBox box{{-2, -2, -2}, {2, 2, 2}};
    const std::shared_ptr<const GradedIndex> indices[] = {
        makeLuneburgLens({0.1, 0, 0}, 1.5),
        makeFishEye({0, 0.2, 0}, 2, 1.1, 1.8),
        makeSelfocRod({.axis = glm::normalize(glm::dvec3(1, 2, 3)), .n0 = 1.5, .g = 0.4, .radius = 1.2, .length = 3}),
        makeLinearSquare({0, 0, 0}, 1.5, {0.1, -0.2, 0.3}, box),
        makeHotAir({.ground = -1, .height = 0.5, .drop = 0.01}, box),
        makeSaltLayers({.level = 0.1, .thickness = 0.4, .amplitude = 0.2, .wavelength = 2}, box)};
    for (const auto& index : indices)
        for (const glm::dvec3 p : {glm::dvec3(0.2, 0.3, -0.1), {-0.4, 0.1, 0.5}, {0.3, -0.6, 0.2}}) {
            ASSERT_TRUE(index->contains(p));
            const IndexSample here = index->at(p);
            for (int a = 0; a < 3; ++a) {
                glm::dvec3 step(0);
                step[a] = 1e-5;
                EXPECT_NEAR(here.gradient[a],
                            (index->at(p + step).half_square - index->at(p - step).half_square) / 2e-5, 1e-8);
            }
            EXPECT_EQ(index->at({5, 5, 5}).half_square, 0.5);
            EXPECT_FALSE(index->contains({5, 5, 5}));
            EXPECT_TRUE(index->bounds()->contains(p));
        }
}

}  // namespace
}  // namespace photic
