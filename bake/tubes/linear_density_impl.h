// SPDX-License-Identifier: Apache-2.0
// Density that varies linearly inside a tube, for the edge kernel; once per instruction set, as edge_kernel_impl.h.
// Derivation: docs/methods.md, "Density inside a tube".
#pragma once

#include "bake/tubes/edge_kernel.h"
#include "bake/tubes/lanes.h"

namespace photic::PHOTIC_ISA {

/// A linear function on a tube's triangle, 0 on average: at the corners, and per column and row.
template <class V>
struct LinearChannel {
    V value[3];
    V along_x, along_y;
};

/// How a tube's density departs from its mean, in multiples of it; all the departures are 0 on average.
template <class V>
struct TubeShape {
    V departure[3];            // of the density at the corners
    V slope_x[3], slope_y[3];  // of the barycentric coordinates
    V kept;                    // 0..1, of all departures
};

/// How the light around a corner ray spreads on the layers of a slab.
template <class V>
struct CornerLayers {
    V step[2][2];  // as CornerSpread::step
    V density;     // of a lattice cell's light, with the sign of its cross-section
};

template <class V>
CornerLayers<V> cornerLayers(const CornerSpread& spread, V layers) {
    CornerLayers<V> out;
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) out.step[a][b] = spread.step[a][b] + layers * spread.step_per_layer[a][b];
    const V area = out.step[0][0] * out.step[1][1] - out.step[0][1] * out.step[1][0];
    out.density = spread.power * area / (area * area + 1.0e-20f);
    return out;
}

/// What the straight side between two corners leaves to the neighbour of the triangle that runs from `a` to `b`: light
/// between it and the curve that neighbouring rays really form (cubic, by the steps at both ends). Exactly the opposite
/// for the neighbour.
/// @param cx, cy  from a to b
template <class V>
V handedOn(const CornerSpread& a, const CornerSpread& b, const CornerLayers<V>& at_a, const CornerLayers<V>& at_b, V cx,
           V cy) {
    const float columns = b.column - a.column, rows = b.row - a.row;
    const V tx = columns * (at_a.step[0][0] - at_b.step[0][0]) + rows * (at_a.step[1][0] - at_b.step[1][0]);
    const V ty = columns * (at_a.step[0][1] - at_b.step[0][1]) + rows * (at_a.step[1][1] - at_b.step[1][1]);
    const V density = 0.5f * (at_a.density + at_b.density);
    const V amount = density * (tx * cy - ty * cx) * (1.0f / 12.0f);
    // Beside a fold the two corners do not speak of the same sheet.
    const V limit = splat<V>(kMostHandedOn * (a.power < b.power ? a.power : b.power));
    const V kept = clampTo(amount, -limit, limit);
    return at_a.density * at_b.density > 0.0f ? kept : V{};
}

/// @param f            densityAround the corners; signs that differ, or a corner of unknown spread: constant density
/// @param unfocused    what densityAround was on the surface
/// @param travel       of the corners, per unit of the tube's length; null: they agree
/// @param inverse_area 1 / twice the signed area; 0 on lanes whose density is to be constant
template <class V>
TubeShape<V> shapeOf(const V f[3], const V x[3], const V y[3], V inverse_area, float unfocused,
                     const float (*travel)[3]) {
    TubeShape<V> shape;
    const V sum = f[0] + f[1] + f[2];
    const auto alike = (f[0] * f[1] > 0.0f) & (f[1] * f[2] > 0.0f) & (inverse_area != 0.0f);
    const V scale = 2.0f / (alike ? sum : splat<V>(1.0f));
    V gradient_x = {}, gradient_y = {};
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        shape.departure[i] = alike ? (f[i] - (sum - f[i]) * 0.5f) * scale : splat<V>(0.0f);
        shape.slope_x[i] = (y[j] - y[k]) * inverse_area;
        shape.slope_y[i] = (x[k] - x[j]) * inverse_area;
        gradient_x = gradient_x + shape.departure[i] * shape.slope_x[i];
        gradient_y = gradient_y + shape.departure[i] * shape.slope_y[i];
    }
    // A tube beside a fold, much narrower than a voxel, needs no slope; a steep one would cost the sums their digits,
    // and what its corners say is rounding.
    V steep = absolute(sum) * (kSteepestSlope / (3 * kBrightestSlope * unfocused));
    steep = most(steep, most(absolute(gradient_x), absolute(gradient_y)));
    for (int k = 0; k < 3 && travel; ++k) {
        V turn_x = {}, turn_y = {};
        for (int i = 0; i < 3; ++i) {
            turn_x = turn_x + travel[i][k] * shape.slope_x[i];
            turn_y = turn_y + travel[i][k] * shape.slope_y[i];
        }
        steep = most(steep, most(absolute(turn_x), absolute(turn_y)));
    }
    const V ratio = kSteepestSlope / most(steep, splat<V>(kSteepestSlope));
    shape.kept = inverse_area != 0.0f ? ratio * ratio : splat<V>(0.0f);
    for (V& departure : shape.departure) departure = shape.kept * departure;
    return shape;
}

