// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include <Imath/half.h>

#include <cstring>

#include "bake/simd/lanes.h"
#include "bake/volume/half_floats.h"

namespace photic::PHOTIC_ISA {
namespace {

void toHalf(const float* from, std::size_t count, std::uint16_t* to) {
    std::size_t i = 0;
#if defined(__F16C__)
    for (; i + 8 <= count; i += 8)
        _mm_storeu_si128((__m128i*)(to + i), _mm256_cvtps_ph(_mm256_loadu_ps(from + i), _MM_FROUND_TO_NEAREST_INT));
#endif
    for (; i < count; ++i) to[i] = imath_float_to_half(from[i]);
}

void toFloat(const char* from, std::size_t count, float* to) {
    std::size_t i = 0;
#if defined(__F16C__)
    for (; i + 8 <= count; i += 8)
        _mm256_storeu_ps(to + i, _mm256_cvtph_ps(_mm_loadu_si128((const __m128i*)(from + 2 * i))));
#endif
    for (; i < count; ++i) {
        std::uint16_t half;
        std::memcpy(&half, from + 2 * i, 2);
        to[i] = imath_half_to_float(half);
    }
}

}  // namespace

HalfConversion halfConversionHere() { return {toHalf, toFloat}; }

}  // namespace photic::PHOTIC_ISA
