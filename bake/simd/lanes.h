// SPDX-License-Identifier: Apache-2.0
// Numbers side by side in a vector register: 4, 8 or 16 floats; 2, 4 or 8 doubles. Included only by files that
// cmake/photic_kernels.cmake compiles once per instruction set: everything lives in the namespace PHOTIC_ISA, so that
// no inline function of one instruction set is linked into another.
//
// Vectors narrower than the widest registers of a set are as good as those, wider ones are made of several. The same
// operations give the same bits in every set, but for fused products (-ffp-contract=fast) and `reciprocal`.
#pragma once

#ifndef PHOTIC_ISA
#error "lanes.h is for files of photic_kernels (cmake/photic_kernels.cmake)"
#endif

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace photic::PHOTIC_ISA {

typedef float F4 __attribute__((vector_size(16)));
typedef float F8 __attribute__((vector_size(32)));
typedef float F16 __attribute__((vector_size(64)));
typedef double D2 __attribute__((vector_size(16)));
typedef double D4 __attribute__((vector_size(32)));
typedef double D8 __attribute__((vector_size(64)));
typedef std::int32_t I4 __attribute__((vector_size(16)));
typedef std::int32_t I8 __attribute__((vector_size(32)));
typedef std::int32_t I16 __attribute__((vector_size(64)));

/// The widest that the set has registers for, so that a loop over a row takes the fewest steps.
#if defined(__AVX512F__)
using WidestFloats = F16;
using WidestDoubles = D8;
#elif defined(__AVX2__)
using WidestFloats = F8;
using WidestDoubles = D4;
#else
using WidestFloats = F4;
using WidestDoubles = D2;
#endif

template <int N>
struct LanesOf;
template <>
struct LanesOf<4> {
    using F = F4;
    using I = I4;
};
template <>
struct LanesOf<8> {
    using F = F8;
    using I = I8;
};
template <>
struct LanesOf<16> {
    using F = F16;
    using I = I16;
};

template <class V>
using ElementOf = std::remove_cvref_t<decltype(V{}[0])>;
template <class V>
inline constexpr int laneCount = static_cast<int>(sizeof(V) / sizeof(ElementOf<V>));
/// What a comparison of two V gives: all bits of a lane, or none.
template <class V>
using MaskOf = decltype(V{} < V{});
template <class V>
inline constexpr bool isDoubles = std::is_same_v<ElementOf<V>, double>;

template <class V>
inline V splat(ElementOf<V> x) {
    return V{} + x;
}

template <class V>
inline V load(const ElementOf<V>* p) {
    V v;
    std::memcpy(&v, p, sizeof(V));
    return v;
}

template <class V>
inline void store(ElementOf<V>* p, V v) {
    std::memcpy(p, &v, sizeof(V));
}

template <class V>
inline V iota() {
    V v{};
    for (int l = 0; l < laneCount<V>; ++l) v[l] = static_cast<ElementOf<V>>(l);
    return v;
}

template <class V>
inline V least(V a, V b) {
    // As the instructions, the second where one is no number.
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && isDoubles<V>) return (V)_mm512_min_pd((__m512d)a, (__m512d)b);
    if constexpr (sizeof(V) == 64 && !isDoubles<V>) return (V)_mm512_min_ps((__m512)a, (__m512)b);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32 && isDoubles<V>) return (V)_mm256_min_pd((__m256d)a, (__m256d)b);
    if constexpr (sizeof(V) == 32 && !isDoubles<V>) return (V)_mm256_min_ps((__m256)a, (__m256)b);
    if constexpr (sizeof(V) == 16 && isDoubles<V>) return (V)_mm_min_pd((__m128d)a, (__m128d)b);
    if constexpr (sizeof(V) == 16 && !isDoubles<V>) return (V)_mm_min_ps((__m128)a, (__m128)b);
#endif
    return a < b ? a : b;
}

template <class V>
inline V most(V a, V b) {
    // As the instructions, the second where one is no number.
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && isDoubles<V>) return (V)_mm512_max_pd((__m512d)a, (__m512d)b);
    if constexpr (sizeof(V) == 64 && !isDoubles<V>) return (V)_mm512_max_ps((__m512)a, (__m512)b);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32 && isDoubles<V>) return (V)_mm256_max_pd((__m256d)a, (__m256d)b);
    if constexpr (sizeof(V) == 32 && !isDoubles<V>) return (V)_mm256_max_ps((__m256)a, (__m256)b);
    if constexpr (sizeof(V) == 16 && isDoubles<V>) return (V)_mm_max_pd((__m128d)a, (__m128d)b);
    if constexpr (sizeof(V) == 16 && !isDoubles<V>) return (V)_mm_max_ps((__m128)a, (__m128)b);
#endif
    return a > b ? a : b;
}

template <class V>
inline V clampTo(V x, V low, V high) {
    return least(most(x, low), high);
}

template <class V>
inline V absolute(V x) {
    return most(x, -x);
}

template <class V>
inline ElementOf<V> leastLane(V v) {
#if defined(__AVX512F__)
    if constexpr (laneCount<V> == 16) return _mm512_reduce_min_ps((__m512)v);
#endif
    ElementOf<V> m = v[0];
    for (int l = 1; l < laneCount<V>; ++l) m = v[l] < m ? v[l] : m;
    return m;
}

template <class V>
inline ElementOf<V> mostLane(V v) {
#if defined(__AVX512F__)
    if constexpr (laneCount<V> == 16) return _mm512_reduce_max_ps((__m512)v);
#endif
    ElementOf<V> m = v[0];
    for (int l = 1; l < laneCount<V>; ++l) m = v[l] > m ? v[l] : m;
    return m;
}

