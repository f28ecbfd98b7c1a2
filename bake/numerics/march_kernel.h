// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

#include "bake/numerics/block_marching.h"

namespace photic {

inline constexpr int kHalo = 2;  // cells on either side that the second-order stencil reads
inline constexpr int kRows = BlockGrid::kSide + 2 * kHalo;
inline constexpr int kPitch = 16;  // a row, aligned: x lies at kFirst + x, its halo beyond both ends
inline constexpr int kFirst = 8;
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// [n h] How much later than the nearer cell the further one of a second-order difference may be. Where it may not be
/// later at all, differences fall back to first order wherever a front turns over along an axis, and leave an error in
/// the curvature that no resolution cures (10 % along a cross below a point source). A front whose radius is R turns
/// over by 1.5 h / R.
inline constexpr double kFarLater = 0.25;

/// One block with its surroundings, in cache.
struct LocalBlock {
    alignas(64) double t[kRows * kRows * kPitch + kHalo];
    alignas(64) double cost[BlockGrid::kCells];  // n h
    double uniform_cost = 0;                     // where cost is not filled
    // With a point source: what the differences of its arrival miss, by axis, towards lower and higher cells, in first
    // and second order.
    alignas(64) double misses[3][2][2][BlockGrid::kCells];
    bool varies = false, second_order = true, factored = false;
    double tolerance = 0;
    const std::uint8_t* fixed = nullptr;
    double key[64];                 // row z << 3 | y is due once the front has come here
    double limit = 0;               // how far the front may come now
    double slack = 0;               // how much earlier a cell may be than one that it depends on
    double settled = 0;             // moves below this leave the row right to the tolerance
    std::uint64_t dirty = 0;        // rows that are due within the limit
    std::uint64_t leaving[6] = {};  // rows of the neighbours that become due
    double leaving_key[6][64];
    std::uint64_t changed = 0;  // rows to be written back
    std::int64_t updates = 0;

    static int row(int y, int z) { return ((z + kHalo) * kRows + y + kHalo) * kPitch + kFirst; }
};

/// Brings the rows of a block up to date that are due, and says what that makes due beside them.
using SolveBlock = void (*)(LocalBlock&);

/// The fastest that this processor can run (bestInstructionSet).
SolveBlock blockSolver();

}  // namespace photic
