// SPDX-License-Identifier: Apache-2.0
// The edge kernel, once per instruction set: exact signed area coverage as analytic font rasterisers accumulate it, for
// 4, 8 or 16 layers of voxels at a time. Derivation: docs/methods.md, "The edge kernel".
#pragma once

#include <algorithm>
#include <cmath>

#include "bake/deposit/edge_kernel.h"
#include "bake/simd/lanes.h"
#include "bake/tubes/bent_rows.h"

namespace photic::PHOTIC_ISA {

constexpr int kMaxCorners = 256;
constexpr int kMaxTubes = 256;

/// A block's corners and tube densities on the layers of a slab.
template <class V, int kDensities, int kLeaning>
struct BlockLayers {
    V x[kMaxCorners], y[kMaxCorners];
    // Of bent legs, which lean differently in each layer: how far along u and v [m], the path [m], whether it counts,
    // and what is left of the power per channel.
    V lean_u[kLeaning], lean_v[kLeaning], path[kLeaning], lit[kLeaning], left[kLeaning][3];
    V opened[kMaxCorners],
        closed[kMaxCorners];  // how far into a layer the ray starts and ends: 1 where it has all passed
    float least_opened[kMaxCorners], most_closed[kMaxCorners];  // over the lanes
    float min_x[kMaxCorners], max_x[kMaxCorners], min_y[kMaxCorners], max_y[kMaxCorners];
    V density[kMaxTubes][kDensities];
    bool present[kMaxTubes];
};

template <class V, int kIrradiance, bool kFlux, bool kBent>
class SlabKernel {
    static constexpr int kLanes = laneCount<V>;
    static constexpr int kChannels = kIrradiance + (kFlux ? 3 : 0);
    static constexpr int kCell = kChannels * kLanes;
    // Bent legs lean differently in each layer: what straight ones have once for all layers is in their densities.
    static constexpr int kDensities = kBent ? kChannels : kIrradiance;

public:
    SlabKernel(const TubeSet& set, TileSums& tile) : set_(set), tile_(tile) {
        for (int l = 0; l < kLanes; ++l) {
            shift_u_[l] = static_cast<float>(tile.shift_u[l]);
            shift_v_[l] = static_cast<float>(tile.shift_v[l]);
            counted_[l] = l < tile.active_lanes ? 1.0f : 0.0f;
        }
        // Origins are subtracted as integers: far from the world's origin single precision does not hold them.
        rect_low_u_ = static_cast<float>(tile.rect_min_u - tile.u0) - shift_u_;
        rect_high_u_ = static_cast<float>(tile.rect_max_u - tile.u0) - shift_u_;
        rect_low_v_ = static_cast<float>(tile.rect_min_v - tile.v0) - shift_v_;
        rect_high_v_ = static_cast<float>(tile.rect_max_v - tile.v0) - shift_v_;
        tile_low_u_ = borderAt(tile.tile_min_u, tile.rect_min_u, tile.u0, -kFar) - shift_u_;
        tile_high_u_ = borderAt(tile.tile_max_u, tile.rect_max_u, tile.u0, kFar) - shift_u_;
        tile_low_v_ = borderAt(tile.tile_min_v, tile.rect_min_v, tile.v0, -kFar) - shift_v_;
        tile_high_v_ = borderAt(tile.tile_max_v, tile.rect_max_v, tile.v0, kFar) - shift_v_;
    }

    void add(const TubeBlock& block) {
        placeCorners(block);
        if (!computeDensities(block)) return;
        for (const auto& edge : block.topology->edges) addEdge(block, edge);
    }

private:
    static constexpr float kFar = 3.0e30f;
    // Places are known in single precision: tubes that miss the buffer by less are looked at all the same, and the
    // seam beside those whose centroid is nearer to it is decided in double precision.
    static constexpr float kNear = 1.0e-2f;

    // A tile's border in the buffer: what is past the rectangle's own border is moved into it, to the tile there.
    static float borderAt(int tile, int rectangle, int origin, float past) {
        return tile == rectangle ? past : static_cast<float>(tile - origin);
    }

