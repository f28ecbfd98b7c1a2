// SPDX-License-Identifier: Apache-2.0
// The marching of one block, eight cells side by side. Included by one translation unit per instruction set, which
// defines PHOTIC_ISA: everything has internal linkage, so that no inline function of one is linked into another.
#pragma once

#include <algorithm>
#include <bit>

#include "bake/numerics/march_kernel.h"
#include "bake/simd/double_lanes.h"

namespace photic::PHOTIC_ISA {
namespace {

constexpr int kMaxSweeps = 200;

/// An upwind difference along one axis: the nearer neighbour's value, and what the quadratic sees of the axis.
struct Upwind {
    Lanes near, value, weight;
};

/// @param later   by how much the further neighbour may be later than the nearer one
/// @param misses  of the axis; `lane` is the first one's place in it. Null: nothing is added
template <bool kFactored>
inline void upwind(const double* c, int step, bool second_order, const Lanes& later,
                   const double (*misses)[2][BlockGrid::kCells], int lane, Upwind& out) {
    const Lanes m1 = load(c - step), m2 = load(c - 2 * step), p1 = load(c + step), p2 = load(c + 2 * step);
    const LaneMask low = m1 <= p1;
    out.near = low ? m1 : p1;
    const Lanes far = low ? m2 : p2, one = Lanes{} + 1.0;
    const LaneMask second =
        (far <= out.near + later) & (out.near < kUnreached) & (LaneMask{} - std::int64_t{second_order});
    out.value = second ? (4 * out.near - far) * (1.0 / 3) : out.near;
    if constexpr (kFactored) {
        const Lanes first_low = load(misses[0][0] + lane), first_high = load(misses[1][0] + lane);
        const Lanes second_low = load(misses[0][1] + lane), second_high = load(misses[1][1] + lane);
        const Lanes first = low ? first_low : first_high, twice = low ? second_low : second_high;
        out.value += second ? twice : first;
        out.near = out.value;
    }
    // Upwind is where the slope is positive, not where a neighbour is earlier: where the front turns over along an
    // axis, beside the planes through a source or below a trough, the one-sided slope tells both sides of a minimum
    // apart.
    out.near = least(out.near, out.value);
    out.weight = second ? one * 2.25 : one;
}

inline void sort(Upwind& a, Upwind& b) {
    const LaneMask swap = b.near < a.near;
    const Upwind low{swap ? b.near : a.near, swap ? b.value : a.value, swap ? b.weight : a.weight};
    b = {swap ? a.near : b.near, swap ? a.value : b.value, swap ? a.weight : b.weight};
    a = low;
}

/// The largest T with sum of weight (T - value)^2 = s^2 over the axes that lie upwind of it. `slope` is half of the
/// quadratic's derivative there: the sum of weight (T - value).
inline void solveUpwind(Upwind& a, Upwind& b, Upwind& c, const Lanes& s, Lanes& t, Lanes& slope) {
    sort(a, b), sort(b, c), sort(a, b);
    // Relative to the first axis' value: T is found to the precision of the differences.
    const Lanes zero{}, one_weight = zero + 1.0;
    const Lanes one = s * (a.weight > 1 ? one_weight * (2.0 / 3) : one_weight);
    const Lanes db = b.value - a.value, dc = c.value - a.value;
    const Lanes sum2 = a.weight + b.weight, lin2 = b.weight * db, quad2 = lin2 * db;
    const Lanes disc2 = lin2 * lin2 - sum2 * (quad2 - s * s);
    const Lanes sum3 = sum2 + c.weight, lin3 = lin2 + c.weight * dc;
    const Lanes disc3 = lin3 * lin3 - sum3 * (quad2 + c.weight * dc * dc - s * s);
    const Lanes root2 = squareRoot(most(disc2, zero)), root3 = squareRoot(most(disc3, zero));
    // Weights are 1 or 9/4: selections are faster than a division.
    const Lanes inverse2 = sum2 > 4 ? one_weight / 4.5 : sum2 > 3 ? one_weight / 3.25 : one_weight / 2;
    const Lanes inverse3 = sum3 > 6   ? one_weight / 6.75
                           : sum3 > 5 ? one_weight / 5.5
                           : sum3 > 4 ? one_weight / 4.25
                                      : one_weight / 3;
    const LaneMask take2 = (a.value + one > b.near) & (disc2 >= 0);
    const Lanes two = take2 ? (lin2 + root2) * inverse2 : one;
    const LaneMask take3 = take2 & (a.value + two > c.near) & (disc3 >= 0);
    t = a.value + (take3 ? (lin3 + root3) * inverse3 : two);
    t = t < kUnreached ? t : zero + kUnreached;
    slope = take3 ? root3 : take2 ? root2 : a.weight * one;
}

/// What a row of eight cells would be, its surroundings held: the upwind update of each cell, how far it moves, and its
/// derivatives by the nearer and the further cell of the row, where those lie upwind towards lower or higher x.
/// Cells that were not reached yet, or are fixed, have no part in the last three.
struct RowUpdate {
    alignas(64) double value[8], moves[8], near_low[8], far_low[8], near_high[8], far_high[8];
    // Newton's corrections along the row in either direction, with zeros before the first and after the last.
    double low[10] = {}, high[10] = {};
};

/// For the cells from `first` on that fit a register.
template <bool kFactored>
inline void upwindLanes(const LocalBlock& b, const double* __restrict row, const double* __restrict row_cost, int bit,
                        int first, RowUpdate& __restrict out) {
    const double *t = row + first, *cost = row_cost + first;
    const int lane = bit * BlockGrid::kSide + first;
    const bool second_order = b.second_order;
    Upwind x, y, z;
    const Lanes s = load(cost), later = kFarLater * s;
    upwind<kFactored>(t, 1, second_order, later, b.misses[0], lane, x);
    upwind<kFactored>(t, kPitch, second_order, later, b.misses[1], lane, y);
    upwind<kFactored>(t, kRows * kPitch, second_order, later, b.misses[2], lane, z);
    const Lanes old = load(t), below = load(t - 1), above = load(t + 1);
    Lanes value, slope;
    const Upwind along = x;
    solveUpwind(x, y, z, s, value, slope);
    const Lanes zero{}, part = along.weight * (value - along.value);
    const LaneMask reached = (old < kUnreached) & (value < kUnreached);
    // An extrapolated neighbour can lie past the cell: shares outside of [0, 1] would not converge.
    const LaneMask counts = reached & (value > along.near) & (part > 0);
    const Lanes share = counts ? part / (part < slope ? slope : part) : zero;
    const LaneMask second = along.weight > 1, low = below <= above;
    const Lanes near = second ? 4.0 / 3 * share : share, far = second ? -1.0 / 3 * share : zero;
    const Lanes move = reached ? value - old : zero, limited = move < s ? move : s;
    const Lanes moves = limited > -s ? limited : -s;
    store(out.value + first, value), store(out.moves + first, moves);
    store(out.near_low + first, low ? near : zero), store(out.far_low + first, low ? far : zero);
    store(out.near_high + first, low ? zero : near), store(out.far_high + first, low ? zero : far);
}

/// Newton's method along a row, whose cells depend on each other: the moves d solve d = F - T + F_1 d_1 + F_2 d_2, lane
/// by lane in the direction of travel. Without it information would pass one cell an update.
void solveAlongRow(RowUpdate& row) {
    // Both directions at once: each is a chain in which every lane waits for the one before.
    double low_near = 0, low_far = 0, high_near = 0, high_far = 0;
    for (int l = 0, h = BlockGrid::kSide - 1; h >= 0; ++l, --h) {
        const double low = (row.moves[l] + row.far_low[l] * low_far) + row.near_low[l] * low_near;
        const double high = (row.moves[h] + row.far_high[h] * high_far) + row.near_high[h] * high_near;
        row.low[l + 2] = low, low_far = low_near, low_near = low;
        row.high[h] = high, high_far = high_near, high_near = high;
    }
}

struct RowChange {
    unsigned moved = 0, unsettled = 0;  // lanes that changed, and that are to be looked at again
    double least = kNever;              // the earliest of their values, old and new
};

/// Stores a row with its corrections; per lane, the earlier of old and new value where it changed.
/// @param slack  how much earlier than a neighbour a cell may be that depends on it
RowChange replaceRow(double* __restrict t, const RowUpdate& __restrict row, double tolerance, double settled,
                     double slack, double* __restrict earliest) {
    RowChange out;
    Lanes least_of_all = splat(2 * kUnreached);
    for (int l = 0; l < BlockGrid::kSide; l += kLanes) {
        const Lanes fresh =
            load(row.value + l) +
            (load(row.near_low + l) * load(row.low + l + 1) + load(row.far_low + l) * load(row.low + l)) +
            (load(row.near_high + l) * load(row.high + l + 1) + load(row.far_high + l) * load(row.high + l + 2));
        const Lanes old = load(t + l), change = absolute(fresh - old);
        const LaneMask moved = change > tolerance;
        const Lanes first = moved ? least(fresh, old) : splat(2 * kUnreached);
        store(earliest + l, first - slack), store(t + l, fresh);
        least_of_all = least(least_of_all, first);
        out.moved |= bitsOf(moved) << l, out.unsettled |= bitsOf(change > settled) << l;
    }
    out.least = least_of_all[0];
    for (int l = 1; l < kLanes; ++l) out.least = least_of_all[l] < out.least ? least_of_all[l] : out.least;
    return out;
}

/// Which of the rows at y - 1, y + 1, y - 2, y + 2, z - 1, z + 1, z - 2, z + 2 have a cell after the change beside it.
unsigned dependentRows(const double* __restrict t, const double* __restrict earliest) {
    constexpr int y = kPitch, z = kRows * kPitch;
    constexpr int offsets[8] = {-y, y, -2 * y, 2 * y, -z, z, -2 * z, 2 * z};
    unsigned rows = 0;
    for (int n = 0; n < 8; ++n) {
        unsigned later = 0;
        for (int l = 0; l < BlockGrid::kSide; l += kLanes)
            later |= bitsOf(load(t + offsets[n] + l) > load(earliest + l));
        rows |= (later != 0 ? 1u : 0u) << n;
    }
    return rows;
}

/// A row is due once the front has come to `key`.
void due(LocalBlock& b, int bit, double key) {
    b.key[bit] = std::min(b.key[bit], key);
    if (key <= b.limit) b.dirty |= std::uint64_t{1} << bit;
}

void leave(LocalBlock& b, std::size_t face, int bit, double key) {
    b.leaving[face] |= std::uint64_t{1} << bit;
    b.leaving_key[face][bit] = std::min(b.leaving_key[face][bit], key);
}

void advanceRow(LocalBlock& b, int bit) {
    const int y = bit & 7, z = bit >> 3, reach = b.second_order ? 2 : 1;
    double* t = b.t + LocalBlock::row(y, z);
    const double* cost = b.cost + (b.varies ? bit * 8 : 0);
    RowUpdate row;
    for (int l = 0; l < BlockGrid::kSide; l += kLanes)
        b.factored ? upwindLanes<true>(b, t, cost, bit, l, row) : upwindLanes<false>(b, t, cost, bit, l, row);
    if (const std::uint8_t fixed = b.fixed[bit]; fixed != 0)
        for (int l = 0; l < BlockGrid::kSide; ++l)
            if (fixed >> l & 1) {
                row.value[l] = t[l], row.moves[l] = 0;
                row.near_low[l] = row.far_low[l] = row.near_high[l] = row.far_high[l] = 0;
            }
    solveAlongRow(row);
    alignas(64) double earliest[8];
    const RowChange change = replaceRow(t, row, b.tolerance, b.settled, b.slack, earliest);
    if (change.moved == 0) return;
    b.changed |= std::uint64_t{1} << bit;
    const double least = change.least;
    // Newton squares the error: after a small move the row need not be looked at again for its own sake.
    if (change.unsettled != 0) due(b, bit, least);
    const unsigned dependent = dependentRows(t, earliest) & (reach == 2 ? 0xffu : 0x33u);
    for (unsigned rest = dependent; rest != 0; rest &= rest - 1) {
        const int n = std::countr_zero(rest), step = (n & 2 ? 2 : 1) * (n & 1 ? 1 : -1);
        const int ny = n < 4 ? y + step : y, nz = n < 4 ? z : z + step;
        const int at = (nz & 7) << 3 | (ny & 7);
        if (ny < 0)
            leave(b, 2, at, least);
        else if (ny > 7)
            leave(b, 3, at, least);
        else if (nz < 0)
            leave(b, 4, at, least);
        else if (nz > 7)
            leave(b, 5, at, least);
        else
            due(b, at, least);
    }
    if (change.moved & ((1u << reach) - 1)) leave(b, 0, bit, least);
    if (change.moved >> (8 - reach)) leave(b, 1, bit, least);
}

/// Sweeps over the rows that are due, each time in another direction, until none is.
void solveBlock(LocalBlock& b) {
    std::fill_n(b.leaving, 6, 0u);
    for (auto& keys : b.leaving_key) std::fill_n(keys, 64, kNever);
    b.changed = 0, b.updates = 0, b.dirty = 0;
    int first = 0;  // the earliest row: sweeps start from its corner, as the front does
    for (int bit = 0; bit < 64; ++bit) {
        b.dirty |= std::uint64_t{b.key[bit] <= b.limit} << bit;
        if (b.key[bit] < b.key[first]) first = bit;
    }
    const int corner = (first & 32 ? 7 << 3 : 0) | (first & 4 ? 7 : 0);
    for (int sweep = 0; b.dirty != 0 && sweep < kMaxSweeps; ++sweep) {
        const int flip = corner;
        for (int i = 0; i < 64; ++i) {
            const int bit = i ^ flip;
            if (!(b.dirty >> bit & 1)) continue;
            b.dirty &= ~(std::uint64_t{1} << bit);
            b.key[bit] = kNever;
            ++b.updates;
            advanceRow(b, bit);
        }
    }
}

}  // namespace
}  // namespace photic::PHOTIC_ISA
