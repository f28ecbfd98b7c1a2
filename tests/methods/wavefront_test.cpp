// SPDX-License-Identifier: Apache-2.0
// Light through media whose index varies, against rays that are known in closed form.
#include "bake/methods/wavefront.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "bake/graded/ray_integrator.h"
#include "bake/scene/index_volume.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

/// Power through a layer [W], from the field's flux along -z.
double downThrough(const LightField& field, int k) {
    const GridFrame& frame = field.frame();
    double sum = 0;
    for (int i = frame.min.x; i <= frame.max.x; ++i)
        for (int j = frame.min.y; j <= frame.max.y; ++j) sum -= field.flux({i, j, k}).z;
    return sum * frame.worldFromIndex()[0][0] * frame.worldFromIndex()[1][1];
}

/// Mean relative difference from a truth over the voxels of some layers.
double relativeError(const Bake& bake, double z_low, double z_high, double reach,
                     const std::function<double(const glm::dvec3&)>& truth) {
    const GridFrame& frame = bake.field().frame();
    double difference = 0, sum = 0;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                if (p.z < z_low || p.z > z_high || std::hypot(p.x, p.y) > reach) continue;
                const double wanted = truth(p);
                difference += std::fabs(bake.fluence({i, j, k}) - wanted), sum += wanted;
            }
    return difference / sum;
}

TEST(Wavefront, FocusesASelfocRodAsItsRaysDo) {
    // r = r0 cos(g depth / root), root = sqrt(1 - g^2 r0^2); light comes in at z = 0 through a flat face.
    const double g = 1.4, n0 = 1.5;
    const auto truth = [&](const glm::dvec3& p) {
        const double r = std::hypot(p.x, p.y), depth = -p.z;
        double r0 = r / std::cos(g * depth);
        for (int i = 0; i < 60; ++i) r0 = r / std::cos(g * depth / std::sqrt(1 - g * g * r0 * r0));
        const double root = std::sqrt(1 - g * g * r0 * r0), phase = g * depth / root;
        const double slope = std::cos(phase) - r0 * std::sin(phase) * phase * g * g * r0 / (root * root);
        const double spread = r > 1e-9 ? r0 / r : 1 / std::cos(phase);
        const double n = n0 * std::sqrt(1 - g * g * r * r);
        return spread / slope * n / (n0 * root);  // fluence: over the cosine of the ray
    };
    double error[2];
    for (int k = 0; k < 2; ++k) {
        const Bake b =
            bake(sceneOf("min = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0]\nresolution = " + std::to_string(32 << k),
                         kDown, medium("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }")));
        error[k] = relativeError(b, -0.6, -0.02, 0.06, truth);
        EXPECT_EQ(b.result.metadata.at("spline"), "through");
    }
    EXPECT_LT(error[1], 4e-3);
    EXPECT_GT(std::log2(error[0] / error[1]), 0.8);
}

TEST(Wavefront, TheOtherIntegratorsFindTheSameLight) {
    const Scene scene = sceneOf("min = [-0.4, -0.4, -0.4]\nmax = [0.4, 0.4, 0.4]\nresolution = 32", kDown,
                                medium("{ kind = \"fish_eye\", n0 = 1.5, scale = 0.9 }", "absorption = [0.2, 0.5, 1]"));
    const Bake controlled = bake(scene, with("integrator", std::string("controlled")));
    EXPECT_LT(controlled.report().power.imbalance(), 1e-9);
    const auto apart = [&](const Bake& b) { return compare(b, controlled).apart; };
    for (const char* name : {"runge_kutta", "yoshida"})
        EXPECT_LT(apart(bake(scene, with("integrator", std::string(name)))), 2e-5) << name;
    // The default is of second order.
    const double one = apart(bake(scene)), two = apart(bake(scene, with("steps", std::int64_t{2})));
    fmt::print("  one and two steps a layer: {:.4f} and {:.4f} % from the controlled integrator\n", 100 * one,
               100 * two);
    EXPECT_LT(one, 1e-3);
    EXPECT_LT(two, 0.6 * one);
}