    // Where each corner ray meets the planes of the slab, in the buffer's columns and rows.
    void placeCorners(const TubeBlock& block) {
        const V lane = iota<V>();
        const float sense = static_cast<float>(set_.sense);
        const float offset = static_cast<float>(tile_.layer_offset);
        for (int i = 0; i < block.topology->vertex_count; ++i) {
            const CornerRay& c = set_.corners[block.first_corner + static_cast<std::uint32_t>(i)];
            const double dw = tile_.first_w - c.w;
            // The parts of each layer that lie past the ray's start and past its end, along the light: 1 and 0 but for
            // the layers in which it starts or ends.
            const V zero = splat<V>(0.0f), one = splat<V>(1.0f);
            const V opened = static_cast<float>(set_.sense * dw + 0.5) + sense * lane;
            const V closed = static_cast<float>(farthest(set_.sense * (tile_.first_w - c.w_end) + 0.5)) + sense * lane;
            // The plane lies in the middle of the part between them (or at the Gauss point of it).
            const V from = 1.0f - clampTo(opened, zero, one), to = 1.0f - clampTo(closed, zero, one);
            const V plane = lane + sense * (from + offset * (to - from) - 0.5f);
            V x, y;
            if constexpr (kBent) {
                const float* rows = tile_.bent->of(block.first_corner + static_cast<std::uint32_t>(i));
                const V beyond = plane - lane;  // the middle of the layer
                x = load<V>(rows + BentRows::kU * BentRows::kLanes) +
                    load<V>(rows + BentRows::kSlopeU * BentRows::kLanes) * beyond +
                    (0.5f - static_cast<float>(tile_.u0 - tile_.bent->first_column[0])) - shift_u_;
                y = load<V>(rows + BentRows::kV * BentRows::kLanes) +
                    load<V>(rows + BentRows::kSlopeV * BentRows::kLanes) * beyond +
                    (0.5f - static_cast<float>(tile_.v0 - tile_.bent->first_column[1])) - shift_v_;
                leanCorner(i, rows);
            } else {
                x = static_cast<float>(c.u + c.du_dw * dw + 0.5 - tile_.u0) + static_cast<float>(c.du_dw) * plane -
                    shift_u_;
                y = static_cast<float>(c.v + c.dv_dw * dw + 0.5 - tile_.v0) + static_cast<float>(c.dv_dw) * plane -
                    shift_v_;
            }
            at_.x[i] = x, at_.y[i] = y, at_.opened[i] = opened, at_.closed[i] = closed;
            at_.least_opened[i] = opened[set_.sense > 0 ? 0 : kLanes - 1];
            at_.most_closed[i] = closed[set_.sense > 0 ? kLanes - 1 : 0];
            at_.min_x[i] = leastLane(x), at_.max_x[i] = mostLane(x);
            at_.min_y[i] = leastLane(y), at_.max_y[i] = mostLane(y);
        }
    }

    void leanCorner(int i, const float* rows) {
        const BentRows& bent = *tile_.bent;
        const V u = bent.voxel[0] * load<V>(rows + BentRows::kSlopeU * BentRows::kLanes),
                v = bent.voxel[1] * load<V>(rows + BentRows::kSlopeV * BentRows::kLanes);
        at_.lean_u[i] = u, at_.lean_v[i] = v;
        at_.path[i] = squareRoot(u * u + v * v + splat<V>(bent.voxel[2] * bent.voxel[2]));
        at_.lit[i] = load<V>(rows + BentRows::kLit * BentRows::kLanes);
        for (int k = 0; k < kIrradiance; ++k) at_.left[i][k] = load<V>(rows + (BentRows::kLeft + k) * BentRows::kLanes);
    }

    // Ends may lie at infinity: far enough for any grid is enough for single precision.
    static double farthest(double layers) { return layers < -1.0e6 ? -1.0e6 : layers > 1.0e6 ? 1.0e6 : layers; }

