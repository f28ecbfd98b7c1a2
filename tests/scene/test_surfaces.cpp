// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "bake/scene/spline_field.h"
#include "bake/scene/wave_field.h"
#include "tests/scene/surface_checks.h"

namespace photic {
namespace {

using test::differenceNormal;
using test::rowDifference;
constexpr double kPi = std::numbers::pi;

/// The focused pool of tests/support: three sines.
std::vector<Wave> poolWaves() {
    std::vector<Wave> waves;
    const double amplitude[] = {0.035, 0.025, 0.020}, wavelength[] = {1.3, 0.8, 0.5}, degrees[] = {20, 95, -40},
                 phase[] = {0.4, 1.7, 2.9};
    for (int i = 0; i < 3; ++i)
        waves.push_back({amplitude[i],
                         wavelength[i],
                         {std::cos(degrees[i] * kPi / 180), std::sin(degrees[i] * kPi / 180)},
                         phase[i]});
    return waves;
}

template <typename F>
SampleGrid sampled(int width, int height, glm::dvec2 size, const F& f) {
    SampleGrid grid{width, height, std::vector<double>(static_cast<std::size_t>(width * height))};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            grid.at(x, y) = f(((x + 0.5) / width - 0.5) * size.x, ((y + 0.5) / height - 0.5) * size.y);
    return grid;
}

TEST(FlatField, IsFlatAndSaysSo) {
    const auto field = makeFlatField(-0.25);
    EXPECT_EQ(field->at({3, 4}).position, glm::dvec3(3, 4, -0.25));
    EXPECT_EQ(field->at({3, 4}).normal, glm::dvec3(0, 0, 1));
    EXPECT_EQ(field->featureSize(), std::numeric_limits<double>::infinity());
    EXPECT_EQ(rowDifference(*field, {-1, 2}, 0.01, 100), 0);
}

TEST(WaveField, FollowsItsFormula) {
    const auto field = makeWaveField(poolWaves(), {0.1, -0.2, 0.5}, Patch::unbounded());
    const glm::dvec2 uv(0.37, 0.81);
    double z = 0.5;
    for (const Wave& w : poolWaves())
        z += w.amplitude *
             std::sin(2 * kPi / w.wavelength * glm::dot(w.direction, uv - glm::dvec2(0.1, -0.2)) + w.phase);
    EXPECT_NEAR(field->at(uv).position.z, z, 1e-15);
    EXPECT_NEAR(glm::length(field->at(uv).normal - differenceNormal(*field, uv, 1e-5)), 0, 1e-8);
    EXPECT_DOUBLE_EQ(field->featureSize(), 0.5 / 8);
    EXPECT_DOUBLE_EQ(field->maxZ(), 0.58);
    EXPECT_DOUBLE_EQ(field->minZ(), 0.42);
}

TEST(WaveField, RowAgreesWithPoints) {
    const auto field = makeWaveField(poolWaves(), {0.1, -0.2, 0.5}, Patch::unbounded());
    for (const std::size_t count : {1u, 2u, 63u, 64u, 65u, 1000u, 4097u})
        EXPECT_LT(rowDifference(*field, {-2.1, 0.33}, 4.2 / 4096, count), 1e-13) << count;
    EXPECT_LT(rowDifference(*field, {1e4, 0.33}, 0.01, 500), 1e-11);
    EXPECT_EQ(rowDifference(*field, {2, 0.33}, -0.01, 300), 0);
}

TEST(WaveField, EndsAtItsPatch) {
    const auto field = makeWaveField(poolWaves(), {0, 0, 0.5}, Patch::around({0, 0}, {2, 1}, 0.5));
    EXPECT_EQ(field->at({1.01, 0}).position, glm::dvec3(1.01, 0, 0.5));
    EXPECT_EQ(field->at({0, -0.51}).normal, glm::dvec3(0, 0, 1));
    EXPECT_NE(field->at({1, 0.5}).position.z, 0.5);  // the edge itself belongs to the patch
    EXPECT_LT(rowDifference(*field, {-3, 0.2}, 0.01, 600), 1e-13);
    EXPECT_EQ(rowDifference(*field, {-3, 0.7}, 0.01, 600), 0);
    EXPECT_EQ(rowDifference(*field, {-9, 0.2}, 0.01, 600), 0);
}

TEST(SplineField, ReproducesQuadraticsUpToTheEdge) {
    const auto f = [](double x, double y) { return 0.3 + 0.2 * x - 0.4 * y + 0.7 * x * x - 0.3 * x * y + 0.1 * y * y; };
    SplineFieldShape shape;
    shape.size = {2, 3}, shape.center = {0.5, -0.25, 1};
    const auto field = makeSplineField(shape, sampled(13, 9, shape.size, f));
    for (const double x : {-1.0, -0.93, 0.0, 0.41, 1.0})
        for (const double y : {-1.5, -1.2, 0.2, 1.5}) {
            const SurfacePoint p = field->at({x + 0.5, y - 0.25});
            EXPECT_NEAR(p.position.z, 1 + f(x, y), 1e-12) << x << ' ' << y;
            EXPECT_NEAR(p.normal.x, -(0.2 + 1.4 * x - 0.3 * y), 1e-11) << x << ' ' << y;
            EXPECT_NEAR(p.normal.y, -(-0.4 - 0.3 * x + 0.2 * y), 1e-11) << x << ' ' << y;
        }
}

TEST(SplineField, InterpolatesSamplesWhateverTheBoundary) {
    for (const GridBoundary boundary : {GridBoundary::Free, GridBoundary::Periodic, GridBoundary::Mirror})
        for (const Interpolation interpolation : {Interpolation::Bicubic, Interpolation::Bilinear}) {
            const auto f = [](double x, double y) { return std::sin(31 * x + 7 * y * y) + 3; };
            const SplineGrid grid(sampled(7, 5, {1, 1}, f), boundary, interpolation);
            const SampleGrid samples = sampled(7, 5, {1, 1}, f);
            for (int y = 0; y < 5; ++y)
                for (int x = 0; x < 7; ++x) EXPECT_NEAR(grid.at(x, y).value, samples.at(x, y), 1e-13);
            EXPECT_LE(grid.min(), *std::min_element(samples.values.begin(), samples.values.end()));
        }
}

TEST(SplineField, ConvergesAtFourthOrder) {
    const auto f = [](double x, double y) { return std::sin(3 * x + 1) * std::cos(2 * y); };
    double before = 0;
    for (const int n : {32, 64, 128}) {
        SplineFieldShape shape;
        shape.size = {2, 2};
        const auto field = makeSplineField(shape, sampled(n, n, shape.size, f));
        double worst = 0, worst_slope = 0;
        for (double x = -0.7; x < 0.7; x += 0.0137) {
            const SurfacePoint p = field->at({x, 0.31});
            worst = std::max(worst, std::fabs(p.position.z - f(x, 0.31)));
            worst_slope = std::max(worst_slope, std::fabs(p.normal.x + 3 * std::cos(3 * x + 1) * std::cos(0.62)));
        }
        if (before > 0) {
            EXPECT_GT(std::log2(before / worst), 3.6) << n;
        }
        EXPECT_LT(worst_slope, 2e-3);
        before = worst;
    }
    EXPECT_LT(before, 1e-7);
}

TEST(SplineField, CurvatureIsContinuousAndFacetsAreNot) {
    const auto f = [](double x, double y) { return std::sin(9 * x + y); };
    SplineFieldShape shape;
    const SampleGrid grid = sampled(16, 16, shape.size, f);
    const auto smooth = makeSplineField(shape, grid);
    shape.interpolation = Interpolation::Bilinear;
    const auto facets = makeSplineField(shape, grid);
    // Across the line of samples x = -1/2 + 8.5/16: the slope's slope of the one does not jump, the slope of the other
    // does.
    const double joint = -0.5 + 8.5 / 16, h = 1e-4;
    const auto slope = [](const HeightField& field, double x) { return -field.at({x, 0.1}).normal.x; };
    const double bend_after = (slope(*smooth, joint + h) - slope(*smooth, joint)) / h;
    const double bend_before = (slope(*smooth, joint) - slope(*smooth, joint - h)) / h;
    EXPECT_NEAR(bend_after, bend_before, 0.2);  // third derivative (of order 9^3) times h
    EXPECT_GT(std::fabs(bend_after), 10);
    EXPECT_GT(std::fabs(slope(*facets, joint + h) - slope(*facets, joint - h)), 0.5);
}

TEST(SplineField, PeriodicRepeatsInBothDirections) {
    const auto f = [](double x, double y) {
        return std::sin(2 * kPi * x / 2) + 0.3 * std::cos(2 * kPi * (x / 2 + 2 * y / 3));
    };
    SplineFieldShape shape;
    shape.size = {2, 3}, shape.boundary = GridBoundary::Periodic, shape.bounded = false;
    const auto field = makeSplineField(shape, sampled(24, 36, shape.size, f));
    for (const glm::dvec2 uv : {glm::dvec2(0.3, 0.2), glm::dvec2(0.99, -1.49), glm::dvec2(-1, 1.5)})
        for (const glm::dvec2 shift : {glm::dvec2(2, 0), glm::dvec2(0, 3), glm::dvec2(-8, 9)}) {
            EXPECT_NEAR(field->at(uv).position.z, field->at(uv + shift).position.z, 1e-13);
            EXPECT_NEAR(glm::length(field->at(uv).normal - field->at(uv + shift).normal), 0, 1e-12);
        }
    EXPECT_NEAR(field->at({0.5, 0.75}).position.z, f(0.5, 0.75), 1e-4);
    EXPECT_LT(rowDifference(*field, {-7.3, 4.1}, 0.01, 1500), 1e-12);
}

TEST(SplineField, RowAgreesWithPoints) {
    const auto f = [](double x, double y) { return std::sin(19 * x + y) * std::cos(11 * y - x); };
    SplineFieldShape shape;
    shape.size = {2, 2}, shape.center = {0.3, 0.1, -0.5};
    for (const Interpolation interpolation : {Interpolation::Bicubic, Interpolation::Bilinear}) {
        shape.interpolation = interpolation;
        const auto field = makeSplineField(shape, sampled(64, 48, shape.size, f));
        for (const double y : {-0.9, -0.2137, 1.1, 1.2}) {
            EXPECT_LT(rowDifference(*field, {-0.9, y}, 0.0073, 400), 1e-12) << y;
            EXPECT_LT(rowDifference(*field, {-0.7, y}, 2.0 / 777, 778), 1e-12) << y;  // edge to edge
            EXPECT_LT(rowDifference(*field, {-0.9, y}, 0.9, 3), 1e-12) << y;          // far apart
        }
    }
    EXPECT_DOUBLE_EQ(makeSplineField(shape, sampled(64, 48, shape.size, f))->featureSize(), 2.0 / 64);
}

TEST(SplineField, HorizontalDisplacementMovesPointsAndTurnsNormals) {
    // Gerstner waves: displacement -a sin, height a cos.
    const double k = 2 * kPi, a = 0.05;
    SplineFieldShape shape;
    shape.boundary = GridBoundary::Periodic, shape.bounded = false;
    const auto height = sampled(64, 64, shape.size, [&](double x, double y) { return a * std::cos(k * (x + 2 * y)); });
    const auto dx =
        sampled(64, 64, shape.size, [&](double x, double y) { return -a * 0.4 * std::sin(k * (x + 2 * y)); });
    const auto dy =
        sampled(64, 64, shape.size, [&](double x, double y) { return -a * 0.8 * std::sin(k * (x + 2 * y)); });
    const auto field = makeSplineField(shape, height, std::array{dx, dy});
    const glm::dvec2 uv(0.21, -0.13);
    const SurfacePoint p = field->at(uv);
    const double argument = k * (uv.x + 2 * uv.y);
    EXPECT_NEAR(p.position.x, uv.x - a * 0.4 * std::sin(argument), 1e-6);
    EXPECT_NEAR(p.position.y, uv.y - a * 0.8 * std::sin(argument), 1e-6);
    EXPECT_NEAR(glm::length(p.normal - differenceNormal(*field, uv, 1e-5)), 0, 1e-7);
    EXPECT_GT(p.normal.z, 0);
    EXPECT_LT(rowDifference(*field, {-1.2, 0.07}, 0.003, 900), 1e-12);
    EXPECT_GE(field->maxDisplacement(), a * std::hypot(0.4, 0.8) * 0.999);
    EXPECT_LT(field->maxDisplacement(), a * 1.01);
    EXPECT_GT(leastNormalZ(*field, shape, 64, 64), 0);

    const auto folded = [&](const SampleGrid& grid) {
        SampleGrid out = grid;
        for (double& v : out.values) v *= 8;
        return out;
    };
    EXPECT_LT(leastNormalZ(*makeSplineField(shape, height, std::array{folded(dx), folded(dy)}), shape, 64, 64), 0);
}

TEST(SplineField, FlatSamplesAreKnownToBeFlat) {
    SplineFieldShape shape;
    const auto field = makeSplineField(shape, sampled(8, 8, shape.size, [](double, double) { return 0.0; }));
    EXPECT_EQ(field->featureSize(), std::numeric_limits<double>::infinity());
    EXPECT_EQ(field->minZ(), field->maxZ());
}

}  // namespace
}  // namespace photic
