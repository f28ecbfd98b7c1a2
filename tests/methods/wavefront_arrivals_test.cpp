// SPDX-License-Identifier: Apache-2.0
// Which light of several arrivals a voxel keeps, and when the first one comes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "bake/methods/wavefront.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/eikonal_bakes.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

using test::bakeEikonal;
using test_scenes::boxFrame;
using test_scenes::waterScene;

const GivenOptions kStrongest = with("arrivals", std::string("strongest"));

template <class Body>
void forVoxels(const GridFrame& frame, const Body& body) {
    for (int i = frame.min.x; i <= frame.max.x; ++i)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int k = frame.min.z; k <= frame.max.z; ++k) body(glm::ivec3(i, j, k));
}

/// n^2 = 1.5 - 3 x: x = x0 - g d^2 / (2 n0^2), g = 1.5, n0 at x0. Two rays come to a place beside the fold, where
/// neighbours cross: one that has been there, x0 > 0.5 - d / 2, and one that has not. Means over voxels of both, in
/// light of 1 W/m2, by a fine fan of these parabolas.
struct FoldTruth {
    std::vector<double> before, past;

    FoldTruth(double low, int cells, double h, double middle)
        : before(static_cast<std::size_t>(cells)), past(static_cast<std::size_t>(cells)) {
        const double g = 1.5;
        constexpr int kFine = 200, kHeights = 32;
        for (int sub = 0; sub < kHeights; ++sub)
            for (int i = 0; i < cells * kFine; ++i) {
                const double x0 = low + (i + 0.5) * h / kFine, depth = middle + ((sub + 0.5) / kHeights - 0.5) * h;
                const double along = g * depth / (1.5 - 3 * x0), x = x0 - 0.5 * depth * along;
                const int cell = static_cast<int>(std::floor((x - low) / h));
                if (cell >= 0 && cell < cells)
                    (x0 > 0.5 - 0.5 * depth ? past : before)[static_cast<std::size_t>(cell)] +=
                        std::sqrt(1 + along * along) / kFine / kHeights;
            }
    }
};

TEST(WavefrontArrivals, TheStrongestIsOneSheetOfAFold) {
    const auto errorAt = [](double h) {
        Scene scene = sceneOf(fmt::format("min = [-0.8, 0, -0.9375]\nmax = [0.2, 0.125, 0]\nvoxel_size = {}", h), kDown,
                              medium("{ kind = \"linear\", n0 = 1.224744871391589, slope = [-3, 0, 0] }"));
        scene.bake.quadrature = 4;
        const Bake all = bake(scene), one = bake(scene, kStrongest);
        const GridFrame& frame = one.field().frame();
        const int cells = frame.max.x - frame.min.x + 1;
        const double low = frame.worldFromIndex(glm::dvec3(frame.min)).x - 0.5 * h;
        double difference = 0, sum = 0, lit = 0, several = 0, shares = 0, left_out = 0, light = 0;
        for (int layer = frame.min.z; layer <= frame.max.z; ++layer) {
            const double middle = -frame.worldFromIndex(glm::dvec3(0, 0, layer)).z;
            const FoldTruth truth(low, cells, h, middle);
            const int j = (frame.min.y + frame.max.y) / 2;
            for (int cell = 0; cell < cells; ++cell) {
                const double a = truth.before[static_cast<std::size_t>(cell)],
                             b = truth.past[static_cast<std::size_t>(cell)];
                const glm::ivec3 voxel(frame.min.x + cell, j, layer);
                difference += std::fabs(one.fluence(voxel) - std::max(a, b)), sum += std::max(a, b);
                lit += a + b > 0, light += a + b, left_out += std::min(a, b);
                if (a + b > 0 && std::min(a, b) >= 0.01 * (a + b)) ++several, shares += std::max(a, b) / (a + b);
            }
        }
        // The parts that are left out and those that are kept are what all arrivals are together.
        forVoxels(frame, [&](const glm::ivec3& voxel) {
            EXPECT_LE(one.fluence(voxel), all.fluence(voxel) * (1 + 1e-5) + 1e-6);
        });
        const ArrivalShares& shown = one.report().arrivals.value();
        EXPECT_FALSE(all.report().arrivals);
        EXPECT_NEAR(shown.left_out, 1 - one.field().sum(0) / all.field().sum(0), 1e-5);
        EXPECT_NEAR(shown.left_out, left_out / light, 0.1 * left_out / light);
        EXPECT_NEAR(shown.several, several / lit, 0.1 * several / lit);
        EXPECT_NEAR(shown.strongest, shares / several, 0.02);
        EXPECT_LT(one.report().power.imbalance(), 1e-9);
        EXPECT_LT(one.report().path.imbalance(), 1e-6);
        EXPECT_EQ(one.result.metadata.at("arrivals"), "strongest");
        EXPECT_EQ(one.result.metadata.at("left_out"), fmt::format("{:.4f}", shown.left_out));
        return difference / sum;
    };
    const double coarse = errorAt(1.0 / 32), fine = errorAt(1.0 / 64);
    EXPECT_LT(fine, 0.01);
    EXPECT_GT(std::log2(coarse / fine), 0.4);  // as all arrivals: sqrt(h) beside a fold
}