    static float least3(const float* m, const std::uint8_t* c) {
        const float a = m[c[0]] < m[c[1]] ? m[c[0]] : m[c[1]];
        return a < m[c[2]] ? a : m[c[2]];
    }
    static float most3(const float* m, const std::uint8_t* c) {
        const float a = m[c[0]] > m[c[1]] ? m[c[0]] : m[c[1]];
        return a > m[c[2]] ? a : m[c[2]];
    }

    // Power x transmittance x open length / signed area of each tube; false when no tube touches the tile.
    bool computeDensities(const TubeBlock& block) {
        bool any = false;
        const auto& triangles = block.topology->triangles;
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const std::uint8_t* c = triangles[t].corner;
            const TubeConstants& tube = set_.tubes[block.first_tube + t];
            at_.present[t] = false;
            if (least3(at_.min_x, c) > static_cast<float>(tile_.columns) + kNear || most3(at_.max_x, c) < -kNear ||
                least3(at_.min_y, c) > static_cast<float>(tile_.rows) + kNear || most3(at_.max_y, c) < -kNear)
                continue;
            V length;
            if (!openLength(c, length)) continue;
            at_.present[t] = any = true;
            if constexpr (kBent)
                bentDensityOf(tube, block, t, c, length);
            else
                densityOf(tube, block, t, c, length);
        }
        return any;
    }

    // Mean part of the layers between the tube's two ends, 0..1, exact in total: where segments follow one another, one
    // takes up what the other leaves. False when all layers are empty.
    bool openLength(const std::uint8_t* c, V& length) {
        length = splat<V>(1.0f);
        if (least3(at_.least_opened, c) < 1.0f) {
            const V *a = &at_.opened[c[0]], *b = &at_.opened[c[1]], *d = &at_.opened[c[2]];
            const V low = least(least(*a, *b), *d);
            for (int l = 0; l < kLanes; ++l)
                if (low[l] < 1.0f) length[l] = static_cast<float>(meanClamped((*a)[l], (*b)[l], (*d)[l]));
        }
        if (most3(at_.most_closed, c) > 0.0f) {
            const V *a = &at_.closed[c[0]], *b = &at_.closed[c[1]], *d = &at_.closed[c[2]];
            const V high = most(most(*a, *b), *d);
            for (int l = 0; l < kLanes; ++l)
                if (high[l] > 0.0f) length[l] -= static_cast<float>(meanClamped((*a)[l], (*b)[l], (*d)[l]));
            length = most(length, splat<V>(0.0f));
        }
        if (mostLane(length) <= 0.0f) return false;
        length = length * tile_.layer_weight;
        return true;
    }

    void densityOf(const TubeConstants& tube, const TubeBlock& block, std::size_t t, const std::uint8_t* c,
                   const V& length) {
        const V x0 = at_.x[c[0]], x1 = at_.x[c[1]], x2 = at_.x[c[2]];
        const V y0 = at_.y[c[0]], y1 = at_.y[c[1]], y2 = at_.y[c[2]];
        const V e1x = x1 - x0, e1y = y1 - y0, e2x = x2 - x0, e2y = y2 - y0;
        const V area2 = differenceOfProducts(e1x, e2y, e2x, e1y);
        V amount[kIrradiance];
        for (int k = 0; k < kIrradiance; ++k) amount[k] = tube.power[k] * length;
        if (block.extinction != glm::dvec3(0)) attenuate(tube, block, c, length, amount);

        const V x[3] = {x0, x1, x2}, y[3] = {y0, y1, y2};
        const V inverse = withoutSlivers(x, y, area2, length, [&](int l, float* amounts) {
            float mean = 0;
            for (int k = 0; k < kIrradiance; ++k) amounts[k] = amount[k][l] * tube.length, mean += amount[k][l];
            if (kFlux)
                for (int k = 0; k < 3; ++k) amounts[kIrradiance + k] = mean * (1.0f / kIrradiance) * tube.travel[k];
        });
        for (int k = 0; k < kIrradiance; ++k) at_.density[t][k] = amount[k] * inverse;
        account(block, c, tube.length, amount);
    }

