// SPDX-License-Identifier: Apache-2.0
// What happens to a tile's sums once all edges are in: the running sum along u, and the copy into leaves. Once per
// instruction set, as edge_kernel_impl.h.
#pragma once

#include "bake/deposit/edge_kernel.h"
#include "bake/simd/lanes.h"

namespace photic::PHOTIC_ISA {

/// Running sums of kRegisters x V floats of each cell of a row.
template <class V, int kRegisters>
inline void sumAlongRow(float* cell, int columns, int stride) {
    V sums[kRegisters] = {};
    for (int column = 0; column < columns; ++column, cell += stride)
        for (int r = 0; r < kRegisters; ++r) {
            float* p = cell + r * laneCount<V>;
            sums[r] = sums[r] + load<V>(p);
            store(p, sums[r]);
        }
}

inline void runningSums(TileSums& tile) {
    // Registers that the processor has: GCC keeps wider vectors in memory, which took nine times as long. Four at a
    // time, so that their additions need not wait for one another.
    using V = WidestFloats;
    constexpr int kWidth = laneCount<V>;
    const int stride = tile.cellStride();
    for (int row = 0; row < tile.rows; ++row) {
        float* cell = tile.sums + static_cast<std::ptrdiff_t>(row) * tile.rowStride();
        int k = 0;
        for (; k + 4 * kWidth <= stride; k += 4 * kWidth) sumAlongRow<V, 4>(cell + k, tile.columns, stride);
        for (; k + kWidth <= stride; k += kWidth) sumAlongRow<V, 1>(cell + k, tile.columns, stride);
        // Four lanes is the narrowest slab, so strides are multiples of 4.
        for (; k < stride; k += 4) sumAlongRow<F4, 1>(cell + k, tile.columns, stride);
    }
}

struct V8Flux {
    F8 x, y, z;
};

// What shortens flux to `irradiance` where it is longer, 1 elsewhere.
inline F8 fluxBound(const V8Flux& f, F8 irradiance) {
    const F8 length = squareRoot(f.x * f.x + f.y * f.y + f.z * f.z);
    return length > irradiance ? irradiance / length : splat<F8>(1.0f);
}

// The cells of a leaf, eight layers at a time, fetched by `fetch(cell, channel)` in units of the field.
template <class Fetch>
inline bool copyCells(const TileSums& tile, int irradiance_channels, float floor, float* out, const Fetch& fetch) {
    F8 any = {};
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            const float* cell = tile.sums + static_cast<std::ptrdiff_t>(y) * tile.rowStride() + x * tile.cellStride();
            F8 keep{}, value[6];
            for (int k = 0; k < tile.channels; ++k) {
                value[k] = fetch(cell, k);
                if (k < irradiance_channels) keep = keep + value[k];
            }
            const auto lit = keep > floor;
            if (tile.channels > irradiance_channels) {
                // Rounding must not make flux longer than the mean irradiance.
                const V8Flux flux{value[irradiance_channels], value[irradiance_channels + 1],
                                  value[irradiance_channels + 2]};
                const F8 shorten = fluxBound(flux, keep * (1.0f / static_cast<float>(irradiance_channels)));
                for (int k = irradiance_channels; k < tile.channels; ++k) value[k] = value[k] * shorten;
            }
            for (int k = 0; k < tile.channels; ++k) {
                const F8 kept = lit ? value[k] : F8{};
                store(out + k * 512 + (x << 6) + (y << 3), kept);
            }
            any = most(any, lit ? keep : F8{});
        }
    }
    return mostLane(any) > 0.0f;
}

inline bool copyLeaf(const TileSums& tile, int u, int v, int first_lane, int irradiance_channels, float scale,
                     float floor, float* out) {
    alignas(32) std::int32_t index[8];
    // Layers of the leaf that the tile does not hold stay 0.
    F8 scales = {};
    const int stride = tile.cellStride();
    bool side_by_side = true;
    for (int l = 0; l < 8; ++l) {
        const int lane = first_lane + l < 0                   ? 0
                         : first_lane + l < tile.active_lanes ? first_lane + l
                                                              : tile.active_lanes - 1;
        scales[l] = lane == first_lane + l ? scale : 0.0f;
        index[l] =
            (v - tile.v0 - tile.shift_v[lane]) * tile.rowStride() + (u - tile.u0 - tile.shift_u[lane]) * stride + lane;
        side_by_side = side_by_side && index[l] == index[0] + l;
    }
    // Layers that are not shifted (level light, grids that lean with it) lie side by side: half the time of gathering.
    if (side_by_side)
        return copyCells(tile, irradiance_channels, floor, out,
                         [&](const float* cell, int k) { return load<F8>(cell + index[0] + k * tile.lanes) * scales; });
    return copyCells(tile, irradiance_channels, floor, out,
                     [&](const float* cell, int k) { return gather<F8>(cell + k * tile.lanes, index) * scales; });
}

}  // namespace photic::PHOTIC_ISA