TEST(WavefrontArrivals, OneSheetHasOneDirection) {
    // Beside the fold of n^2 = 1.5 - 3 x two sheets cross, the farther from it the more.
    const Scene scene = sceneOf("min = [-0.8, 0, -0.9375]\nmax = [0.2, 0.125, 0]\nresolution = 64", kDown,
                                medium("{ kind = \"linear\", n0 = 1.224744871391589, slope = [-3, 0, 0] }"));
    const Bake all = bake(scene), one = bake(scene, kStrongest);
    double shortest_all = 1, shortest = 1;
    forVoxels(all.field().frame(), [&](const glm::ivec3& voxel) {
        if (!(one.fluence(voxel) > 0.01)) return;
        shortest_all = std::min(shortest_all, glm::length(all.field().flux(voxel)) / all.fluence(voxel));
        shortest = std::min(shortest, glm::length(one.field().flux(voxel)) / one.fluence(voxel));
    });
    EXPECT_LT(shortest_all, 0.985);
    EXPECT_GT(shortest, 0.999);
}

TEST(WavefrontArrivals, LightBeforeItsFocusHasOne) {
    // Also where it turns, is handed on and divided: in a Luneburg lens light from the rim turns by up to 90 degrees.
    const Scene scene = sceneOf("min = [-0.45, -0.45, -0.45]\nmax = [0.45, 0.45, 0.45]\nresolution = 48", kDown,
                                medium("{ kind = \"luneburg\", radius = 0.4 }"));
    const Bake all = bake(scene), one = bake(scene, kStrongest);
    double apart = 0, sum = 0;
    forVoxels(all.field().frame(), [&](const glm::ivec3& voxel) {
        const glm::dvec3 p = all.field().frame().worldFromIndex(glm::dvec3(voxel));
        if (glm::length(p) > 0.36 || p.z < -0.25) return;
        apart += std::fabs(all.fluence(voxel) - one.fluence(voxel)), sum += all.fluence(voxel);
    });
    EXPECT_LT(apart, 2e-3 * sum) << apart / sum;
}

TEST(WavefrontArrivals, LightsAndColoursKeepTheirOwn) {
    // Two suns on the same place are two arrivals, whichever comes first; three equal indices are one for each colour.
    Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24", kDown,
                          medium("{ kind = \"linear\", n0 = 1.01, slope = [0, 0, 0] }"));
    scene.bake.paths = Paths::All;
    Light other = scene.lights.front();
    other.irradiance = glm::dvec3(0.25);
    for (const bool first : {true, false}) {
        Scene two = scene;
        two.lights.insert(first ? two.lights.begin() : two.lights.end(), other);
        const Bake b = bake(two, kStrongest);
        EXPECT_NEAR(b.fluence({0, 0, 0}), 1, 1e-4);
        EXPECT_NEAR(b.report().arrivals->several, 1, 1e-12);
        EXPECT_NEAR(b.report().arrivals->strongest, 0.8, 1e-4);
        EXPECT_NEAR(b.report().arrivals->left_out, 0.2, 1e-4);
        EXPECT_LT(b.report().path.imbalance(), 1e-6);
    }
    const std::string ball = "{ kind = \"fish_eye\", n0 = 1.3, scale = 1, radius = 0.25 }";
    const std::string domain = "min = [-0.3, -0.3, -0.9]\nmax = [0.3, 0.3, 0.3]\nresolution = 24";
    const Bake white = bake(sceneOf(domain, kDown, medium(ball)), kStrongest),
               coloured =
                   bake(sceneOf(domain, kDown, medium("[" + ball + ", " + ball + ", " + ball + "]")), kStrongest);
    EXPECT_NEAR(coloured.report().arrivals->several, white.report().arrivals->several, 1e-9);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(coloured.field().sum(c), white.field().sum(0), 1e-6 * white.field().sum(0));
}