    // The same where the tube leans differently in each layer: per channel, power x what is left of it x open length x
    // path per layer, and for flux x direction.
    void bentDensityOf(const TubeConstants& tube, const TubeBlock& block, std::size_t t, const std::uint8_t* c,
                       const V& length) {
        V slope_u{}, slope_v{}, per_layer{}, lit{}, left[kIrradiance] = {};
        for (int i = 0; i < 3; ++i) {
            slope_u = slope_u + at_.lean_u[c[i]], slope_v = slope_v + at_.lean_v[c[i]];
            per_layer = per_layer + at_.path[c[i]], lit = lit + at_.lit[c[i]];
            for (int k = 0; k < kIrradiance; ++k) left[k] = left[k] + at_.left[c[i]][k];
        }
        constexpr float kThird = 1.0f / 3;
        V mean{}, amount[kChannels];
        for (int k = 0; k < kIrradiance; ++k) {
            amount[k] = (tube.power[k] * kThird * kThird) * left[k] * lit * length;
            mean = mean + amount[k] * (1.0f / kIrradiance);
            amount[k] = amount[k] * per_layer * kThird;
        }
        if constexpr (kFlux) {
            const float sense = static_cast<float>(set_.sense);
            const auto axes = axesFor(set_.axis);
            amount[kIrradiance + axes[0]] = mean * slope_u * (sense * kThird);
            amount[kIrradiance + axes[1]] = mean * slope_v * (sense * kThird);
            amount[kIrradiance + axes[2]] = mean * (sense * tile_.bent->voxel[2]);
        }
        const V x[3] = {at_.x[c[0]], at_.x[c[1]], at_.x[c[2]]}, y[3] = {at_.y[c[0]], at_.y[c[1]], at_.y[c[2]]};
        const V e1x = x[1] - x[0], e1y = y[1] - y[0], e2x = x[2] - x[0], e2y = y[2] - y[0];
        const V area2 = differenceOfProducts(e1x, e2y, e2x, e1y);
        const V inverse = withoutSlivers(x, y, area2, length, [&](int l, float* amounts) {
            for (int k = 0; k < kChannels; ++k) amounts[k] = amount[k][l];
        });
        for (int k = 0; k < kChannels; ++k) at_.density[t][k] = amount[k] * inverse;
        account(block, c, 1.0f, amount);
    }

    // 2 / area, and 0 in lanes where the tube is a sliver, whose density would drown its neighbours in rounding: it is
    // clipped by itself there, with all that `amountsOf(lane, amounts)` gives.
    template <class Amounts>
    V withoutSlivers(const V* x, const V* y, const V& area2, const V& length, const Amounts& amountsOf) {
        const V e1x = x[1] - x[0], e1y = y[1] - y[0], e2x = x[2] - x[0], e2y = y[2] - y[0];
        const V size = most(most(e1x * e1x + e1y * e1y, e2x * e2x + e2y * e2y),
                            (e2x - e1x) * (e2x - e1x) + (e2y - e1y) * (e2y - e1y));
        V sliver = absolute(area2) - most(size * 1.0e-3f, splat<V>(1.0e-6f));
        // What edges add and take cancels but for its rounding, which is that of a tube's light over its width. Where
        // all light comes together narrow tubes would cost a plane 2e-5 of its flux.
        constexpr float kNarrow = 0.005f;  // voxels
        if constexpr (kBent) sliver = least(sliver, area2 * area2 - size * (kNarrow * kNarrow));
        V inverse = 2.0f / area2;
        if (leastLane(sliver) >= 0.0f) return inverse;
        for (int l = 0; l < kLanes; ++l) {
            if (sliver[l] >= 0.0f) continue;
            inverse[l] = 0.0f;
            if (length[l] <= 0.0f) continue;
            const float xs[3] = {x[0][l], x[1][l], x[2][l]}, ys[3] = {y[0][l], y[1][l], y[2][l]};
            float amounts[6];
            amountsOf(l, amounts);
            depositClipped(tile_, l, xs, ys, amounts);
            ++tile_.degenerate;
        }
        return inverse;
    }

