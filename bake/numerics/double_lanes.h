// SPDX-License-Identifier: Apache-2.0
// Doubles side by side in a vector register. Included by one translation unit per instruction set, which defines
// PHOTIC_ISA: everything has internal linkage, so that no inline function of one instruction set is linked into
// another.
#pragma once

#ifndef PHOTIC_ISA
#error "define PHOTIC_ISA before including double_lanes.h"
#endif

#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace photic::PHOTIC_ISA {
namespace {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX2__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif
typedef double Lanes __attribute__((vector_size(8 * kLanes)));
typedef std::int64_t LaneMask __attribute__((vector_size(8 * kLanes)));

inline Lanes splat(double x) { return Lanes{} + x; }
inline Lanes load(const double* from) {
    Lanes v;
    std::memcpy(&v, from, sizeof(v));
    return v;
}
inline void store(double* to, const Lanes& v) { std::memcpy(to, &v, sizeof(v)); }
inline Lanes least(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
inline Lanes most(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
inline Lanes magnitude(const Lanes& a) { return a < 0 ? -a : a; }

inline Lanes squareRoot(const Lanes& v) {
#if defined(__AVX512F__)
    return reinterpret_cast<Lanes>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(v)));
#elif defined(__AVX2__)
    return reinterpret_cast<Lanes>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(v)));
#else
    return Lanes{std::sqrt(v[0]), std::sqrt(v[1])};
#endif
}

/// Whole part of 0 <= v < 2^31, as a number and as integers.
inline Lanes floorOf(const Lanes& v, std::int32_t* index) {
#if defined(__AVX512F__)
    const __m256i i = _mm512_cvttpd_epi32(reinterpret_cast<__m512d>(v));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(index), i);
    return reinterpret_cast<Lanes>(_mm512_cvtepi32_pd(i));
#elif defined(__AVX2__)
    const __m128i i = _mm256_cvttpd_epi32(reinterpret_cast<__m256d>(v));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(index), i);
    return reinterpret_cast<Lanes>(_mm256_cvtepi32_pd(i));
#else
    Lanes whole;
    for (int l = 0; l < kLanes; ++l) index[l] = static_cast<std::int32_t>(v[l]), whole[l] = index[l];
    return whole;
#endif
}

/// from[index[l]] for each lane.
inline Lanes gather(const double* from, const std::int32_t* index) {
#if defined(__AVX512F__)
    return reinterpret_cast<Lanes>(
        _mm512_i32gather_pd(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), from, 8));
#elif defined(__AVX2__)
    return reinterpret_cast<Lanes>(
        _mm256_i32gather_pd(from, _mm_loadu_si128(reinterpret_cast<const __m128i*>(index)), 8));
#else
    return Lanes{from[index[0]], from[index[1]]};
#endif
}

/// One bit a lane.
inline unsigned bitsOf(const LaneMask& m) {
#if defined(__AVX512F__)
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(m));
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(m)));
#else
    return static_cast<unsigned>((m[0] & 1) | (m[1] & 2));
#endif
}
inline bool any(const LaneMask& m) { return bitsOf(m) != 0; }

}  // namespace
}  // namespace photic::PHOTIC_ISA
