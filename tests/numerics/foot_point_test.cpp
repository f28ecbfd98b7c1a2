// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/foot_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <utility>

#include "bake/numerics/amplitude_transport.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Height = std::function<double(double, double)>;

HeightTable tableOf(const Height& height, double half, double spacing) {
    const int count = static_cast<int>(2 * half / spacing) + 2 * HeightTable::kMargin;
    const double corner = -0.5 * (count - 1) * spacing;
    std::vector<double> samples;
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < count; ++i) samples.push_back(height(corner + i * spacing, corner + j * spacing));
    return {glm::dvec2(corner), spacing, count, count, samples};
}

double ripples(double x, double y) {
    return 0.02 * std::sin(5.4 * x + 1.9 * y + 0.4) + 0.014 * std::sin(-1.5 * x + 8.8 * y + 1.7) +
           0.004 * std::sin(13 * x - 7 * y);
}

PointLayers cube(int n, double top, double bottom) {
    const double h = 2.0 / n;
    PointLayers p;
    p.origin = {-1 + h / 2, -1 + h / 2, top}, p.step_x = p.step_y = h, p.step_z = {0, 0, -h};
    p.count_x = p.count_y = n, p.count_z = static_cast<int>((top - bottom) / h);
    return p;
}

TEST(HeightTable, InterpolatesAndDifferentiates) {
    const HeightTable table = tableOf(ripples, 1, 0.01);
    const double d = 1e-4;
    for (const glm::dvec2 p : {glm::dvec2(0.1234, -0.56), glm::dvec2(-0.9, 0.77), glm::dvec2(0, 0)}) {
        const HeightPoint h = table.at(p);
        EXPECT_NEAR(h.h, ripples(p.x, p.y), 3e-8);
        EXPECT_NEAR(h.hx, (ripples(p.x + d, p.y) - ripples(p.x - d, p.y)) / (2 * d), 5e-6);
        EXPECT_NEAR(h.hyy, (ripples(p.x, p.y + d) - 2 * ripples(p.x, p.y) + ripples(p.x, p.y - d)) / (d * d), 5e-3);
        EXPECT_NEAR(h.hxy, (table.at(p + glm::dvec2(0, d)).hx - table.at(p - glm::dvec2(0, d)).hx) / (2 * d), 1e-5);
    }
}

// Far from the origin the way from a foot that lies a hair away is all rounding, and would be no direction.
TEST(FootPoint, PointsOnTheSurfaceToRoundingAreNotBelowIt) {
    const glm::dvec2 far(9662.3, -7943.1);
    const double level = 2696.75;
    const int count = 64;
    const HeightTable table(far - 1.6, 0.05, count, count, std::vector<double>(std::size_t(count * count), level));
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.1, 0.02, -0.99));
    for (const double below : {1e-13, 1e-12, 3e-12, 1e-10, 1e-8, 1e-5, 1e-3}) {
        PointLayers points;
        points.origin = {far - 0.4, level - below}, points.step_x = points.step_y = 1.0 / 12;
        points.count_x = points.count_y = 9, points.count_z = 1;
        int lit = 0;
        sweepFootPoints({&table, sun, 1.333}, points, [&](int, const FootPointLayer& layer) {
            for (int j = 0; j < points.count_y; ++j)
                for (int i = 0; i < points.count_x; ++i) {
                    const std::size_t at = layer.at(std::size_t(i), std::size_t(j));
                    if (layer.arrival[at] >= FootPointLayer::kAboveSurface) continue;
                    // As a caller may find it who counts from another column.
                    const glm::dvec3 other = points.origin + glm::dvec3(3 * points.step_x, 3 * points.step_y, 0);
                    const glm::dvec3 p = other + glm::dvec3((i - 3) * points.step_x, (j - 3) * points.step_y, 0),
                                     foot(layer.foot_x[at], layer.foot_y[at], layer.foot_z[at]);
                    EXPECT_NEAR(glm::length(p - foot) / layer.distance[at], 1, 5e-6) << below;
                    ++lit;
                }
            return true;
        });
        EXPECT_EQ(lit, below > 1e-4 ? 81 : lit) << below;
    }
}