    // Beer-Lambert, averaged over the open part of each layer: exp(-s t) (1 - exp(-s dt)) / (s dt).
    void attenuate(const TubeConstants& tube, const TubeBlock& block, const std::uint8_t* c, const V& length,
                   V* amount) {
        const CornerRay* corners = &set_.corners[block.first_corner];
        const double start = (corners[c[0]].w + corners[c[1]].w + corners[c[2]].w) * (1.0 / 3.0);
        const float sense = static_cast<float>(set_.sense);
        const V layers =
            most(sense * iota<V>() + static_cast<float>(set_.sense * (tile_.first_w - start) - 0.5), splat<V>(0.0f));
        for (int k = 0; k < kIrradiance; ++k) {
            const float per_layer = static_cast<float>(block.extinction[k]) * tube.length;
            const V depth = per_layer * length * (1.0f / tile_.layer_weight);
            // (1 - exp(-d)) / d to fourth order below 0.05, where the quotient would cancel
            const V series = 1.0f - depth * (0.5f - depth * (1.0f / 6 - depth * (1.0f / 24)));
            const V quotient = (1.0f - exponential<V>(-depth)) / most(depth, splat<V>(1.0e-20f));
            amount[k] = amount[k] * exponential<V>(-per_layer * layers) * (depth < 0.05f ? series : quotient);
        }
    }

    // The other side of the path ledger: what this tube must deposit inside the rectangle of processed tiles. The tile
    // that holds the centroid (moved into the rectangle) owns the tube's layer.
    // @param per_layer  path [m] that the amounts are still to be multiplied with
    void account(const TubeBlock& block, const std::uint8_t* c, float per_layer, const V* amount) {
        const V x0 = at_.x[c[0]], x1 = at_.x[c[1]], x2 = at_.x[c[2]];
        const V y0 = at_.y[c[0]], y1 = at_.y[c[1]], y2 = at_.y[c[2]];
        V mean = amount[0];
        if (kIrradiance == 3) mean = (amount[0] + amount[1] + amount[2]) * (1.0f / 3.0f);
        const V cu = (x0 + x1 + x2) * (1.0f / 3.0f), cv = (y0 + y1 + y2) * (1.0f / 3.0f);
        const V least_x = least(least(x0, x1), x2), most_x = most(most(x0, x1), x2);
        const V least_y = least(least(y0, y1), y2), most_y = most(most(y0, y1), y2);
        const V counted = mean * counted_ * per_layer;
        V owned =
            ((cu >= tile_low_u_) & (cu < tile_high_u_) & (cv >= tile_low_v_) & (cv < tile_high_v_) &
             (most_x > rect_low_u_) & (least_x < rect_high_u_) & (most_y > rect_low_v_) & (least_y < rect_high_v_))
                ? counted
                : splat<V>(0.0f);
        const V seam = least(least(absolute(cu - tile_low_u_), absolute(cu - tile_high_u_)),
                             least(absolute(cv - tile_low_v_), absolute(cv - tile_high_v_)));
        if (leastLane(seam) < kNear)
            for (int l = 0; l < kLanes; ++l)
                if (seam[l] < kNear)
                    owned[l] = ownsTubeLayer(tile_, set_, block.first_corner, c, l) ? counted[l] : 0.0f;
        const V margin = least(least(least_x - rect_low_u_, rect_high_u_ - most_x),
                               least(least_y - rect_low_v_, rect_high_v_ - most_y));
        if (leastLane(margin) >= 0.0f) {
            for (int l = 0; l < kLanes; ++l) tile_.expected += static_cast<double>(owned[l]);
            return;
        }
        for (int l = 0; l < kLanes; ++l) {
            if (owned[l] == 0.0f) continue;
            double fraction = 1;
            if (margin[l] < 0.0f) {
                const double xs[3] = {x0[l] - rect_low_u_[l], x1[l] - rect_low_u_[l], x2[l] - rect_low_u_[l]};
                const double ys[3] = {y0[l] - rect_low_v_[l], y1[l] - rect_low_v_[l], y2[l] - rect_low_v_[l]};
                fraction = fractionInside(xs, ys, rect_high_u_[l] - rect_low_u_[l], rect_high_v_[l] - rect_low_v_[l]);
            }
            tile_.expected += fraction * static_cast<double>(owned[l]);
        }
    }