TEST(WavefrontArrivals, ThreadsChangeNoBit) {
    Scene scene = sceneOf("min = [-0.4, -0.4, -0.5]\nmax = [0.4, 0.4, 0.4]\nresolution = 40", kDown,
                          medium("{ kind = \"luneburg\", radius = 0.3 }", "absorption = 0.3"));
    scene.bake.grids.arrival_time = true;
    setThreadCount(1);
    const Bake one = bake(scene, kStrongest);
    setThreadCount(3);
    const Bake three = bake(scene, kStrongest);
    setThreadCount(0);
    EXPECT_EQ(one.report().arrivals->several, three.report().arrivals->several);
    EXPECT_EQ(one.report().path.expected, three.report().path.expected);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
    EXPECT_EQ(one.result.arrival_time->sum(0), three.result.arrival_time->sum(0));
}

TEST(WavefrontArrivals, FirstLightInALuneburgLensIsThatOfItsRays) {
    // r = r0 cos(t), z = z0 cos(t) - R sin(t): T = R t - z0 cos^2(t), from the plane z = 0.
    const double radius = 0.4;
    const auto truth = [&](double r, double z) {
        double low = 0, high = radius * (1 - 1e-9), t = 0;
        for (int i = 0; i < 60; ++i) {
            const double r0 = 0.5 * (low + high), z0 = std::sqrt(radius * radius - r0 * r0);
            double early = 0, late = 1.6;
            for (int k = 0; k < 50; ++k) {
                t = 0.5 * (early + late);
                (z0 * std::cos(t) - radius * std::sin(t) > z ? early : late) = t;
            }
            (r0 * std::cos(t) < r ? low : high) = r0;
        }
        const double z0 = std::sqrt(radius * radius - low * low);
        return radius * t - z0 * std::cos(t) * std::cos(t);
    };
    double error[3];
    for (int k = 0; k < 3; ++k) {
        Scene scene =
            sceneOf(fmt::format("min = [-0.45, -0.45, -0.45]\nmax = [0.45, 0.45, 0.45]\nresolution = {}", 24 << k),
                    kDown, medium("{ kind = \"luneburg\", radius = 0.4 }"));
        scene.bake.grids.arrival_time = true;
        const Bake b = bake(scene);
        const double h = b.field().frame().worldFromIndex()[0][0];
        double off = 0, voxels = 0;
        forVoxels(b.field().frame(), [&](const glm::ivec3& voxel) {
            const glm::dvec3 p = b.field().frame().worldFromIndex(glm::dvec3(voxel));
            if (std::fabs(p.z) > 0.2 || std::hypot(p.x, p.y) > 0.2 || (voxel.x + voxel.y + voxel.z) % 5 != 0) return;
            off += std::fabs(double(b.result.arrival_time->value(voxel, 0)) - truth(std::hypot(p.x, p.y), p.z)) / h;
            ++voxels;
        });
        error[k] = off / voxels;
    }
    EXPECT_LT(error[2], 5e-3);  // voxels; the kink of n at the rim is what grids find hard
    EXPECT_LT(error[2], error[1]);
    EXPECT_LT(error[1], error[0]);
}