/// Snell's law under a tilted plane: rays, arrival and spread are known.
TEST(FootPoint, TiltedPlaneObeysSnell) {
    const HeightTable table = tableOf([](double x, double y) { return 0.2 * x - 0.1 * y; }, 3, 0.05);
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.4, 0.2, -0.9)),
                     normal = glm::normalize(glm::dvec3(-0.2, 0.1, 1));
    const double n2 = 1.333, cos_i = -glm::dot(sun, normal);
    const glm::dvec3 w =
        glm::normalize(sun / n2 + (cos_i / n2 - std::sqrt(1 - (1 - cos_i * cos_i) / (n2 * n2))) * normal);
    const PointLayers points = cube(16, -0.5, -1.5);
    int seen = 0;
    sweepFootPoints({&table, sun, n2}, points, [&](int k, const FootPointLayer& layer) {
        for (int j = 0; j < 16; ++j)
            for (int i = 0; i < 16; ++i) {
                const std::size_t at = layer.at(std::size_t(i), std::size_t(j));
                const glm::dvec3 p =
                    points.origin + glm::dvec3(i * points.step_x, j * points.step_y, k * points.step_z.z);
                const glm::dvec3 foot(layer.foot_x[at], layer.foot_y[at], layer.foot_z[at]);
                EXPECT_LT(glm::length((p - foot) / layer.distance[at] - w), 1e-6);
                EXPECT_NEAR(layer.arrival[at], n2 * glm::dot(w, p), 1e-10);
                EXPECT_NEAR(layer.curvature[at], 0, 1e-9);
                EXPECT_NEAR(layer.spread[at], 1, 1e-9);
                ++seen;
            }
        return true;
    });
    EXPECT_EQ(seen, 16 * 16 * points.count_z);
}

/// A wave along x under light from straight above: where a ray of Snell's law that has met no other arrives, its
/// arrival, curvature and spread are known from its own slope.
TEST(FootPoint, WaveObeysSnell) {
    const double a = 0.01, k = 6, n2 = 1.333;
    const HeightTable table = tableOf([&](double x, double) { return a * std::cos(k * x); }, 2, 0.01);
    PointLayers points = cube(64, -0.1, -1.0);
    points.count_x = 1, points.count_y = 1;
    for (const double u : {-0.7, -0.31, 0.02, 0.4}) {
        const double h = a * std::cos(k * u), slope = -a * k * std::sin(k * u), bend = -a * k * k * std::cos(k * u);
        const double beta = std::atan(slope), t = std::asin(std::sin(beta) / n2), alpha = beta - t;
        const double turn = bend / (1 + slope * slope) * (1 - std::cos(beta) / (n2 * std::cos(t)));  // d alpha / du
        for (const double depth : {0.2, 0.6, 1.0}) {
            const double x = u + (h + depth) * std::tan(alpha), s = (h + depth) / std::cos(alpha);
            points.origin = {x, 0, -depth + 0.1};  // three layers on the way down
            points.step_z = {0, 0, -0.05}, points.count_z = 3;
            sweepFootPoints({&table, {0, 0, -1}, n2}, points, [&](int layer_index, const FootPointLayer& layer) {
                if (layer_index < 2) return true;
                const std::size_t at = layer.at(0, 0);
                // Width of a bundle: du at the surface is du cos(t) / cos(beta) across the ray.
                const double grow = turn * std::cos(beta) / std::cos(t);
                EXPECT_NEAR(layer.foot_x[at], u, 1e-6);
                EXPECT_NEAR(layer.arrival[at], -h + n2 * s, 1e-8);
                EXPECT_NEAR(layer.spread[at], 1 + s * grow, 2e-4);
                EXPECT_NEAR(layer.curvature[at], grow / (1 + s * grow), 3e-3 * std::fabs(grow));
                return true;
            });
        }
    }
}