    // What a tube adds on its side of an edge, per channel.
    void addSide(const TubeBlock& block, std::uint8_t t, float sign, V* change) {
        if (t == BlockTopology::kNone || !at_.present[t]) return;
        if constexpr (kBent) {
            for (int k = 0; k < kChannels; ++k) change[k] = change[k] + sign * at_.density[t][k];
            return;
        }
        const TubeConstants& tube = set_.tubes[block.first_tube + t];
        V mean = splat<V>(0.0f);
        for (int k = 0; k < kIrradiance; ++k) {
            change[k] = change[k] + (sign * tube.length) * at_.density[t][k];
            mean = mean + at_.density[t][k];
        }
        if (kFlux)
            for (int k = 0; k < 3; ++k)
                change[kIrradiance + k] = change[kIrradiance + k] + (sign / kIrradiance * tube.travel[k]) * mean;
    }

    // (density right - density left) x the area to the right of the edge, cell by cell.
    void addEdge(const TubeBlock& block, const BlockTopology::Edge& edge) {
        const bool left = edge.left != BlockTopology::kNone && at_.present[edge.left];
        const bool right = edge.right != BlockTopology::kNone && at_.present[edge.right];
        if (!left && !right) return;
        const int a = edge.v0, b = edge.v1;
        const float low_y = at_.min_y[a] < at_.min_y[b] ? at_.min_y[a] : at_.min_y[b];
        const float high_y = at_.max_y[a] > at_.max_y[b] ? at_.max_y[a] : at_.max_y[b];
        const float low_x = at_.min_x[a] < at_.min_x[b] ? at_.min_x[a] : at_.min_x[b];
        const float high_x = at_.max_x[a] > at_.max_x[b] ? at_.max_x[a] : at_.max_x[b];
        const float rows = static_cast<float>(tile_.rows), columns = static_cast<float>(tile_.columns);
        if (low_y >= rows || high_y <= 0.0f || low_x >= columns) return;
        const int first_row = low_y > 0.0f ? static_cast<int>(low_y) : 0;
        const int last_row = high_y < rows ? static_cast<int>(high_y) : tile_.rows - 1;

        V change[kChannels] = {};
        addSide(block, edge.right, 1.0f, change);
        addSide(block, edge.left, -1.0f, change);

        const V x0 = at_.x[a], x1 = at_.x[b], y0 = at_.y[a], y1 = at_.y[b];
        const V dx = x1 - x0, dy = y1 - y0;
        const V inverse = absolute(dy) < 1.0e-30f ? splat<V>(0.0f) : reciprocal(dy);
        const V least_x = least(x0, x1), most_x = most(x0, x1);
        // Columns for the whole edge where it is short, row by row where it is long.
        const bool narrow = high_x - low_x < 4.0f;
        const bool whole = low_x >= 0.0f && high_x < columns;
        int first_column = columnOf(low_x), last_column = columnOf(high_x);
        for (int row = first_row; row <= last_row && row < tile_.rows; ++row) {
            const V bottom = splat<V>(static_cast<float>(row)), top = bottom + 1.0f;
            const V ya = clampTo(y0, bottom, top), yb = clampTo(y1, bottom, top);
            const V height = yb - ya;
            const V xa = clampTo(x0 + ((ya - y0) * inverse) * dx, least_x, most_x);
            const V xb = clampTo(x0 + ((yb - y0) * inverse) * dx, least_x, most_x);
            const V near_x = least(xa, xb), far_x = most(xa, xb);
            if (!narrow) {
                first_column = columnOf(leastLane(near_x));
                last_column = columnOf(mostLane(far_x));
            }
            float* cell = tile_.sums + static_cast<std::ptrdiff_t>(row) * tile_.rowStride() +
                          static_cast<std::ptrdiff_t>(first_column) * kCell;
            if (first_column == last_column && whole) {
                const V covered = height * (static_cast<float>(first_column + 1) - 0.5f * (near_x + far_x));
                addCell(cell, covered, change);
                addCell(cell + kCell, height - covered, change);
                continue;
            }
            // The reach of a column, differenced twice along the columns, is the coverage's change.
            const V half_inverse = 0.5f * reciprocal(most(far_x - near_x, splat<V>(1.0e-6f)));
            V c = splat<V>(static_cast<float>(first_column));
            V reach = reachOf(c, near_x, far_x, half_inverse);
            V coverage = splat<V>(0.0f);
            for (int column = first_column; column <= last_column; ++column, cell += kCell) {
                c = c + 1.0f;
                const V next = reachOf(c, near_x, far_x, half_inverse);
                const V step = next - reach;
                addCell(cell, height * (step - coverage), change);
                coverage = step;
                reach = next;
            }
            addCell(cell, height * (1.0f - coverage), change);
        }
    }