TEST(WavefrontArrivals, TheEarlierOfTwoIsFirst) {
    // Beside the fold of n^2 = 1.5 - 3 x: T = p . x along each parabola; light that has not been to the fold is first.
    const double h = 1.0 / 64, g = 1.5;
    Scene scene = sceneOf(fmt::format("min = [-0.8, 0, -0.9375]\nmax = [0.2, 0.125, 0]\nvoxel_size = {}", h), kDown,
                          medium("{ kind = \"linear\", n0 = 1.224744871391589, slope = [-3, 0, 0] }"));
    scene.bake.grids.arrival_time = true;
    const Bake b = bake(scene);
    const GridFrame& frame = b.field().frame();
    // T of the ray from x0 at depth d: the integral of n^2 ds, ds = dd / n0, over n^2 = n0^2 + (3 g / (2 n0^2)) d^2.
    const auto timeOf = [&](double x0, double d) {
        const double square = 1.5 - 3 * x0;
        return (square * d + 0.5 * g * d * d * d / square) / std::sqrt(square);
    };
    double worst = 0;
    int two = 0;
    forVoxels(frame, [&](const glm::ivec3& voxel) {
        const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(voxel));
        const double d = -p.z;
        // x0 of both rays: 3 x0^2 - (1.5 + 3 x) x0 + 1.5 x + g d^2 / 2 = 0.
        const double half = (1.5 + 3 * p.x) / 6, root = half * half - (1.5 * p.x + 0.5 * g * d * d) / 3;
        if (root < 0.002 || p.x < -0.7) return;
        double first = 1e9;
        int rays = 0;
        for (const double x0 : {half - std::sqrt(root), half + std::sqrt(root)}) {
            // Light comes in at the box's top, and not from beyond its side.
            if (std::fabs(x0 - 0.2) < 0.02) return;
            if (x0 < 0.2 && 1.5 - 3 * x0 > 0) first = std::min(first, timeOf(x0, d)), ++rays;
        }
        if (rays == 0) return;
        two += rays == 2;
        worst = std::max(worst, std::fabs(double(b.result.arrival_time->value(voxel, 0)) - first) / h);
    });
    EXPECT_LT(worst, 0.02);  // voxels
    EXPECT_GT(two, 100);
}

TEST(WavefrontArrivals, FirstLightIsThatOfTheEikonalEquation) {
    // Flat water whose n^2 grows with depth, under a slanting sun: fast marching through samples, and fronts.
    constexpr int n = 32;
    const double first = 1.77, growth = 0.6;
    IndexVolume::Samples samples;
    samples.size = {1, 1, 201};
    samples.world_from_index[2].z = 0.01, samples.origin_world.z = -1.6;
    for (int k = 0; k < samples.size.z; ++k)
        samples.values.push_back(static_cast<float>(std::sqrt(first - growth * (-1.6 + 0.01 * k))));
    Scene water = waterScene(0.6);
    water.index = std::make_shared<IndexVolume>(std::move(samples), 1.333);
    const glm::dvec3 low(-0.25, -0.25, -1);
    const BakeResult marched = bakeEikonal(water, low, {n / 2, n / 2, n}, 1.0 / n);

    Scene scene =
        sceneOf("min = [-1, -1, -1]\nmax = [1, 1, 0]\nresolution = 8", kDown,
                medium(fmt::format("{{ kind = \"linear\", n0 = {}, slope = [0, 0, {}] }}", std::sqrt(first), -growth)));
    scene.lights[0].direction = water.lights[0].direction;
    scene.bake.grids.arrival_time = true;
    Monitor monitor;
    const GridFrame frame = boxFrame(low, {n / 2, n / 2, n}, glm::dvec3(1.0 / n));
    const BakeResult fronts =
        findMethod("wavefront")
            ->bake(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), {}, monitor);
    double worst = 0;
    int voxels = 0;
    forVoxels(frame, [&](const glm::ivec3& voxel) {
        if (!(fronts.field.irradiance(voxel) > 0) || !(marched.field.irradiance(voxel) > 0)) return;
        ++voxels;
        worst = std::max(worst, std::fabs(double(fronts.arrival_time->value(voxel, 0)) -
                                          double(marched.arrival_time->value(voxel, 0))) *
                                    n);
    });
    EXPECT_GT(voxels, 0.9 * frame.voxelCount());
    EXPECT_LT(worst, 5e-3);  // voxels
}

TEST(WavefrontArrivals, ALampsTimeIsItsDistance) {
    Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24",
                          "type = \"point\"\nposition = [0.1, 0, 1.5]\npower = 12.566370614",
                          medium("{ kind = \"luneburg\", radius = 0.02 }"));
    scene.bake.paths = Paths::All, scene.bake.grids.arrival_time = true;
    const Bake b = bake(scene);
    for (const glm::dvec3 p : {glm::dvec3(0.2, 0.21, 0.0), {-0.1, 0.25, -0.25}, {0.22, -0.13, 0.12}}) {
        const glm::ivec3 voxel(glm::round(b.field().frame().indexFromWorld(p)));
        const double way = glm::distance(b.field().frame().worldFromIndex(glm::dvec3(voxel)), {0.1, 0, 1.5});
        EXPECT_NEAR(double(b.result.arrival_time->value(voxel, 0)), way, 2e-5);
    }
}

}  // namespace
}  // namespace photic
