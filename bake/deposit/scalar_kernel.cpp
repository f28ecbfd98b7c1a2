// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "bake/deposit/edge_kernel.h"

namespace photic {
namespace {

// The share of a tube's layer that this tile counts for the ledger: what lies in the rectangle, if the tile holds the
// centroid.
double ownedShare(const TileSums& tile, int lane, const float* x, const float* y) {
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
    return fractionInside(xs, ys, high[0] - low[0], high[1] - low[1]);
}

// What a tube leaves in a layer, per channel [W m]: power x transmittance x open length, and the same times direction.
struct LayerAmounts {
    float values[6];
    double mean_irradiance = 0;  // of the irradiance channels
};

LayerAmounts amountsOf(const TubeConstants& tube, const glm::dvec3& extinction, double length, double layers_before,
                       const TileSums& tile, int irradiance) {
    LayerAmounts out{};
    double mean = 0;
    for (int k = 0; k < irradiance; ++k) {
        double amount = tube.power[k] * length * tile.layer_weight;
        if (extinction[k] > 0) {
            const double depth = extinction[k] * tube.length * length;
            amount *= std::exp(-extinction[k] * tube.length * layers_before) * -std::expm1(-depth) / depth;
        }
        out.values[k] = static_cast<float>(amount) * tube.length;
        mean += amount / irradiance;
        out.mean_irradiance += out.values[k] / static_cast<double>(irradiance);
    }
    if (tile.channels > irradiance)
        for (int k = 0; k < 3; ++k) out.values[irradiance + k] = static_cast<float>(mean) * tube.travel[k];
    return out;
}

// One block in one layer, tube by tube.
void addBlockLayer(const TubeSet& set, const TubeBlock& block, int lane, TileSums& tile) {
    const int irradiance = tile.channels >= 3 && set.channels == 3 ? 3 : 1, w = tile.first_w + lane;
    const CornerRay* corners = &set.corners[block.first_corner];
    float xs[256], ys[256];
    double opened[256], closed[256];  // how far into the layer each ray starts and ends, along the light
    for (int i = 0; i < block.topology->vertex_count; ++i) {
        const CornerRay& c = corners[i];
        opened[i] = set.sense * (w - c.w) + 0.5, closed[i] = set.sense * (w - c.w_end) + 0.5;
        const double from = 1 - std::clamp(opened[i], 0.0, 1.0), to = 1 - std::clamp(closed[i], 0.0, 1.0);
        const double dw = w - c.w + set.sense * (from + tile.layer_offset * (to - from) - 0.5);
        xs[i] = static_cast<float>(c.u + c.du_dw * dw + 0.5 - tile.u0 - tile.shift_u[lane]);
        ys[i] = static_cast<float>(c.v + c.dv_dw * dw + 0.5 - tile.v0 - tile.shift_v[lane]);
    }
    for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
        const std::uint8_t* c = block.topology->triangles[t].corner;
        const double length = meanClamped(opened[c[0]], opened[c[1]], opened[c[2]]) -
                              meanClamped(closed[c[0]], closed[c[1]], closed[c[2]]);
        if (length <= 0) continue;
        const double start = (corners[c[0]].w + corners[c[1]].w + corners[c[2]].w) / 3;
        const LayerAmounts amounts = amountsOf(set.tubes[block.first_tube + t], block.extinction, length,
                                               std::max(set.sense * (w - start) - 0.5, 0.0), tile, irradiance);
        const float x[3] = {xs[c[0]], xs[c[1]], xs[c[2]]}, y[3] = {ys[c[0]], ys[c[1]], ys[c[2]]};
        depositClipped(tile, lane, x, y, amounts.values);
        if (lane < tile.active_lanes) tile.expected += amounts.mean_irradiance * ownedShare(tile, lane, x, y);
    }
}

}  // namespace

void scalarKernel(const TubeSet& set, const std::uint32_t* blocks, int block_count, TileSums& tile) {
    for (int b = 0; b < block_count; ++b)
        for (int lane = 0; lane < tile.lanes; ++lane) addBlockLayer(set, set.blocks[blocks[b]], lane, tile);
}

}  // namespace photic