/// How a channel departs from its mean, density x mean_constant: nothing on average.
template <class V>
LinearChannel<V> linearChannel(const TubeShape<V>& shape, V density, const float constant[3], float mean_constant) {
    LinearChannel<V> out;
    V mean = {};
    for (int i = 0; i < 3; ++i) {
        // relative x constant - mean_constant, without the cancellation
        const V apart = shape.kept * (constant[i] - mean_constant);
        out.value[i] = shape.departure[i] * (mean_constant + apart) + apart;
        mean = mean + out.value[i];
    }
    mean = mean * (1.0f / 3.0f);
    out.along_x = out.along_y = V{};
    for (int i = 0; i < 3; ++i) {
        out.value[i] = density * (out.value[i] - mean);
        out.along_x = out.along_x + out.value[i] * shape.slope_x[i];
        out.along_y = out.along_y + out.value[i] * shape.slope_y[i];
    }
    return out;
}

/// Of a triangle's part in a cell: its area, and its first moments about the triangle's first corner.
template <class V>
struct CellMoments {
    V area{}, x{}, y{};
};

/// The part of one side of a triangle in one row of cells: what lies to its right, up to a column's border.
template <class V>
class SideInRow {
public:
    /// @param x0, y0        where the side starts, and dx, dy how far it goes [cells]
    /// @param from_corner   x0, y0 from the triangle's first corner
    SideInRow(V x0, V y0, V dx, V dy, V inverse_dy, V from_corner_x, V from_corner_y, float row) : x0_(x0) {
        const V zero = splat<V>(0.0f), one = splat<V>(1.0f), bottom = splat<V>(row), top = bottom + 1.0f;
        const V ya = clampTo(y0, bottom, top), yb = clampTo(y0 + dy, bottom, top);
        height_ = yb - ya;
        const V ta = clampTo((ya - y0) * inverse_dy, zero, one), tb = clampTo((yb - y0) * inverse_dy, zero, one);
        const V part = 0.5f * (ta + tb), across = (tb - ta) * dx;
        middle_ = part * dx;
        corner_x_ = from_corner_x + middle_, corner_y_ = from_corner_y + part * dy;
        length_ = most(absolute(across), splat<V>(1.0e-6f));
        inverse_ = reciprocal(length_);
        slope_ = height_ * inverse_;
        slope_ = across < 0.0f ? -slope_ : slope_;
    }

    /// Adds the moments of the region between the side and the column border c, where it lies to the right of the side.
    void addUpTo(float c, CellMoments<V>& to) const {
        const V half = 0.5f * length_, d = (c - x0_) - middle_;
        const V e = clampTo(d, -half, half), in = e + half;
        const V cubes = (e * e * e + half * half * half) * (1.0f / 3.0f);
        const V area = height_ * (in * in * (0.5f * inverse_) + most(d - half, splat<V>(0.0f)));
        const V x = height_ * (0.5f * inverse_ * (d * d * in - cubes));
        const V y = height_ * (slope_ * inverse_ * (0.5f * d * (e * e - half * half) - cubes));
        to.area = to.area - area;
        to.x = to.x - (x + corner_x_ * area);
        to.y = to.y - (y + corner_y_ * area);
    }

private:
    V x0_, height_, middle_, corner_x_, corner_y_, length_, inverse_, slope_;
};

/// Adds the departures of a tube's channels to the running sums: cell by cell, so that nothing is carried past the
/// tube. Tubes inside one cell have none.
/// @param cells  first and last row and column, inside the buffer
template <class V, int kChannels>
void depositDepartures(TileSums& tile, const V x[3], const V y[3], const LinearChannel<V>* channels, const int rows[2],
                       const int columns[2]) {
    constexpr int kLanes = laneCount<V>;
    V dx[3], dy[3], inverse_dy[3], corner_x[3], corner_y[3];
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        dx[i] = x[j] - x[i], dy[i] = y[j] - y[i];
        inverse_dy[i] = absolute(dy[i]) < 1.0e-30f ? splat<V>(0.0f) : reciprocal(dy[i]);
        corner_x[i] = x[i] - x[0], corner_y[i] = y[i] - y[0];
    }
    for (int row = rows[0]; row <= rows[1]; ++row) {
        const auto side = [&](int i) {
            return SideInRow<V>(x[i], y[i], dx[i], dy[i], inverse_dy[i], corner_x[i], corner_y[i],
                                static_cast<float>(row));
        };
        const SideInRow<V> sides[3] = {side(0), side(1), side(2)};
        float* cell = tile.sums + static_cast<std::ptrdiff_t>(row) * tile.rowStride() +
                      static_cast<std::ptrdiff_t>(columns[0]) * kChannels * kLanes;
        CellMoments<V> so_far;
        for (const auto& s : sides) s.addUpTo(static_cast<float>(columns[0]), so_far);
        V before[kChannels] = {};
        for (int column = columns[0]; column <= columns[1]; ++column, cell += kChannels * kLanes) {
            CellMoments<V> next;
            for (const auto& s : sides) s.addUpTo(static_cast<float>(column + 1), next);
            const V area = next.area - so_far.area, mx = next.x - so_far.x, my = next.y - so_far.y;
            for (int k = 0; k < kChannels; ++k) {
                const V here = channels[k].value[0] * area + channels[k].along_x * mx + channels[k].along_y * my;
                store(cell + k * kLanes, load<V>(cell + k * kLanes) + (here - before[k]));
                before[k] = here;
            }
            so_far = next;
        }
        for (int k = 0; k < kChannels; ++k) store(cell + k * kLanes, load<V>(cell + k * kLanes) - before[k]);
    }
}

}  // namespace photic::PHOTIC_ISA
