// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/water_slopes.h"

#include <cmath>
#include <string>

namespace photic::runtime {
namespace {

/// Derivative at sample i of a line of `count` heights, `stride` floats apart, by the spacing `h`.
double slope(const float* line, std::size_t stride, int i, int count, double h, WaterOutside outside) {
    const auto at = [&](int k) {
        const int wrapped = outside == WaterOutside::Periodic ? (k + count) % count : k;
        return static_cast<double>(line[static_cast<std::size_t>(wrapped) * stride]);
    };
    if (outside == WaterOutside::Periodic || (i >= 2 && i < count - 2)) {
        return (8 * (at(i + 1) - at(i - 1)) - (at(i + 2) - at(i - 2))) / (12 * h);
    }
    if (i >= 1 && i < count - 1) return (at(i + 1) - at(i - 1)) / (2 * h);
    const int inward = i == 0 ? 1 : -1;
    return inward * (4 * at(i + inward) - 3 * at(i) - at(i + 2 * inward)) / (2 * h);
}

/// The fourth-order slopes of samples that have two neighbours on each side, as slope() has them: a line that compilers
/// make vectors of.
/// @param out  every fourth float
void insideSlopes(const float* before2, const float* before, const float* behind, const float* behind2, int count,
                  double h, float* out) {
    const double by = 1 / (12 * h);
    for (int i = 0; i < count; ++i) {
        const double near = static_cast<double>(behind[i]) - static_cast<double>(before[i]);
        const double far = static_cast<double>(behind2[i]) - static_cast<double>(before2[i]);
        out[4 * static_cast<std::size_t>(i)] = static_cast<float>((8 * near - far) * by);
    }
}

/// Slopes along x of one row.
void slopesAlong(const WaterHeights& w, int row, double h, float* out) {
    const float* line = w.heights + static_cast<std::size_t>(row) * static_cast<std::size_t>(w.columns);
    if (w.columns > 4) insideSlopes(line, line + 1, line + 3, line + 4, w.columns - 4, h, out + 8);
    for (const int i : {0, 1, w.columns - 2, w.columns - 1})
        out[4 * i] = static_cast<float>(slope(line, 1, i, w.columns, h, w.outside));
}

/// Slopes along y of one row.
void slopesAcross(const WaterHeights& w, int row, double h, float* out) {
    const auto columns = static_cast<std::size_t>(w.columns);
    if (w.outside == WaterOutside::Periodic || (row >= 2 && row < w.rows - 2)) {
        const auto line = [&](int k) {
            return w.heights + static_cast<std::size_t>((row + k + w.rows) % w.rows) * columns;
        };
        insideSlopes(line(-2), line(-1), line(1), line(2), w.columns, h, out);
        return;
    }
    for (int i = 0; i < w.columns; ++i)
        out[4 * i] = static_cast<float>(slope(w.heights + i, columns, row, w.rows, h, w.outside));
}

}  // namespace

Result<WaterTexels> waterTexels(const WaterHeights& water) {
    if (!water.heights) return Error{ErrorCode::Usage, "WaterHeights::heights is null"};
    if (water.columns < 4 || water.rows < 4) {
        return Error{ErrorCode::Usage, "the water has " + std::to_string(water.columns) + " x " +
                                           std::to_string(water.rows) + " heights; slopes need 4 x 4"};
    }
    if (!(water.size[0] > 0) || !(water.size[1] > 0) || !std::isfinite(water.size[0]) ||
        !std::isfinite(water.size[1]) || !std::isfinite(water.corner[0]) || !std::isfinite(water.corner[1]) ||
        !std::isfinite(water.level)) {
        return Error{ErrorCode::Usage, "the water's corner, size or level is not finite, or its size not above 0 m"};
    }
    const auto columns = static_cast<std::size_t>(water.columns), rows = static_cast<std::size_t>(water.rows);
    WaterTexels out;
    out.values.resize(columns * rows * 4);
    const double dx = water.size[0] / water.columns, dy = water.size[1] / water.rows;
    double sum[3] = {0, 0, 0};
    for (std::size_t j = 0; j < rows; ++j) {
        float* row = &out.values[j * columns * 4];
        const float* heights = water.heights + j * columns;
        slopesAlong(water, static_cast<int>(j), dx, row + 1);
        slopesAcross(water, static_cast<int>(j), dy, row + 2);
        float all = 0;  // what is not finite makes it so
        for (std::size_t i = 0; i < columns; ++i) {
            row[4 * i] = heights[i];
            all += 0 * heights[i];
            const double sx = row[4 * i + 1], sy = row[4 * i + 2];
            sum[0] += sx * sx, sum[1] += sx * sy, sum[2] += sy * sy;
        }
        if (std::isfinite(all)) continue;
        std::size_t i = 0;
        while (std::isfinite(heights[i])) ++i;
        return Error{ErrorCode::Usage, "height (" + std::to_string(i) + ", " + std::to_string(j) + ") is not finite"};
    }
    const double count = static_cast<double>(columns * rows);
    for (int k = 0; k < 3; ++k) out.covariance[k] = sum[k] / count;
    return out;
}

LookupCovariance lookupCovariance(const float* direction, double ior, const double* c, LookupAxes axes) {
    // A ray at angle `from` to the vertical leaves at `to`; where the surface tilts by s in the plane of incidence, it
    // turns by s (n cos(from) / cos(to) - 1), across it by s (n cos(from) - cos(to)). A reflected ray turns by 2 s and
    // 2 s cos.
    const double dx = direction[0], dy = direction[1], cos_air = -direction[2], sin_air = std::hypot(dx, dy);
    const double n_cos_water = std::sqrt(ior * ior - sin_air * sin_air);
    const double across_below = n_cos_water - cos_air, across_above = 2 * cos_air;
    // Unit, along the sun's level direction; any, where it stands at the zenith.
    const double hx = sin_air > 1e-6 ? dx / sin_air : 1, hy = sin_air > 1e-6 ? dy / sin_air : 0;
    // Variance of the slope along the plane of incidence, covariance, and variance across it.
    const double along = hx * hx * c[0] + 2 * hx * hy * c[1] + hy * hy * c[2];
    const double mixed = -hx * hy * c[0] + (hx * hx - hy * hy) * c[1] + hx * hy * c[2];
    const double across = hy * hy * c[0] - 2 * hx * hy * c[1] + hx * hx * c[2];
    // The first axis, +x made perpendicular to the sun, in the two directions of turning.
    const double length = std::sqrt(1 - dx * dx), in_plane = hx * cos_air / length, aside = -hy / length;
    const auto moments = [&](double factor, double* trace, double* determinant) {
        const double p = factor / cos_air, q = factor;
        const double pp = p * p * along, pq = p * q * mixed, qq = q * q * across;
        if (axes == LookupAxes::Both) {
            *trace = pp + qq, *determinant = pp * qq - pq * pq;
        } else {
            *trace = in_plane * in_plane * pp + 2 * in_plane * aside * pq + aside * aside * qq, *determinant = 0;
        }
    };
    LookupCovariance out;
    moments(across_below, &out.trace_below, &out.determinant_below);
    moments(across_above, &out.trace_above, &out.determinant_above);
    return out;
}

}  // namespace photic::runtime
