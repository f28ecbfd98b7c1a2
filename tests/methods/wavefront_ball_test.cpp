// SPDX-License-Identifier: Apache-2.0
// A ball of glass as a sharp surface and as a smoothed volume of its index [Ihrke et al. 2007, figure 7], in numbers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "bake/methods/wavefront.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/solids.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

constexpr double kIndex = 1.2, kRadius = 0.3;
const std::vector<double> kCircles{0.03, 0.05, 0.07, 0.1, 0.15};

/// Share of unpolarised light that passes a flat face.
double passes(double n1, double n2, double cosine) {
    const double sine = n1 / n2 * std::sqrt(1 - cosine * cosine), other = std::sqrt(1 - sine * sine);
    const double s = (n1 * cosine - n2 * other) / (n1 * cosine + n2 * other),
                 p = (n2 * cosine - n1 * other) / (n2 * cosine + n1 * other);
    return 1 - 0.5 * (s * s + p * p);
}

/// The layer that is looked at, below the ball.
int layerOf(const GridFrame& frame) { return static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.45}).z)); }

/// Power within circles in the middle of that layer, of what meets the ball: Snell's law for all rays.
/// @param keeps  of the power, of a ray that comes in at a distance from the axis
std::vector<double> snell(const Bake& below, const std::function<double(double)>& keeps) {
    const GridFrame& frame = below.field().frame();
    const double plane = frame.worldFromIndex(glm::dvec3(0, 0, layerOf(frame))).z;
    const auto crossing = [&](double b) {
        const double turn = std::asin(b / kRadius) - std::asin(b / kRadius / kIndex),
                     above = std::sqrt(kRadius * kRadius - b * b);
        const double way = 2 * (b * std::sin(turn) + above * std::cos(turn));
        const double x = b - way * std::sin(turn), z = above - way * std::cos(turn);
        return std::fabs(x - (z - plane) * std::tan(2 * turn));
    };
    std::vector<double> within(kCircles.size(), 0.0);
    constexpr int kRays = 20000;
    for (int i = 0; i < kRays; ++i)
        for (std::size_t k = 0; k < kCircles.size(); ++k) {
            const double b = kRadius * std::sqrt((i + 0.5) / kRays);
            within[k] += crossing(b) < kCircles[k] ? keeps(b) / kRays : 0.0;
        }
    return within;
}

/// The same of a bake.
std::vector<double> withinCircles(const Bake& b) {
    const GridFrame& frame = b.field().frame();
    const int k = layerOf(frame);
    const double h = frame.worldFromIndex()[0][0];
    std::vector<double> out;
    for (const double circle : kCircles) {
        double within = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j) {
                const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                int inside = 0;  // of the voxel's area
                for (int s = 0; s < 64; ++s)
                    inside +=
                        std::hypot(p.x + h * ((s % 8 + 0.5) / 8 - 0.5), p.y + h * ((s / 8 + 0.5) / 8 - 0.5)) < circle;
                within -= b.field().flux({i, j, k}).z * h * h * inside / 64;
            }
        out.push_back(within / (std::numbers::pi * kRadius * kRadius));
    }
    return out;
}

double apart(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += std::fabs(a[k] - b[k]) / static_cast<double>(a.size());
    return sum;
}

std::string domain(double voxel) {
    return fmt::format("min = [-0.45, -0.45, -0.5]\nmax = [0.45, 0.45, 0.4]\nvoxel_size = {}", voxel);
}

/// Through samples of the ball's index.
/// @param width  standard deviation by which they are smoothed [voxels]
Bake smoothed(double voxel, int width, double rim = 0) {
    Monitor monitor;
    SolidVolume solid =
        voxelise({{"ball", "test", sphereMesh(glm::dvec3(0), kRadius, 96), kIndex}}, voxel, 20, monitor);
    smooth(solid, width);
    IndexVolume::Samples samples;
    samples.world_from_index = glm::dmat3(solid.voxel_size);
    samples.origin_world = (glm::dvec3(solid.min) + 0.5) * solid.voxel_size;
    samples.size = solid.size, samples.values = solid.index;
    Scene scene = sceneOf(domain(voxel), kDown, medium("{ kind = \"luneburg\", radius = 0.3 }"));
    GradedObject object = scene.index->objects().front();
    object.index = {
        makeSampledIndex(std::make_shared<IndexVolume>(std::move(samples), 1.0), glm::dvec3(0), glm::dmat3(1))};
    scene.index = std::make_shared<IndexVolume>(std::vector<GradedObject>{object});
    return bake(scene, rim > 0 ? with("rim", rim) : GivenOptions{});
}

const auto kAll = [](double) { return 1.0; };