TEST(Wavefront, LinearSquareFoldsIntoItsCaustic) {
    // n^2 = 1.5 - 3 x: x = x0 - g d^2 / (2 n0^2), g = 1.5, n0 at x0; neighbours cross where g d = n0^2, on the line
    // x = 0.5 - d, which goes through the corners of voxels at each of these sizes: at other places the error has
    // another phase. The truth is each voxel's share of a fine fan of these parabolas, over its height too.
    const double g = 1.5;
    const auto placeOf = [&](double x0, double depth) { return x0 - 0.5 * g * depth * depth / (1.5 - 3 * x0); };
    const auto errorAt = [&](double h, int quadrature) {
        Scene scene = sceneOf(fmt::format("min = [-0.8, 0, -0.9375]\nmax = [0.2, 0.125, 0]\nvoxel_size = {}", h), kDown,
                              medium("{ kind = \"linear\", n0 = 1.224744871391589, slope = [-3, 0, 0] }"));
        scene.bake.quadrature = quadrature;
        const Bake b = bake(scene);
        const GridFrame& frame = b.field().frame();
        const int cells = frame.max.x - frame.min.x + 1;
        const double low = frame.worldFromIndex(glm::dvec3(frame.min)).x - 0.5 * h;
        double difference = 0, sum = 0;
        for (int layer = frame.min.z; layer <= frame.max.z; ++layer) {
            const double middle = -frame.worldFromIndex(glm::dvec3(0, 0, layer)).z;
            if (middle < 0.7 || middle > 0.9) continue;
            std::vector<double> truth(static_cast<std::size_t>(cells), 0.0);
            constexpr int kFine = 200, kHeights = 32;
            for (int sub = 0; sub < kHeights; ++sub)
                for (int i = 0; i < cells * kFine; ++i) {
                    const double x0 = low + (i + 0.5) * h / kFine, depth = middle + ((sub + 0.5) / kHeights - 0.5) * h;
                    const double along = g * depth / (1.5 - 3 * x0);
                    const int cell = static_cast<int>(std::floor((placeOf(x0, depth) - low) / h));
                    if (cell >= 0 && cell < cells)
                        truth[static_cast<std::size_t>(cell)] += std::sqrt(1 + along * along) / kFine / kHeights;
                }
            const int j = (frame.min.y + frame.max.y) / 2;
            for (int cell = 0; cell < cells; ++cell) {
                const double wanted = truth[static_cast<std::size_t>(cell)];
                difference += std::fabs(b.fluence({frame.min.x + cell, j, layer}) - wanted), sum += wanted;
            }
        }
        EXPECT_LT(b.report().power.imbalance(), 1e-9);
        EXPECT_LT(b.report().path.imbalance(), 1e-4);
        return difference / sum;
    };
    // A fold, as 1 / sqrt of the distance, leaves errors of the order of sqrt(h) in the voxels that it crosses.
    for (const auto& [quadrature, bound] : {std::pair{1, 0.015}, {4, 0.0015}}) {
        const double error[3] = {errorAt(1.0 / 32, quadrature), errorAt(1.0 / 64, quadrature),
                                 errorAt(1.0 / 128, quadrature)};
        EXPECT_LT(error[2], bound) << quadrature;
        EXPECT_GT(std::log2(error[0] / error[1]), 0.4) << quadrature;
        EXPECT_GT(std::log2(error[1] / error[2]), 0.4) << quadrature;
    }
}