/// Square roots, rounded correctly.
template <class V>
inline V squareRoot(V v) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && isDoubles<V>) return (V)_mm512_sqrt_pd((__m512d)v);
    if constexpr (sizeof(V) == 64 && !isDoubles<V>) return (V)_mm512_sqrt_ps((__m512)v);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32 && isDoubles<V>) return (V)_mm256_sqrt_pd((__m256d)v);
    if constexpr (sizeof(V) == 32 && !isDoubles<V>) return (V)_mm256_sqrt_ps((__m256)v);
#endif
    V root;
    for (int l = 0; l < laneCount<V>; ++l) root[l] = std::sqrt(v[l]);
    return root;
}

/// The whole part of 0 <= v < 2^31, as numbers and as integers.
template <class V>
inline V floorOf(V v, std::int32_t* index) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && isDoubles<V>) {
        const __m256i i = _mm512_cvttpd_epi32((__m512d)v);
        _mm256_storeu_si256((__m256i*)index, i);
        return (V)_mm512_cvtepi32_pd(i);
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32 && isDoubles<V>) {
        const __m128i i = _mm256_cvttpd_epi32((__m256d)v);
        _mm_storeu_si128((__m128i*)index, i);
        return (V)_mm256_cvtepi32_pd(i);
    }
#endif
    V whole;
    for (int l = 0; l < laneCount<V>; ++l)
        index[l] = static_cast<std::int32_t>(v[l]), whole[l] = static_cast<ElementOf<V>>(index[l]);
    return whole;
}

/// from[index[l]] for each lane.
template <class V>
inline V gather(const ElementOf<V>* from, const std::int32_t* index) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && isDoubles<V>)
        return (V)_mm512_i32gather_pd(_mm256_loadu_si256((const __m256i*)index), from, 8);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32 && isDoubles<V>)
        return (V)_mm256_i32gather_pd(from, _mm_loadu_si128((const __m128i*)index), 8);
    if constexpr (sizeof(V) == 32 && !isDoubles<V>)
        return (V)_mm256_i32gather_ps(from, _mm256_loadu_si256((const __m256i*)index), 4);
#endif
    V v;
    for (int l = 0; l < laneCount<V>; ++l) v[l] = from[index[l]];
    return v;
}

/// One bit a lane of a comparison of doubles.
template <class M>
inline unsigned bitsOf(M mask) {
#if defined(__AVX512F__)
    if constexpr (sizeof(M) == 64) return _mm512_movepi64_mask((__m512i)mask);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(M) == 32) return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#endif
    unsigned bits = 0;
    for (int l = 0; l < static_cast<int>(sizeof(M) / sizeof(mask[0])); ++l) bits |= (mask[l] != 0 ? 1u : 0u) << l;
    return bits;
}

/// a b - c d without cancellation of the rounding errors: Kahan's difference of products where there is an FMA,
/// otherwise in double.
template <class V>
inline V differenceOfProducts(V a, V b, V c, V d) {
#if defined(__AVX512F__)
    if constexpr (laneCount<V> == 16) {
        const __m512 w = _mm512_mul_ps((__m512)c, (__m512)d);
        const __m512 e = _mm512_fnmadd_ps((__m512)c, (__m512)d, w);
        return (V)_mm512_add_ps(_mm512_fmsub_ps((__m512)a, (__m512)b, w), e);
    }
#endif
#if defined(__FMA__)
    if constexpr (laneCount<V> == 8) {
        const __m256 w = _mm256_mul_ps((__m256)c, (__m256)d);
        const __m256 e = _mm256_fnmadd_ps((__m256)c, (__m256)d, w);
        return (V)_mm256_add_ps(_mm256_fmsub_ps((__m256)a, (__m256)b, w), e);
    }
    if constexpr (laneCount<V> == 4) {
        const __m128 w = _mm_mul_ps((__m128)c, (__m128)d);
        const __m128 e = _mm_fnmadd_ps((__m128)c, (__m128)d, w);
        return (V)_mm_add_ps(_mm_fmsub_ps((__m128)a, (__m128)b, w), e);
    }
#endif
    V out;
    for (int l = 0; l < laneCount<V>; ++l)
        out[l] = static_cast<float>(static_cast<double>(a[l]) * b[l] - static_cast<double>(c[l]) * d[l]);
    return out;
}

/// 1 / x to 2^-23 or better, for x that is neither 0 nor subnormal.
template <class V>
inline V reciprocal(V x) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
    // 14 bits from the table and one step of Newton's: a division would cost as much as the rest of a row.
    V r;
    if constexpr (laneCount<V> == 16)
        r = (V)_mm512_rcp14_ps((__m512)x);
    else if constexpr (laneCount<V> == 8)
        r = (V)_mm256_rcp14_ps((__m256)x);
    else
        r = (V)_mm_rcp14_ps((__m128)x);
    return r * (2.0f - x * r);
#else
    return 1.0f / x;
#endif
}

/// exp(x) for x <= 0, relative error below 3e-7 (Cephes' polynomial).
template <class V>
inline V exponential(V x) {
    using I = typename LanesOf<laneCount<V>>::I;
    x = most(x, splat<V>(-87.0f));
    const V k =
        __builtin_convertvector(__builtin_convertvector(x * 1.44269504f - 0.5f, I), V);  // trunc of a negative: rounds
    V r = x - k * 0.693359375f;
    r = r + k * 2.12194440e-4f;
    V p = splat<V>(1.9875691500e-4f);
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    p = p * r * r + r + 1.0f;
    const I scale = (__builtin_convertvector(k, I) + 127) << 23;
    V s;
    std::memcpy(&s, &scale, sizeof(V));
    return p * s;
}

}  // namespace photic::PHOTIC_ISA
