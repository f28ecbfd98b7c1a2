// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/clip_triangle.h"

#include <algorithm>
#include <cmath>

#include "bake/deposit/edge_kernel.h"

namespace photic {
namespace {

// Share of a triangle where a linear function with these corner values is positive.
double positiveShare(double a, double b, double c) {
    const auto [low, high] = std::minmax({a, b, c});
    const double middle = std::max(std::min(a, b), std::min(std::max(a, b), c));
    if (middle <= 0) return high * high / ((high - middle) * (high - low));
    return 1 - low * low / ((middle - low) * (high - low));
}

// Adds fraction x amount to a voxel.
void addToVoxel(TileSums& tile, int lane, int row, int column, const float* amounts, double fraction) {
    float* cell = tile.sums + static_cast<std::ptrdiff_t>(row) * tile.rowStride() +
                  static_cast<std::ptrdiff_t>(column) * tile.cellStride() + lane;
    const int next = tile.cellStride();
    for (int k = 0; k < tile.channels; ++k) {
        const float amount = static_cast<float>(fraction) * amounts[k];
        cell[k * tile.lanes] += amount;
        if (tile.running) cell[k * tile.lanes + next] -= amount;
    }
}

}  // namespace

double sourceFraction(const ClipPolygon& p) {
    double area2 = 0;
    for (int i = 1; i + 1 < p.count; ++i) {
        const ClipPoint &a = p.points[0], &b = p.points[i], &c = p.points[i + 1];
        area2 += (b.b1 - a.b1) * (c.b2 - a.b2) - (c.b1 - a.b1) * (b.b2 - a.b2);
    }
    return std::fabs(area2);
}

void depositClipped(TileSums& tile, int lane, const float x[3], const float y[3], const float* amounts) {
    const double xs[3] = {x[0], x[1], x[2]}, ys[3] = {y[0], y[1], y[2]};
    shareAmongCells(xs, ys, tile.columns, {0, tile.rows}, [&](int row, int column, double fraction) {
        addToVoxel(tile, lane, row, column, amounts, fraction);
    });
}

double meanClamped(double a, double b, double c) {
    // Mean of max(f, 0) over a triangle with corner values a, b, c: the second divided difference of f^3 / 3
    // (Hermite-Genocchi), written without cancellation by the number of positive corners.
    const auto meanPositive = [](double p, double q, double r) {
        const auto [low, high] = std::minmax({p, q, r});
        const double middle = p + q + r - low - high;
        if (low >= 0) return (low + middle + high) / 3;
        if (high <= 0) return 0.0;
        if (middle <= 0) return high * high * high / (3 * (high - low) * (high - middle));
        // One corner below: the mean of f plus the mean of its negative part, which is -low^3 / (3 (..)(..)) likewise.
        return (low + middle + high) / 3 - low * low * low / (3 * (middle - low) * (high - low));
    };
    return meanPositive(a, b, c) - meanPositive(a - 1, b - 1, c - 1);
}

double fractionInside(const double x[3], const double y[3], double width, double height) {
    const auto [least_x, most_x] = std::minmax({x[0], x[1], x[2]});
    const auto [least_y, most_y] = std::minmax({y[0], y[1], y[2]});
    if (most_x <= 0 || least_x >= width || most_y <= 0 || least_y >= height) return 0;
    const bool sides[4] = {least_x<0, most_x> width, least_y<0, most_y> height};
    const int crossed = sides[0] + sides[1] + sides[2] + sides[3];
    if (crossed == 0) return 1;
    if (crossed == 1) {
        // One side: the share where a linear function is positive has a closed form.
        if (sides[0]) return positiveShare(x[0], x[1], x[2]);
        if (sides[1]) return positiveShare(width - x[0], width - x[1], width - x[2]);
        if (sides[2]) return positiveShare(y[0], y[1], y[2]);
        return positiveShare(height - y[0], height - y[1], height - y[2]);
    }
    ClipPolygon p = wholeTriangle(x, y);
    if (sides[0]) p = clip<&ClipPoint::x>(p, 0, 1);
    if (sides[1]) p = clip<&ClipPoint::x>(p, width, -1);
    if (sides[2]) p = clip<&ClipPoint::y>(p, 0, 1);
    if (sides[3]) p = clip<&ClipPoint::y>(p, height, -1);
    return p.count < 3 ? 0.0 : sourceFraction(p);
}

}  // namespace photic