TEST(Wavefront, ASmoothedBallGoesToTheSharpOne) {
    const auto error = [](double voxel, int width) {
        const Bake b = smoothed(voxel, width);
        const double off = apart(withinCircles(b), snell(b, kAll));
        fmt::print("  voxels of {} m, a deviation of {}: {:.2f} % off\n", voxel, width, 100 * off);
        return off;
    };
    const double wide = error(0.0125, 4), middle = error(0.0125, 2), narrow = error(0.0125, 1);
    EXPECT_GT(wide, 2 * middle);
    EXPECT_GT(middle, narrow);
    EXPECT_LT(narrow, 0.06);
    // And with smaller voxels, in which the same deviation is less.
    const double coarse = error(0.025, 1), fine = error(0.00625, 1);
    EXPECT_LT(narrow, 0.8 * coarse);
    EXPECT_LT(fine, 0.8 * narrow);
}

/// Power that meets what counts of a smoothed ball, over that which meets the ball. A ray that would pass the middle at
/// b comes as near as r n(r) = b [Bouguer's law]: what reaches the rim is the least of r n(r) from there on.
double metFrom(double rim, double deviation) {
    const double root = std::sqrt(2.0) * deviation;
    const auto indexAt = [&](double r) {
        const double low = (kRadius - r) / root, high = (kRadius + r) / root;
        const double tails =
            deviation / (std::sqrt(2 * std::numbers::pi) * r) * (std::exp(-low * low) - std::exp(-high * high));
        return 1 + (kIndex - 1) * (0.5 * (std::erf(low) + std::erf(high)) - tails);
    };
    double reach = 2 * kRadius;
    for (double r = 2 * kRadius; r > 0.1 * kRadius; r -= 1e-5) {
        reach = std::min(reach, r * indexAt(r));
        if (indexAt(r) * indexAt(r) - 1 > rim * (kIndex * kIndex - 1)) break;
    }
    return reach * reach / (kRadius * kRadius);
}

TEST(Wavefront, LightCountsFromTheRimThatIsAsked) {
    constexpr double kVoxel = 0.0125;
    const auto power = [](int width, double rim) {
        const Bake b = smoothed(kVoxel, width, rim);
        const GridFrame& frame = b.field().frame();
        double sum = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j)
                sum -= b.field().flux({i, j, layerOf(frame)}).z * kVoxel * kVoxel;
        return sum / (std::numbers::pi * kRadius * kRadius);
    };
    // Where faces are this wide, no ray is turned out of the domain.
    const double deviation = kVoxel * std::sqrt(4.0 * 4.0 + 1.0 / 12);
    EXPECT_NEAR(power(4, 0), metFrom(0.01, deviation), 0.02);
    EXPECT_NEAR(power(4, 0.25), metFrom(0.25, deviation), 0.02);
    EXPECT_NEAR(power(4, 0.5), metFrom(0.5, deviation), 0.02);
}

TEST(Wavefront, ASharpBallIsTheBeamsAndLosesWhatFresnelSays) {
    // What its two faces reflect is all that parts a sharp ball from the smoothed one.
    const auto keeps = [](double b) {
        const double outside = std::sqrt(1 - b * b / (kRadius * kRadius)),
                     inside = std::sqrt(1 - b * b / (kRadius * kRadius * kIndex * kIndex));
        return passes(1, kIndex, outside) * passes(kIndex, 1, inside);
    };
    const std::string ball = "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.3\ninside = \"glass\"\n";
    const std::string glass = "[[medium]]\nname = \"glass\"\nior = 1.2\n",
                      even =
                          "[[medium]]\nname = \"glass\"\nindex = { kind = \"linear\", n0 = 1.2, slope = [0, 0, 0] }\n";
    const Bake beams = bakeWith("beams", sceneOf(domain(0.0125), kDown, glass + ball)),
               fronts = bake(sceneOf(domain(0.0125), kDown, even + ball));
    const std::vector<double> truth = snell(beams, keeps), clear = snell(beams, kAll);
    EXPECT_LT(apart(withinCircles(beams), withinCircles(fronts)), 2e-3);
    // What is left is the voxels that the circles cut.
    EXPECT_LT(apart(withinCircles(beams), truth), 0.01);
    EXPECT_LT(apart(withinCircles(fronts), truth), 0.01);
    // Light by the rim, which crosses the axis first, loses most: 14 % in the smallest circle, 7 % of all.
    EXPECT_NEAR(truth.front() / clear.front(), 0.86, 0.01);
    EXPECT_NEAR(truth.back() / clear.back(), 0.928, 0.002);
}

}  // namespace
}  // namespace photic
