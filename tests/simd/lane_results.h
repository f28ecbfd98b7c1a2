// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace photic {

/// What the operations of bake/simd/lanes.h give for the first `count` numbers of `a`, `b`, `c`, `d`.
struct LaneResults {
    static constexpr int kMost = 16;
    using Numbers = std::array<double, kMost>;
    int count = 0;
    Numbers least{}, most{}, absolute{}, clamped{}, root{}, whole{}, gathered{}, difference{}, reciprocal{}, power{},
        iota{};
    double least_lane = 0, most_lane = 0;
    std::array<std::int32_t, kMost> index{};
    unsigned less = 0;  ///< a bit per lane of a < b; of doubles only
};

/// Lanes of a vector, by type: 2, 4, 8 doubles, then 4, 8, 16 floats.
inline constexpr int kLaneTypes = 6;

}  // namespace photic
