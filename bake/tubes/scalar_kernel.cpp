// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "bake/tubes/edge_kernel.h"

namespace photic {
namespace {

// As linear_density_impl.h, one tube and one layer at a time.
struct Around {
    double step[2][2] = {};
    double density = 0;
};

Around aroundCorner(const TubeSet& set, const TubeBlock& block, int corner, double layers, double part) {
    const CornerSpread& spread = set.spreads[block.first_corner + static_cast<std::uint32_t>(corner)];
    Around out;
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) out.step[a][b] = spread.step[a][b] + layers * spread.step_per_layer[a][b];
    const double area = out.step[0][0] * out.step[1][1] - out.step[0][1] * out.step[1][0];
    const double mean_extinction = (set.extinction.x + set.extinction.y + set.extinction.z) / 3;
    out.density =
        area == 0 ? 0 : part * spread.power / area * std::exp(-mean_extinction * spread.length * std::fabs(layers));
    return out;
}

// What a tube's curved sides leave to its neighbours, per irradiance.
double handedOn(const TubeSet& set, const TubeBlock& block, const std::uint8_t* c, const float* x, const float* y,
                const Around* around) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const int m = c[i], n = c[(i + 1) % 3];
        const CornerSpread &a = set.spreads[block.first_corner + static_cast<std::uint32_t>(m)],
                           &b = set.spreads[block.first_corner + static_cast<std::uint32_t>(n)];
        if (!(around[m].density * around[n].density > 0)) continue;
        double t[2];
        for (int k = 0; k < 2; ++k)
            t[k] = (b.column - a.column) * (around[m].step[0][k] - around[n].step[0][k]) +
                   (b.row - a.row) * (around[m].step[1][k] - around[n].step[1][k]);
        const double limit = kMostHandedOn * std::min(a.power, b.power);
        sum += std::clamp(
            0.5 * (around[m].density + around[n].density) * (t[0] * (y[n] - y[m]) - t[1] * (x[n] - x[m])) / 12, -limit,
            limit);
    }
    return sum;
}

// Densities at the corners of a tube, per channel, in multiples of the channel's mean; false: constant.
bool linearDensities(const TubeSet& set, const TubeBlock& block, std::size_t t, std::array<double, 3> x,
                     std::array<double, 3> y, const Around* around, int irradiance_channels, CornerDensities* density) {
    if (set.spreads.empty()) return false;
    const std::uint8_t* c = block.topology->triangles[t].corner;
    const double f[3] = {around[c[0]].density, around[c[1]].density, around[c[2]].density};
    const double area2 = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    double size = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        size = std::max(size, (x[j] - x[i]) * (x[j] - x[i]) + (y[j] - y[i]) * (y[j] - y[i]));
    }
    if (std::fabs(area2) < std::max(size * 1e-3, 1e-6)) return false;
    const bool alike = f[0] * f[1] > 0 && f[1] * f[2] > 0;
    const CornerSpread* spreads = &set.spreads[block.first_corner];
    const TubeConstants& tube = set.tubes[block.first_tube + t];
    double relative[3], gradient_x = 0, gradient_y = 0, turn_x[3] = {}, turn_y[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        relative[i] = alike ? 3 * f[i] / (f[0] + f[1] + f[2]) : 1;
        const double slope_x = (y[j] - y[k]) / area2, slope_y = (x[k] - x[j]) / area2;
        gradient_x += relative[i] * slope_x, gradient_y += relative[i] * slope_y;
        for (int m = 0; m < 3; ++m) {
            const double turn = (spreads[c[i]].travel[m] - tube.travel[m]) / tube.length;
            turn_x[m] += turn * slope_x, turn_y[m] += turn * slope_y;
        }
    }
    double steep = std::max({std::fabs(gradient_x), std::fabs(gradient_y), static_cast<double>(kSteepestSlope)});
    const CornerSpread &first = spreads[c[0]], &second = spreads[c[1]], &third = spreads[c[2]];
    steep = std::max(steep, std::fabs(f[0] + f[1] + f[2]) * kSteepestSlope /
                                (3 * kBrightestSlope * unfocused(first, second, third)));
    for (int m = 0; m < 3; ++m) steep = std::max({steep, std::fabs(turn_x[m]), std::fabs(turn_y[m])});
    const double ratio = kSteepestSlope / steep;
    const double kept = ratio * ratio;
    for (double& r : relative) r = 1 + kept * (r - 1);
    const auto channel = [&](CornerDensities& out, double mean, double a, double b, double d) {
        const double values[3] = {relative[0] * (mean + kept * (a - mean)), relative[1] * (mean + kept * (b - mean)),
                                  relative[2] * (mean + kept * (d - mean))};
        const double correction = mean - (values[0] + values[1] + values[2]) / 3;
        for (std::size_t i = 0; i < 3; ++i) out[i] = mean == 0 ? 1 : (values[i] + correction) / mean;
    };
    for (int k = 0; k < irradiance_channels; ++k)
        channel(density[k], tube.length, first.length, second.length, third.length);
    for (int k = 0; k < 3; ++k)
        channel(density[irradiance_channels + k], tube.travel[k], first.travel[k], second.travel[k], third.travel[k]);
    return true;
}

