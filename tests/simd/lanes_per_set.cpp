// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include "bake/simd/lanes.h"
#include "tests/simd/lane_results.h"

namespace photic::PHOTIC_ISA {
namespace {

template <class V>
V loaded(const double* from) {
    V v;
    for (int l = 0; l < laneCount<V>; ++l) v[l] = static_cast<ElementOf<V>>(from[l]);
    return v;
}

template <class V>
void keep(V v, LaneResults::Numbers& out) {
    ElementOf<V> numbers[laneCount<V>];
    store(numbers, v);
    for (int l = 0; l < laneCount<V>; ++l) out[static_cast<std::size_t>(l)] = numbers[l];
}

template <class V>
void operate(const double* a_from, const double* b_from, const double* c_from, const double* d_from, LaneResults& out) {
    const V a = loaded<V>(a_from), b = loaded<V>(b_from), c = loaded<V>(c_from);
    out.count = laneCount<V>;
    keep(least(a, b), out.least), keep(most(a, b), out.most), keep(absolute(b), out.absolute);
    keep(clampTo(b, splat<V>(-1), splat<V>(1)), out.clamped);
    keep(squareRoot(a), out.root), keep(floorOf(a, out.index.data()), out.whole), keep(iota<V>(), out.iota);
    ElementOf<V> table[16];
    for (int l = 0; l < 16; ++l) table[l] = static_cast<ElementOf<V>>(a_from[l]);
    std::int32_t backwards[laneCount<V>];
    for (int l = 0; l < laneCount<V>; ++l) backwards[l] = 15 - l;
    keep(gather<V>(table, backwards), out.gathered);
    out.least_lane = leastLane(b), out.most_lane = mostLane(b);
    if constexpr (isDoubles<V>) {
        out.less = bitsOf(a < b);
    } else {
        const V d = loaded<V>(d_from);
        keep(differenceOfProducts(a, b, c, d), out.difference), keep(reciprocal(a), out.reciprocal);
        keep(exponential(-a), out.power);
    }
}

}  // namespace

void laneOperations(int type, const double* a, const double* b, const double* c, const double* d, LaneResults& out) {
    switch (type) {
        case 0:
            return operate<D2>(a, b, c, d, out);
        case 1:
            return operate<D4>(a, b, c, d, out);
        case 2:
            return operate<D8>(a, b, c, d, out);
        case 3:
            return operate<F4>(a, b, c, d, out);
        case 4:
            return operate<F8>(a, b, c, d, out);
        default:
            return operate<F16>(a, b, c, d, out);
    }
}

}  // namespace photic::PHOTIC_ISA