TEST(Wavefront, LosesNothingOnItsWayThroughPlanes) {
    // A weak ball without a jump at its rim, whose light all stays in the box: what crosses a layer below it is the
    // same everywhere.
    const Bake b = bake(sceneOf("min = [-0.5, -0.5, -1]\nmax = [0.5, 0.5, 0.5]\nresolution = 96", kDown,
                                medium("{ kind = \"fish_eye\", n0 = 1.2, scale = 0.7826238, radius = 0.35 }")));
    const GridFrame& frame = b.field().frame();
    const int below = static_cast<int>(frame.indexFromWorld({0, 0, -0.4}).z);
    const double first = downThrough(b.field(), below);
    EXPECT_NEAR(first, 3.14159 * 0.35 * 0.35, 0.05 * first);  // the ball's cross-section, to a voxel at its rim
    // From 0.9 m below its middle on, light from the rim leaves through the box's sides.
    const int last = static_cast<int>(frame.indexFromWorld({0, 0, -0.9}).z);
    double worst = 0, sum = 0;
    for (int k = last; k < below; ++k) {
        const double off = std::fabs(downThrough(b.field(), k) / first - 1);
        worst = std::max(worst, off), sum += off;
    }
    EXPECT_LT(worst, 1e-5);  // the layer of the focus, where all light is in a few voxels
    EXPECT_LT(sum / (below - last), 2e-6);
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    EXPECT_LT(b.report().path.imbalance(), 1e-5);
    EXPECT_GT(b.report().power.culled, 0);  // beside the ball
    EXPECT_EQ(b.report().power.dropped, 0);
}

TEST(Wavefront, LightInALuneburgLensIsThatOfItsRays) {
    // Inside, dp/ds = -x / R^2: r = r0 cos(t), z = z0 cos(t) - R sin(t), z0 = sqrt(R^2 - r0^2), and so the light is
    // (r0 / r) (dr0 / dr) over the ray's cosine. The kink of n at the rim is what grids find hard.
    const double radius = 0.4;
    struct Place {
        double r, cosine;
    };
    const auto placeOf = [&](double r0, double z) {
        const double z0 = std::sqrt(radius * radius - r0 * r0);
        double low = 0, high = 1.6;
        for (int i = 0; i < 40; ++i) {
            const double t = 0.5 * (low + high);
            (z0 * std::cos(t) - radius * std::sin(t) > z ? low : high) = t;
        }
        const double across = r0 / radius * std::sin(low), along = z0 / radius * std::sin(low) + std::cos(low);
        return Place{r0 * std::cos(low), along / std::hypot(across, along)};
    };
    const auto truth = [&](const glm::dvec3& p) {
        const double r = std::hypot(p.x, p.y), d = 1e-4;
        double low = 0, high = radius - 2 * d;
        for (int i = 0; i < 36; ++i) {
            const double r0 = 0.5 * (low + high);
            (placeOf(r0, p.z).r < r ? low : high) = r0;
        }
        const double slope =
            (placeOf(low + d, p.z).r - placeOf(std::fabs(low - d), p.z).r) / (low > d ? 2 * d : d + low);
        return low / r / slope / placeOf(low, p.z).cosine;
    };
    double error[3];
    for (int k = 0; k < 3; ++k) {
        const Bake b =
            bake(sceneOf(fmt::format("min = [-0.45, -0.45, -0.45]\nmax = [0.45, 0.45, 0.45]\nresolution = {}", 24 << k),
                         kDown, medium("{ kind = \"luneburg\", radius = 0.4 }")));
        error[k] = relativeError(b, -0.1, 0.1, 0.15, truth);
    }
    EXPECT_LT(error[2], 3e-3);
    EXPECT_GT(std::log2(error[0] / error[1]), 0.8);
    EXPECT_GT(std::log2(error[1] / error[2]), 0.7);
}

TEST(Wavefront, ALuneburgLensGathersItsLightInOnePoint) {
    for (const int resolution : {48, 96}) {
        const Bake b =
            bake(sceneOf("min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = " + std::to_string(resolution),
                         kDown, medium("{ kind = \"luneburg\", radius = 0.4 }")));
        const GridFrame& frame = b.field().frame();
        const double h = frame.worldFromIndex()[0][0];
        // The layer that ends at the focus, z = -0.4: power within two voxels of the axis.
        const int k = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.4 + 0.5 * h}).z));
        double near = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j) {
                const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                if (std::hypot(p.x, p.y) < 2.5 * h) near -= b.field().flux({i, j, k}).z * h * h;
            }
        // Rays within 60 degrees, sin^2 = 3/4 of the aperture; those beyond turn, and are laid along other axes.
        EXPECT_GT(near, 0.72 * 3.14159 * 0.16);
        EXPECT_LT(near, 1.05 * 3.14159 * 0.16);
        EXPECT_LT(b.report().power.imbalance(), 1e-9);
        EXPECT_LT(b.report().path.imbalance(), 1e-4);
        // Tubes whose corners go different ways at the lens's rim are divided, and few are lost.
        EXPECT_LT(b.report().power.dropped, 5e-3 * b.report().power.emitted);
    }
}