    // Mean over a segment, whose x runs evenly from near_x to far_x, of max(c - x, 0).
    static V reachOf(V c, V near_x, V far_x, V half_inverse) {
        const V in = clampTo(c, near_x, far_x) - near_x;
        return in * in * half_inverse + most(c - far_x, splat<V>(0.0f));
    }

    int columnOf(float x) const {
        if (x <= 0.0f) return 0;
        return x < static_cast<float>(tile_.columns) ? static_cast<int>(x) : tile_.columns - 1;
    }

    int rowOf(float y) const {
        if (y <= 0.0f) return 0;
        return y < static_cast<float>(tile_.rows) ? static_cast<int>(y) : tile_.rows - 1;
    }

    static void addCell(float* cell, V area, const V* change) {
        for (int k = 0; k < kChannels; ++k) store(cell + k * kLanes, load<V>(cell + k * kLanes) + area * change[k]);
    }

    const TubeSet& set_;
    TileSums& tile_;
    V shift_u_{}, shift_v_{}, counted_{};  // counted: 1 in the layers that are, 0 in padding
    V rect_low_u_, rect_high_u_, rect_low_v_, rect_high_v_, tile_low_u_, tile_high_u_, tile_low_v_, tile_high_v_;
    BlockLayers<V, kDensities, kBent ? kMaxCorners : 1> at_;
};

template <int N, int kIrradiance, bool kFlux>
void runKernel(const TubeSet& set, const std::uint32_t* blocks, int block_count, TileSums& tile) {
    const auto addTo = [&](auto&& kernel) {
        for (int i = 0; i < block_count; ++i) kernel.add(set.blocks[blocks[i]]);
    };
    if (tile.bent)
        addTo(SlabKernel<typename LanesOf<N>::F, kIrradiance, kFlux, true>(set, tile));
    else
        addTo(SlabKernel<typename LanesOf<N>::F, kIrradiance, kFlux, false>(set, tile));
}

template <int N>
EdgeKernel kernelOfWidth(int irradiance_channels, bool flux) {
    if (irradiance_channels == 1) return flux ? runKernel<N, 1, true> : runKernel<N, 1, false>;
    return flux ? runKernel<N, 3, true> : runKernel<N, 3, false>;
}

inline EdgeKernel selectKernel(int lanes, int irradiance_channels, bool flux) {
    if (lanes == 16) return kernelOfWidth<16>(irradiance_channels, flux);
    return lanes == 8 ? kernelOfWidth<8>(irradiance_channels, flux) : kernelOfWidth<4>(irradiance_channels, flux);
}

}  // namespace photic::PHOTIC_ISA