/// Past the focus too, every arrival is the least over the whole surface.
TEST(FootPoint, FindsTheGlobalMinimum) {
    const HeightTable table = tableOf(ripples, 2, 0.01);
    const glm::dvec3 sun(0.433, 0.25, -0.866);
    const double n2 = 1.333;
    const PointLayers points = cube(48, 0.06, -1.5);
    int wrong = 0, tested = 0;
    double worst = 0;
    sweepFootPoints({&table, sun, n2}, points, [&](int layer_index, const FootPointLayer& layer) {
        if (layer_index % 9 != 8) return true;
        for (int j = 0; j < 48; j += 11)
            for (int i = 0; i < 48; i += 11) {
                const glm::dvec3 p =
                    points.origin + glm::dvec3(i, j, 0) * points.step_x + double(layer_index) * points.step_z;
                const auto arrival = [&](double u, double v) {
                    const glm::dvec3 y(u, v, table.at({u, v}).h);
                    return glm::dot(sun, y) + n2 * glm::length(p - y);
                };
                double least = 1e9, bu = 0, bv = 0;
                for (double v = -1.9; v < 1.9; v += 0.025)
                    for (double u = -1.9; u < 1.9; u += 0.025)
                        if (const double t = arrival(u, v); t < least) least = t, bu = u, bv = v;
                for (double d = 0.0125; d > 1e-6; d *= 0.6)
                    for (const auto& [du, dv] : {std::pair{d, 0.0}, {-d, 0.0}, {0.0, d}, {0.0, -d}})
                        while (arrival(bu + du, bv + dv) < least) bu += du, bv += dv, least = arrival(bu, bv);
                const double off = layer.arrival[layer.at(std::size_t(i), std::size_t(j))] - least;
                ++tested;
                if (off > 1e-6 * points.step_x)
                    ++wrong;
                else
                    worst = std::max(worst, -off);
            }
        return true;
    });
    EXPECT_GE(tested, 100);
    EXPECT_LT(wrong, 1 + tested / 100) << "of " << tested;  // sheets that come in from the sides are not seen
    EXPECT_LT(worst, 1e-7 * points.step_x);
}

TEST(FootPoint, ThreadsChangeNothing) {
    const HeightTable table = tableOf(ripples, 2, 0.02);
    const auto sum = [&](int threads) {
        setThreadCount(threads);
        std::vector<double> all;
        sweepFootPoints({&table, {0.3, 0, -0.95}, 1.333}, cube(40, 0.05, -1.5), [&](int, const FootPointLayer& layer) {
            all.insert(all.end(), layer.arrival.begin(), layer.arrival.end());
            return true;
        });
        setThreadCount(0);
        return all;
    };
    EXPECT_EQ(sum(1), sum(3));
}

/// Rays towards a focus line at depth 1: Q = 1 / (1 - s) over the part that light reaches, second order in the cell,
/// and the sum is kept.
TEST(AmplitudeTransport, ConvergesAndKeepsTheSum) {
    double last = 0;
    for (const int n : {32, 64, 128}) {
        const double h = 1.0 / n;
        const auto size = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
        std::vector<double> q(size), zero(size, 0.0), from(size), to(size);
        const auto bump = [](double x) { return std::exp(-80 * x * x); };
        const auto place = [&](std::size_t i) { return (double(i % std::size_t(n)) + 0.5) * h - 0.5; };
        for (std::size_t i = 0; i < size; ++i) q[i] = bump(place(i));
        double before = 0, after = 0;
        for (const double v : q) before += v;
        AmplitudeTransport transport(n, n);
        const int layers = n / 2;  // down to half the focal depth
        for (int k = 0; k < layers; ++k) {
            for (std::size_t i = 0; i < size; ++i)
                from[i] = -place(i) / (1 - k * h), to[i] = -place(i) / (1 - (k + 1) * h);
            transport.advance(q, from, zero, to, zero);
        }
        for (const double v : q) after += v;
        EXPECT_NEAR(after / before, 1, 1e-7);
        double error = 0, sum = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const double truth = 2 * bump(2 * place(i));
            error += std::fabs(q[i] - truth), sum += truth;
        }
        if (last > 0) {
            EXPECT_GT(std::log2(last / (error / sum)), 1.5) << n << ": " << error / sum;
        }
        last = error / sum;
    }
    EXPECT_LT(last, 1e-2);
}

}  // namespace
}  // namespace photic