TEST(Wavefront, LightThatTurnsIsHandedOnWithItsPower) {
    // A strong gradient turns level light downwards by more than 60 degrees: its path in the box is what rays have.
    const Scene scene = sceneOf("min = [0, 0, -0.9]\nmax = [1, 0.25, 0.1]\nresolution = 64",
                                "type = \"sun\"\ndirection = [1, 0, 0]\nirradiance = 1\nangular_diameter = 0",
                                medium("{ kind = \"linear\", n0 = 2, slope = [0, 0, -14] }"));
    const Bake b = bake(scene), straight = bake(scene, with("turns", std::int64_t{0}));
    const auto graded = makeLinearSquare(glm::dvec3(0), 2, {0, 0, -14}, {});
    // The grid's own box, which is in whole voxels.
    const GridFrame& frame = b.field().frame();
    const glm::dvec3 low = frame.worldFromIndex(glm::dvec3(frame.min) - 0.5),
                     high = frame.worldFromIndex(glm::dvec3(frame.max) + 0.5);
    double expected = 0;
    constexpr int kRays = 1000;
    for (int i = 0; i < kRays; ++i) {
        GradedRay ray = startRay(*graded, {low.x, 0, low.z + (high.z - low.z) * (i + 0.5) / kRays}, {1, 0, 0});
        double path = 0;
        for (;;) {
            const glm::dvec3 before = ray.position;
            stepRungeKutta(*graded, 1e-4, ray);
            if (ray.position.x > high.x || ray.position.z < low.z) break;
            path += glm::distance(ray.position, before);
        }
        expected += path * (high.z - low.z) * (high.y - low.y) / kRays;
    }
    EXPECT_NEAR(b.report().path.expected, expected, 1e-3 * expected);
    EXPECT_LT(b.report().path.imbalance(), 1e-4);
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    // What is not handed on is counted.
    EXPECT_LT(straight.report().power.imbalance(), 1e-9);
    EXPECT_GT(straight.report().power.dropped, 2 * b.report().power.dropped);
}

TEST(Wavefront, AFlatBlockRefractsAndAttenuatesAsGlassDoes) {
    // n jumps to 1.4 at the faces of a block: a plain spline, and Snell's law within. Its sides are far away: light
    // that comes in by their rounded edges would come down here too.
    const double angle = 30 * 3.14159265358979 / 180;
    const std::string sun = "type = \"sun\"\ndirection = [0.5, 0, -0.8660254]\nirradiance = 1\nangular_diameter = 0";
    const Bake b = bake(
        sceneOf(
            "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 64", sun,
            medium("{ kind = \"linear\", n0 = 1.4, slope = [0, 0, 0], min = [-1, -0.6, -0.2], max = [1, 0.6, 0.2] }",
                   "absorption = [1, 2, 3]\nscattering = 1")),
        with("turns", std::int64_t{0}));
    EXPECT_EQ(b.result.metadata.at("spline"), "plain");
    const GridFrame& frame = b.field().frame();
    const auto at = [&](double z) { return glm::ivec3(glm::round(frame.indexFromWorld({0, 0, z}))); };
    const double inside = std::asin(std::sin(angle) / 1.4);
    const glm::dvec3 flux = b.field().flux(at(0));
    EXPECT_NEAR(flux.x / glm::length(flux), std::sin(inside), 2e-3);
    const glm::dvec3 below = b.field().flux(at(-0.4));
    EXPECT_NEAR(below.x / glm::length(below), std::sin(angle), 2e-3);
    const double length = 0.4 / std::cos(inside);
    const double sigma[3] = {2, 3, 4};
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(b.field().value(at(-0.4), c), std::exp(-sigma[c] * length), 0.03 * std::exp(-sigma[c] * length));
    const PowerLedger& power = b.report().power;
    EXPECT_LT(power.imbalance(), 1e-9);
    EXPECT_NEAR(power.absorbed_medium / power.scattered, 2, 0.4);  // of different channels
}

