// SPDX-License-Identifier: Apache-2.0
// Each closed form against a brute force that knows only the map from parameter to place.
#include "tests/support/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

namespace photic::truth {
namespace {

/// Cell means of the density of X(u), u in [-range, range], by counting `rays` rays.
std::vector<double> countRays(const std::function<double(double)>& x_of_u, double range, double x0, double dx,
                              int cells, int rays) {
    std::vector<double> out(static_cast<std::size_t>(cells));
    const double du = 2 * range / rays;
    for (int i = 0; i < rays; ++i) {
        const double cell = std::floor((x_of_u(-range + (i + 0.5) * du) - x0) / dx);
        if (cell >= 0 && cell < cells) out[static_cast<std::size_t>(cell)] += du / dx;
    }
    return out;
}

TEST(PlaneTruth, FresnelIsThatOfTheTextbooks) {
    EXPECT_NEAR(fresnelTransmittance(1, 1, 1.5), 0.96, 1e-15);
    // At Brewster's angle only s-polarised light is reflected: R = ((n^2 - 1)/(n^2 + 1))^2 / 2.
    const double n = 1.333, brewster = std::atan(n);
    EXPECT_NEAR(1 - fresnelTransmittance(std::cos(brewster), 1, n), std::pow((n * n - 1) / (n * n + 1), 2) / 2, 1e-14);
    EXPECT_EQ(fresnelTransmittance(std::cos(std::asin(1 / n) + 1e-6), n, 1), 0);
    // Reciprocity.
    const double inside = std::cos(std::asin(std::sin(0.7) / n));
    EXPECT_NEAR(fresnelTransmittance(std::cos(0.7), 1, n), fresnelTransmittance(inside, n, 1), 1e-14);
}

TEST(PlaneTruth, LayerMeansAreTheIntegralOfBeerLambert) {
    const PlaneWater water{2.5, std::cos(0.6), 1, 1.333, 0.7};
    const double sin_below = std::sin(0.6) / 1.333;
    double sum = 0;
    const int steps = 20000;
    for (int i = 0; i < steps; ++i) sum += water.horizontal(0.2 + 0.5 * (i + 0.5) / steps) / steps;
    EXPECT_NEAR(water.meanHorizontal(0.2, 0.7), sum, 1e-9);
    EXPECT_NEAR(water.meanFluence(0.2, 0.7), sum / std::sqrt(1 - sin_below * sin_below), 1e-9);
    EXPECT_NEAR(water.horizontal(0), 2.5 * std::cos(0.6) * fresnelTransmittance(std::cos(0.6), 1, 1.333), 1e-15);
}

TEST(FoldTruth, CellMeansCountRays) {
    const Fold fold{1.7, 0.8, 0.013};
    const auto counted =
        countRays([&](double xi) { return fold.edge + fold.b * xi * xi / 2; }, 2, -0.1, 0.05, 12, 4000000);
    for (int i = 0; i < 12; ++i) {
        EXPECT_NEAR(fold.mean(-0.1 + 0.05 * i, -0.05 + 0.05 * i), 1.7 * counted[static_cast<std::size_t>(i)], 2e-4)
            << i;
    }
    EXPECT_NEAR(fold.mean(0.5, 0.5 + 1e-6), fold.at(0.5 + 5e-7), 1e-6);
    EXPECT_EQ(fold.at(0), 0);
}

TEST(CuspTruth, CellMeansCountRaysBeforeAtAndPastTheCusp) {
    const Cusp cusp{1.3, 2.0, 0.4};
    for (const double z : {0.5, 1.9, 2.0, 2.1, 4.0}) {
        const auto counted =
            countRays([&](double u) { return u * (1 - z / cusp.f) + cusp.c * u * u * u; }, 3, -0.6, 0.05, 24, 6000000);
        for (int i = 0; i < 24; ++i) {
            const double low = -0.6 + 0.05 * i;
            EXPECT_NEAR(cusp.mean(low, low + 0.05, z) / (1.3 * counted[static_cast<std::size_t>(i)]), 1, 3e-4)
                << z << " " << i;
        }
    }
}

TEST(CuspTruth, SpecialFormsAtTheCusp) {
    const Cusp cusp{1.3, 2.0, 0.4};
    EXPECT_NEAR(cusp.at(0.3, 2.0), 1.3 / (3 * std::cbrt(0.4) * std::pow(0.3, 2.0 / 3)), 1e-12);
    EXPECT_NEAR(cusp.mean(-0.01, 0.01, 2.0), 1.3 / std::cbrt(0.4) * std::pow(0.01, -2.0 / 3), 1e-9);
    const double edge = cusp.halfWidth(3);
    EXPECT_GT(cusp.at(edge - 1e-6, 3), 10 * cusp.at(edge + 1e-6, 3));
    EXPECT_EQ(cusp.halfWidth(1.9), 0);
}

/// Where the lines p + s d of two neighbouring rays meet.
glm::dvec2 meet(glm::dvec2 p, glm::dvec2 d, glm::dvec2 q, glm::dvec2 e) {
    const double s = ((q.x - p.x) * e.y - (q.y - p.y) * e.x) / (d.x * e.y - d.y * e.x);
    return p + s * d;
}

struct Reflected {
    glm::dvec2 point, direction;
};
Reflected reflectInCircle(double radius, double angle, glm::dvec2 direction) {
    const glm::dvec2 n(std::cos(angle), std::sin(angle));
    return {radius * n, direction - 2 * glm::dot(direction, n) * n};
}

TEST(MirrorTruth, NephroidIsWhereNeighboursOfParallelLightMeet) {
    const double r = 1.7, step = 1e-5;
    for (const double p : {-1.2, -0.5, 0.1, 0.4, 0.9, 1.3}) {
        const auto a = reflectInCircle(r, p - step, {1, 0}), b = reflectInCircle(r, p + step, {1, 0});
        const glm::dvec2 found = meet(a.point, a.direction, b.point, b.direction);
        EXPECT_LT(glm::distance(found, nephroid(r, p)), 1e-8) << p;
        EXPECT_NEAR(glm::distance(found, r * glm::dvec2(std::cos(p), std::sin(p))), mirrorFocus(r, std::cos(p)), 1e-8);
    }
}

TEST(MirrorTruth, CardioidIsWhereNeighboursFromTheCircleMeet) {
    const double r = 1.7, step = 1e-5;
    const glm::dvec2 source(-r, 0);
    for (const double q : {0.6, 1.1, 1.9, 2.6}) {
        const auto from = [&](double angle) {
            return reflectInCircle(r, angle, glm::normalize(r * glm::dvec2(std::cos(angle), std::sin(angle)) - source));
        };
        const auto a = from(q - step), b = from(q + step);
        const glm::dvec2 found = meet(a.point, a.direction, b.point, b.direction);
        EXPECT_LT(glm::distance(found, cardioid(r, q)), 1e-8) << q;
        const double cos_in = std::cos(q / 2), chord = 2 * r * cos_in;
        EXPECT_NEAR(glm::distance(found, r * glm::dvec2(std::cos(q), std::sin(q))), mirrorFocus(r, cos_in, chord),
                    1e-8);
    }
}

TEST(MirrorTruth, ParabolaConservesThePowerOfARing) {
    const ParabolicMirror mirror{1.4, 0.9};
    for (const double psi : {0.05, 0.4, 1.0}) {
        // Power of the ring of light that turns to angles psi +- half a step, over its area on the sphere of radius
        // rho.
        const double step = 1e-5, rho = 0.37;
        const auto r = [&](double a) { return 2 * mirror.f * std::tan(a / 2); };  // z = r^2 / 4f
        const double ring = std::numbers::pi * (r(psi + step) * r(psi + step) - r(psi - step) * r(psi - step));
        const double sphere = 2 * std::numbers::pi * rho * rho * (std::cos(psi - step) - std::cos(psi + step));
        EXPECT_NEAR(mirror.at(rho, psi), 1.4 * ring / sphere, 1e-5 * mirror.at(rho, psi));
        const double x = r(psi), z = x * x / (4 * mirror.f) - mirror.f;
        EXPECT_NEAR(mirror.mirrorDistance(psi), std::hypot(x, z), 1e-12);
        // The law of reflection sends light along the axis through the focus at the origin.
        const glm::dvec2 n = glm::normalize(glm::dvec2(-x / (2 * mirror.f), 1));
        const glm::dvec2 out = glm::dvec2(0, -1) - 2 * (-n.y) * n;
        EXPECT_NEAR(x * out.y - z * out.x, 0, 1e-12);
    }
}

}  // namespace
}  // namespace photic::truth
