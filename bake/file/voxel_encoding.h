// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "runtime/format/light_volume_format.h"

namespace photic {

/// A float with ten bits of mantissa, rounded to nearest even, as half floats hold it (their subnormals apart).
inline float halfPrecision(float v) {
    const auto bits = std::bit_cast<std::uint32_t>(v);
    return std::bit_cast<float>((bits + 0x0fffu + (bits >> 13 & 1u)) & ~0x1fffu);
}
/// The same, rounded towards zero.
inline float halfPrecisionBelow(float v) { return std::bit_cast<float>(std::bit_cast<std::uint32_t>(v) & ~0x1fffu); }

/// Cuts a value to what a half float can hold; `clamped` counts. A NaN becomes 0 and counts too.
inline float cutToRange(float v, std::int64_t& clamped) {
    if (std::fabs(v) <= format::kLargest) return v;
    ++clamped;
    return std::isnan(v) ? 0.0f : std::copysign(format::kLargest, v);
}

/// Mean directions of `count` voxels from flux and irradiance, as stored: length at most 1 after rounding too.
/// 0 where there is no light, or so little (below 1.2e-38) that its reciprocal is not finite.
inline void encodeDirections(const float* irradiance, const float* fx, const float* fy, const float* fz, int count,
                             bool half, float* dx, float* dy, float* dz) {
    for (int i = 0; i < count; ++i) {
        const float scale = irradiance[i] >= std::numeric_limits<float>::min() ? 1 / irradiance[i] : 0.0f;
        const float x = fx[i] * scale, y = fy[i] * scale, z = fz[i] * scale;
        // One-directional light has length 1, which rounding can exceed: those components round towards zero instead.
        const float length2 = x * x + y * y + z * z, shorten = length2 > 1 ? 0.9999998f / std::sqrt(length2) : 1.0f;
        const float sx = x * shorten, sy = y * shorten, sz = z * shorten;
        const float rx = half ? halfPrecision(sx) : sx, ry = half ? halfPrecision(sy) : sy,
                    rz = half ? halfPrecision(sz) : sz;
        const bool over = rx * rx + ry * ry + rz * rz > 1;
        dx[i] = over ? halfPrecisionBelow(sx) : rx;
        dy[i] = over ? halfPrecisionBelow(sy) : ry;
        dz[i] = over ? halfPrecisionBelow(sz) : rz;
    }
}

}  // namespace photic