// Where a voxel is many times as deep as light goes, what is left in its middle is not its mean: a third of it at five
// times. By Beer and Lambert, layer by layer, from a side of the grid in and where the medium begins within it.
TEST(Wavefront, WhatAVoxelAbsorbsManyTimesOverKeepsItsMean) {
    const double sigma = 160, h = 1.0 / 32;  // 5 a voxel
    const auto layerMean = [&](int layer) {
        return std::exp(-sigma * h * layer) * -std::expm1(-sigma * h) / sigma / h;
    };
    const std::string box = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32";
    const Bake b = bake(
        sceneOf(box, kDown,
                medium("{ kind = \"linear\", n0 = 1.3, slope = [0, 0, 0] }", fmt::format("absorption = {}", sigma))));
    const glm::ivec3 top = b.field().frame().max;
    for (int layer = 0; layer < 3; ++layer)
        EXPECT_NEAR(b.fluence({0, 0, top.z - layer}) / b.fluence({0, 0, top.z}), layerMean(layer) / layerMean(0), 2e-4);
    EXPECT_NEAR(b.fluence({0, 0, top.z}), layerMean(0), 1e-3 * layerMean(0));
    // What is absorbed is the light's way times the medium's extinction, however dense it is.
    EXPECT_NEAR(b.report().power.absorbed_medium, sigma * b.report().path.deposited,
                1e-3 * b.report().power.absorbed_medium);
}

TEST(Wavefront, ABlockReflectsTotallyWhatCannotLeaveIt) {
    // Light that comes in by the left side, at 27 degrees to the level, meets the bottom too flatly to leave, where it
    // turns from one axis to another within the rounded face; what comes in by the top leaves further to the right.
    const Bake b =
        bake(sceneOf("min = [-0.5, -0.1, -0.35]\nmax = [0.4, 0.1, 0.35]\nvoxel_size = 0.0125",
                     "type = \"sun\"\ndirection = [0.8944, 0, -0.4472]\nirradiance = 1\nangular_diameter = 0",
                     medium("{ kind = \"linear\", n0 = 1.4, slope = [0, 0, 0], min = [-0.4, -0.3, -0.2], max "
                            "= [0.4, 0.3, 0.2] }")));
    const GridFrame& frame = b.field().frame();
    const auto voxel = [&](double x, double z) { return glm::ivec3(glm::round(frame.indexFromWorld({x, 0, z}))); };
    double leaks = 0, guided = 0;
    for (int i = 0; i < 15; ++i) {
        leaks += std::fabs(b.field().flux(voxel(-0.3 + 0.0125 * i, -0.25)).z) / 15;
        guided += b.field().irradiance(voxel(-0.3 + 0.0125 * i, -0.17)) / 15;
    }
    EXPECT_LT(leaks, 0.02);
    EXPECT_GT(guided, 0.9);  // on its way down, and on its way up
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
}

