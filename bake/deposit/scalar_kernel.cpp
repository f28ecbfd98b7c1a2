// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "bake/deposit/edge_kernel.h"
#include "bake/tubes/bent_rows.h"

namespace photic {
namespace {

// The share of a tube's layer that lies in the rectangle of processed tiles.
double shareInRectangle(const TileSums& tile, int lane, const float* x, const float* y) {
    const int low[2] = {tile.rect_min_u - tile.u0 - tile.shift_u[lane], tile.rect_min_v - tile.v0 - tile.shift_v[lane]};
    const double xs[3] = {x[0] - low[0], x[1] - low[0], x[2] - low[0]},
                 ys[3] = {y[0] - low[1], y[1] - low[1], y[2] - low[1]};
    return fractionInside(xs, ys, tile.rect_max_u - tile.rect_min_u, tile.rect_max_v - tile.rect_min_v);
}

// Where a corner meets the plane of a layer [voxels]: between where its ray starts and where it ends there.
struct PlaceOnLayer {
    double u = 0, v = 0;
    double opened = 0, closed = 0;  // how far into the layer the ray starts and ends, along the light
};

PlaceOnLayer placeOnLayer(const TileSums& tile, const TubeSet& set, std::uint32_t corner, int lane) {
    const CornerRay& c = set.corners[corner];
    const double layer = tile.first_w + lane - c.w;
    PlaceOnLayer at;
    at.opened = set.sense * layer + 0.5, at.closed = set.sense * (tile.first_w + lane - c.w_end) + 0.5;
    const double from = 1 - std::clamp(at.opened, 0.0, 1.0), to = 1 - std::clamp(at.closed, 0.0, 1.0);
    const double beyond = set.sense * (from + tile.layer_offset * (to - from) - 0.5);
    if (!tile.bent) {
        at.u = c.u + c.du_dw * (layer + beyond), at.v = c.v + c.dv_dw * (layer + beyond);
        return at;
    }
    const float* rows = tile.bent->of(corner) + lane;
    const auto row = [&](int which) { return static_cast<double>(rows[which * BentRows::kLanes]); };
    at.u = row(BentRows::kU) + row(BentRows::kSlopeU) * beyond + tile.bent->first_column[0];
    at.v = row(BentRows::kV) + row(BentRows::kSlopeV) * beyond + tile.bent->first_column[1];
    return at;
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
    PlaceOnLayer at[256];
    float xs[256], ys[256];
    for (int i = 0; i < block.topology->vertex_count; ++i) {
        at[i] = placeOnLayer(tile, set, block.first_corner + static_cast<std::uint32_t>(i), lane);
        xs[i] = static_cast<float>(at[i].u + 0.5 - tile.u0 - tile.shift_u[lane]);
        ys[i] = static_cast<float>(at[i].v + 0.5 - tile.v0 - tile.shift_v[lane]);
    }
    for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
        const std::uint8_t* c = block.topology->triangles[t].corner;
        const double length = meanClamped(at[c[0]].opened, at[c[1]].opened, at[c[2]].opened) -
                              meanClamped(at[c[0]].closed, at[c[1]].closed, at[c[2]].closed);
        if (length <= 0) continue;
        const double start = (corners[c[0]].w + corners[c[1]].w + corners[c[2]].w) / 3;
        const LayerAmounts amounts = amountsOf(set.tubes[block.first_tube + t], block.extinction, length,
                                               std::max(set.sense * (w - start) - 0.5, 0.0), tile, irradiance);
        const float x[3] = {xs[c[0]], xs[c[1]], xs[c[2]]}, y[3] = {ys[c[0]], ys[c[1]], ys[c[2]]};
        depositClipped(tile, lane, x, y, amounts.values);
        if (lane < tile.active_lanes && ownsTubeLayer(tile, set, block.first_corner, c, lane))
            tile.expected += amounts.mean_irradiance * shareInRectangle(tile, lane, x, y);
    }
}

}  // namespace

bool ownsTubeLayer(const TileSums& tile, const TubeSet& set, std::uint32_t first_corner, const std::uint8_t c[3],
                   int lane) {
    double u = 0.5, v = 0.5;
    for (int i = 0; i < 3; ++i) {
        const PlaceOnLayer at = placeOnLayer(tile, set, first_corner + c[i], lane);
        u += at.u / 3, v += at.v / 3;
    }
    const auto moved = [](double x, int low, int high) { return std::clamp<double>(x, low, high - 1e-3); };
    u = moved(u, tile.rect_min_u, tile.rect_max_u), v = moved(v, tile.rect_min_v, tile.rect_max_v);
    return u >= tile.tile_min_u && u < tile.tile_max_u && v >= tile.tile_min_v && v < tile.tile_max_v;
}

void scalarKernel(const TubeSet& set, const std::uint32_t* blocks, int block_count, TileSums& tile) {
    for (int b = 0; b < block_count; ++b)
        for (int lane = 0; lane < tile.lanes; ++lane) addBlockLayer(set, set.blocks[blocks[b]], lane, tile);
}

}  // namespace photic