// The share of a tube's layer that this tile counts for the ledger: what lies in the rectangle, if the tile holds the
// centroid.
double ownedShare(const TileSums& tile, int lane, const float* x, const float* y, const double* density) {
    const int shift[2] = {tile.u0 + tile.shift_u[lane], tile.v0 + tile.shift_v[lane]};
    const int low[2] = {tile.rect_min_u - shift[0], tile.rect_min_v - shift[1]},
              high[2] = {tile.rect_max_u - shift[0], tile.rect_max_v - shift[1]};
    const int first[2] = {tile.tile_min_u - shift[0], tile.tile_min_v - shift[1]},
              end[2] = {tile.tile_max_u - shift[0], tile.tile_max_v - shift[1]};
    for (int a = 0; a < 2; ++a) {
        const float* p = a ? y : x;
        const double centre = std::clamp((p[0] + p[1] + p[2]) / 3.0, static_cast<double>(low[a]), high[a] - 1e-3);
        if (centre < first[a] || centre >= end[a]) return 0;
    }
    const double xs[3] = {x[0] - low[0], x[1] - low[0], x[2] - low[0]},
                 ys[3] = {y[0] - low[1], y[1] - low[1], y[2] - low[1]};
    return fractionInside(xs, ys, high[0] - low[0], high[1] - low[1], density);
}

}  // namespace

void scalarKernel(const TubeSet& set, const std::uint32_t* blocks, int block_count, TileSums& tile) {
    const int irradiance = tile.channels >= 3 && set.channels == 3 ? 3 : 1;
    const bool flux = tile.channels > irradiance;
    for (int b = 0; b < block_count; ++b) {
        const TubeBlock& block = set.blocks[blocks[b]];
        for (int lane = 0; lane < tile.lanes; ++lane) {
            const int w = tile.first_w + lane;
            float xs[256], ys[256], open[256];
            Around around[256];
            for (int i = 0; i < block.topology->vertex_count; ++i) {
                const CornerRay& c = set.corners[block.first_corner + static_cast<std::uint32_t>(i)];
                open[i] = static_cast<float>(set.sense * (w - c.w) + 0.5);
                const double part = std::clamp(open[i], 0.0f, 1.0f);
                const double dw = w - c.w + set.sense * (0.5 - part * (1.0 - tile.layer_offset));
                xs[i] = static_cast<float>(c.u + c.du_dw * dw + 0.5 - tile.u0 - tile.shift_u[lane]);
                if (!set.spreads.empty()) around[i] = aroundCorner(set, block, i, dw, part);
                ys[i] = static_cast<float>(c.v + c.dv_dw * dw + 0.5 - tile.v0 - tile.shift_v[lane]);
            }
            for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
                const std::uint8_t* c = block.topology->triangles[t].corner;
                const TubeConstants& tube = set.tubes[block.first_tube + t];
                const CornerRay* corners = &set.corners[block.first_corner];
                const double length = meanClamped(open[c[0]], open[c[1]], open[c[2]]);
                double end = -1e300;
                for (int i = 0; i < 3; ++i)
                    end = std::max(end, set.sense * (corners[c[i]].w_end - static_cast<double>(w)));
                if (length <= 0 || end - 1e-3 <= -0.5) continue;
                const double start = (corners[c[0]].w + corners[c[1]].w + corners[c[2]].w) / 3;
                const double layers = std::max(set.sense * (w - start) - 0.5, 0.0);
                const double handed_on = set.spreads.empty() ? 0 : handedOn(set, block, c, xs, ys, around);
                float amounts[6];
                double mean = 0;
                for (int k = 0; k < irradiance; ++k) {
                    double amount = tube.power[k] * length * tile.layer_weight;
                    if (set.extinction[k] > 0) {
                        const double depth = set.extinction[k] * tube.length * length;
                        amount *= std::exp(-set.extinction[k] * tube.length * layers) * -std::expm1(-depth) / depth;
                    }
                    amount -= set.irradiance[k] * tile.layer_weight * handed_on;
                    amounts[k] = static_cast<float>(amount) * tube.length;
                    mean += amount / irradiance;
                }
                if (flux)
                    for (int k = 0; k < 3; ++k) amounts[irradiance + k] = static_cast<float>(mean) * tube.travel[k];
                CornerDensities density[6];
                const bool linear = linearDensities(set, block, t, {xs[c[0]], xs[c[1]], xs[c[2]]},
                                                    {ys[c[0]], ys[c[1]], ys[c[2]]}, around, irradiance, density);
                const float x[3] = {xs[c[0]], xs[c[1]], xs[c[2]]}, y[3] = {ys[c[0]], ys[c[1]], ys[c[2]]};
                depositClipped(tile, lane, x, y, amounts, linear ? density : nullptr);
                if (lane < tile.active_lanes) {
                    double mean_amount = 0;
                    for (int k = 0; k < irradiance; ++k) mean_amount += amounts[k] / static_cast<double>(irradiance);
                    tile.expected += mean_amount * ownedShare(tile, lane, x, y, linear ? density[0].data() : nullptr);
                }
            }
        }
    }
}

}  // namespace photic