TEST(Wavefront, AgreesWithRaysThatAreFollowedOneByOne) {
    // Runge-Kutta on the formula, ray by ray, each with its share of the light, summed by the voxels that it passes:
    // nothing of tubes, planes, turns or splines. 2^3 voxels together, since rays are few.
    const std::string ball = "{ kind = \"fish_eye\", n0 = 1.6, scale = 0.5163978, radius = 0.4 }";
    const Bake b = bake(sceneOf("min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32",
                                "type = \"sun\"\ndirection = [0.3, 0.2, -0.93]\nirradiance = 1\nangular_diameter = 0",
                                medium(ball)));
    const GridFrame& frame = b.field().frame();
    const GradedIndex& index = *b.scene.index->objects()[0].index[0];
    const double radius = 0.4, voxel = frame.worldFromIndex()[0][0];
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, 0.2, -0.93)),
                     side = glm::normalize(glm::cross(d, glm::dvec3(1, 0, 0))), up = glm::cross(d, side);
    std::map<std::tuple<int, int, int>, double> truth;
    constexpr int kRows = 360;
    const double cell = 2 * radius / kRows;
    for (int i = 0; i < kRows * kRows; ++i) {
        // Places between the rows' ends that do not repeat with the voxels.
        const double x = -radius + (i % kRows + std::fmod(0.754878 * i, 1.0)) * cell,
                     y = -radius + (i / kRows + std::fmod(0.569840 * i, 1.0)) * cell;
        if (x * x + y * y >= radius * radius) continue;
        const double before = std::sqrt(radius * radius - x * x - y * y);
        GradedRay ray = startRay(index, x * side + y * up - d * before, d);
        for (;;) {
            const glm::dvec3 from = ray.position;
            stepRungeKutta(index, 0.2 * voxel, ray);
            const glm::ivec3 at(glm::round(frame.indexFromWorld(0.5 * (from + ray.position))));
            if (glm::any(glm::lessThan(at, frame.min)) || glm::any(glm::greaterThan(at, frame.max))) break;
            truth[{at.x >> 1, at.y >> 1, at.z >> 1}] += glm::distance(from, ray.position) * cell * cell;
        }
    }
    std::map<std::tuple<int, int, int>, double> baked;
    double difference = 0, sum = 0, baked_sum = 0;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i)
                baked[{i >> 1, j >> 1, k >> 1}] += b.fluence({i, j, k}) * voxel * voxel * voxel;
    for (const auto& [block, path] : baked) {
        const auto at = truth.find(block);
        const double wanted = at == truth.end() ? 0 : at->second;
        difference += std::fabs(path - wanted), sum += wanted, baked_sum += path;
    }
    EXPECT_NEAR(baked_sum, sum, 0.015 * sum);
    EXPECT_LT(difference, 0.07 * sum);
    // Tubes at the rim, with a ray that turns and one that does not, are divided.
    EXPECT_LT(b.report().power.dropped, 2e-3 * b.report().power.escaped);
}

TEST(Wavefront, SlantingLightComesInByTheSidesToo) {
    // An endless internal wave: the light repeats with it, also where it has come in beside the grid.
    const Bake b =
        bake(sceneOf("min = [-0.5, 0, -1]\nmax = [0.5, 0.25, 0]\nvoxel_size = 0.03125",
                     "type = \"sun\"\ndirection = [0.5, 0, -0.866]\nirradiance = 1\nangular_diameter = 0",
                     medium("{ kind = \"salt\", level = -0.3, thickness = 0.1, n_above = 1.3, n_below = 1.4, "
                            "amplitude = 0.05, wavelength = 0.5 }")));
    const GridFrame& frame = b.field().frame();
    double difference = 0, sum = 0, least = 1e9, most = 0;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int i = frame.min.x; i + 16 <= frame.max.x; ++i) {
            const double here = b.fluence({i, frame.min.y + 4, k}), further = b.fluence({i + 16, frame.min.y + 4, k});
            difference += std::fabs(here - further), sum += here;
            least = std::min(least, here), most = std::max(most, here);
        }
    EXPECT_LT(difference, 2e-3 * sum);
    EXPECT_GT(most, 1.5 * least);
}

TEST(Wavefront, ThreeIndicesDisperse) {
    const std::string ball = "{ kind = \"luneburg\", radius = 0.3 }";
    const Bake b = bake(
        sceneOf("min = [-0.4, -0.4, -0.6]\nmax = [0.4, 0.4, 0.4]\nresolution = 48", kDown,
                medium("[" + ball + ", " + ball + ", { kind = \"fish_eye\", n0 = 1.1, scale = 1, radius = 0.3 }]")));
    double apart = 0, same = 0, sum = 0;
    const GridFrame& frame = b.field().frame();
    for (int i = frame.min.x; i <= frame.max.x; ++i)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int k = frame.min.z; k <= frame.max.z; ++k) {
                const float red = b.field().value({i, j, k}, 0), green = b.field().value({i, j, k}, 1),
                            blue = b.field().value({i, j, k}, 2);
                sum += double(red), same += std::fabs(double(red - green)), apart += std::fabs(double(red - blue));
            }
    EXPECT_EQ(same, 0);
    EXPECT_GT(apart, 0.3 * sum);
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
}

