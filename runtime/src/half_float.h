// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace photic::runtime {

/// IEEE 754 binary16, by its bits.
using Half = std::uint16_t;
using Half4 = std::array<Half, 4>;

inline constexpr float kLargestHalf = 65504.0F;

/// Exact.
inline float floatOfHalf(Half half) {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16, rest = half & 0x7fffU;
    if (rest >= 0x7c00U) return std::bit_cast<float>(sign | 0x7f800000U | (rest & 0x3ffU) << 13);  // infinite or NaN
    // Shifted into place the exponent is 112 too small; the product puts that right, for subnormals too.
    const float magnitude = std::bit_cast<float>(rest << 13) * std::bit_cast<float>(0x77800000U);  // 2^112
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(magnitude));
}

/// The same of what is neither infinite nor NaN, without branches: a loop of it goes several at a time.
inline float floatOfFiniteHalf(Half half) {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16, rest = half & 0x7fffU;
    const float small = static_cast<float>(static_cast<std::int32_t>(rest)) * 5.9604644775390625e-8F;  // 2^-24
    const float normal = std::bit_cast<float>((rest << 13) + 0x38000000U);
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(rest < 0x400U ? small : normal));
}

/// To nearest, ties to even; magnitudes of 65520 and more become infinite.
inline Half halfOfFloat(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value), sign = bits >> 16 & 0x8000U;
    const std::uint32_t rest = bits & 0x7fffffffU;
    std::uint32_t out;
    if (rest >= 0x47800000U) {  // 65536 and more, infinite, NaN
        out = rest > 0x7f800000U ? 0x7e00U : 0x7c00U;
    } else if (rest < 0x38800000U) {  // below the smallest normal half: let the adder round
        out = std::bit_cast<std::uint32_t>(std::bit_cast<float>(rest) + 0.5F) - 0x3f000000U;
    } else {
        out = (rest - 0x38000000U + 0xfffU + (rest >> 13 & 1U)) >> 13;
    }
    return static_cast<Half>(sign | out);
}

/// The same for magnitudes of at most 65504, without branches: a loop of it goes several at a time.
inline Half halfOfFiniteFloat(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value), sign = bits >> 16 & 0x8000U;
    const std::uint32_t rest = bits & 0x7fffffffU;
    const std::uint32_t small = std::bit_cast<std::uint32_t>(std::bit_cast<float>(rest) + 0.5F) - 0x3f000000U;
    const std::uint32_t normal = (rest - 0x38000000U + 0xfffU + (rest >> 13 & 1U)) >> 13;
    return static_cast<Half>(sign | (rest < 0x38800000U ? small : normal));
}

}  // namespace photic::runtime