TEST(Wavefront, TheCausticGridIsTheLightOverWhatThereWouldBeWithoutMedia) {
    for (const std::string& light :
         {kDown, std::string("type = \"point\"\nposition = [0.1, 0, 1.5]\npower = 12.566370614")}) {
        Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24", light,
                              medium("{ kind = \"luneburg\", radius = 0.2 }"));
        scene.bake.paths = Paths::All, scene.bake.grids.caustic = true;
        const Bake b = bake(scene);
        ASSERT_TRUE(b.result.caustic);
        const GridFrame& frame = b.field().frame();
        // Beside the lens there is as much as without it; the grid's largest value is where the light is.
        const glm::ivec3 beside(glm::round(frame.indexFromWorld({0.27, 0.27, 0.2})));
        EXPECT_NEAR(double(b.result.caustic->value(beside, 0)), 1, 5e-3);
        const glm::ivec3 focus(glm::round(frame.indexFromWorld({0, 0, -0.2})));
        const double way = glm::distance(frame.worldFromIndex(glm::dvec3(focus)), {0.1, 0, 1.5});
        EXPECT_NEAR(double(b.result.caustic->value(focus, 0)), b.fluence(focus) * (light == kDown ? 1 : way * way),
                    1e-4 * b.fluence(focus));
    }
}

// A cone of a voxel's width lies between the corners of the launched cells, or on one of them.
TEST(Wavefront, ANarrowSpotSendsWhatItsConeDoes) {
    const std::string salt =
        medium("{ kind = \"salt\", level = -0.2, thickness = 0.05, n_above = 1.333, n_below = 1.36 }");
    for (const double angle : {0.5, 3.0})
        for (const double blend : {0.0, 0.3}) {
            const Bake b =
                bake(sceneOf("min = [-0.5, -0.5, -0.6]\nmax = [0.5, 0.5, 0]\nvoxel_size = 0.05",
                             "type = \"spot\"\nposition = [0.013, 0.021, 1]\ndirection = [0.05, 0, -1]\npower = 1\n"
                             "angle = " +
                                 std::to_string(angle) + "\nblend = " + std::to_string(blend),
                             salt));
            const double rim = std::cos(0.5 * angle * std::numbers::pi / 180);
            EXPECT_NEAR(b.report().power.emitted / (0.5 * (1 - rim) * (1 - blend / 2)), 1, 0.01)
                << angle << ", " << blend;
        }
}

TEST(Wavefront, ALampMakesASphericalFront) {
    // Through a ball that bends next to nothing: light falls off with the square of its way.
    const Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 40",
                                "type = \"point\"\nposition = [0.1, 0, 1.5]\npower = 12.566370614",
                                medium("{ kind = \"linear\", n0 = 1.0002, slope = [0, 0, 0], min = [-0.25, -0.25, "
                                       "-0.28], max = [0.25, 0.25, 0.25] }"));
    const Bake b = bake(scene);
    const GridFrame& frame = b.field().frame();
    for (const glm::dvec3 p : {glm::dvec3(0.02, 0.01, 0.0), {-0.1, 0.05, -0.25}, {0.02, -0.03, 0.12}}) {
        const glm::ivec3 voxel(glm::round(frame.indexFromWorld(p)));
        const double way = glm::distance(frame.worldFromIndex(glm::dvec3(voxel)), {0.1, 0, 1.5});
        EXPECT_NEAR(b.fluence(voxel), 1 / (way * way), 2e-3);
    }
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
}

}  // namespace
}  // namespace photic
