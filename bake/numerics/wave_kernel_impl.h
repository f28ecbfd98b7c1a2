// SPDX-License-Identifier: Apache-2.0
// Included once for each instruction set, with PHOTIC_ISA as its namespace.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "bake/numerics/wave_kernel.h"
#include "bake/simd/lanes.h"

namespace photic::PHOTIC_ISA {
namespace {

using WavePadded = float[12][12][16];  // [x + 2][y + 2][z + 4]

constexpr int at(int x, int y, int z) { return x << 6 | y << 3 | z; }

void pad(const WaveBlock& block, WavePadded& p) {
    const auto row = [](const float* from, int x, int y) { return from + at(x, y, 0); };
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            float* to = p[x + 2][y + 2];
            std::memcpy(to + 4, row(block.now, x, y), 32);
            std::memcpy(to + 2, row(block.side[4], x, y) + 6, 8);
            std::memcpy(to + 12, row(block.side[5], x, y), 8);
        }
        for (int k = 0; k < 2; ++k) {
            std::memcpy(p[x + 2][k] + 4, row(block.side[2], x, 6 + k), 32);
            std::memcpy(p[x + 2][10 + k] + 4, row(block.side[3], x, k), 32);
        }
    }
    for (int k = 0; k < 2; ++k) {
        for (int y = 0; y < 8; ++y) {
            std::memcpy(p[k][y + 2] + 4, row(block.side[0], 6 + k, y), 32);
            std::memcpy(p[10 + k][y + 2] + 4, row(block.side[1], k, y), 32);
        }
    }
}

/// Differences of a padded row of 8 cells along an axis; `c` points at cell z = 0 of the row.
constexpr std::array<std::ptrdiff_t, 3> kPaddedStride{12 * 16, 16, 1};

inline float second(const float* c, int axis, const WaveDifferences& d) {
    const auto a = static_cast<std::size_t>(axis);
    const std::ptrdiff_t s = kPaddedStride[a];
    return d.second_0[a] * c[0] + d.second_1[a] * (c[s] + c[-s]) + d.second_2[a] * (c[2 * s] + c[-2 * s]);
}
inline float first(const float* c, int axis, const WaveDifferences& d) {
    const auto a = static_cast<std::size_t>(axis);
    const std::ptrdiff_t s = kPaddedStride[a];
    return d.first_1[a] * (c[s] - c[-s]) + d.first_2[a] * (c[2 * s] - c[-2 * s]);
}
/// M delta+ phi half a cell after `c`: delta- of it is `second`.
inline float halfway(const float* c, int axis, const WaveDifferences& d) {
    const auto a = static_cast<std::size_t>(axis);
    const std::ptrdiff_t s = kPaddedStride[a];
    return d.half_1[a] * (c[s] - c[0]) + d.half_2[a] * (c[2 * s] - c[-s]);
}
inline float laplacian(const float* c, const WaveDifferences& d) {
    return second(c, 0, d) + second(c, 1, d) + second(c, 2, d);
}

/// A cell's next value where the speed varies: light is lost by length, so that gamma is c times that of c = 1.
inline float varied(const WaveWeights& w, float speed2, float now, float laplacian, float before) {
    const float g = (1 - w.keep) / w.keep * std::sqrt(speed2);
    return (2 * now + w.scale * speed2 * laplacian - (1 - g) * before) / (1 + g);
}

template <WaveSum sum, bool varies = false>
void stepPadded(const WaveBlock& block, const WaveWeights& w) {
    alignas(64) WavePadded p;
    pad(block, p);
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            const float* c = p[x + 2][y + 2] + 4;
            float* other = block.other + at(x, y, 0);
            float next[8], before[8];
            std::memcpy(before, other, 32);
            if constexpr (varies) {
                const float* speed2 = block.speed2 + at(x, y, 0);
                for (int z = 0; z < 8; ++z) next[z] = varied(w, speed2[z], c[z], laplacian(c + z, w.d), before[z]);
            } else {
                for (int z = 0; z < 8; ++z)
                    next[z] = w.keep * (2 * c[z] + w.scale * laplacian(c + z, w.d)) - w.lose * before[z];
            }
            std::memcpy(other, next, 32);
            if constexpr (sum != WaveSum::Nothing) {
                float* energy = block.sums + at(x, y, 0);
                for (int z = 0; z < 8; ++z) {
                    const float rate = (next[z] - before[z]) * w.per_two_steps;
                    energy[z] += rate * rate;
                    if constexpr (sum == WaveSum::EnergyAndFlux) {
                        for (int a = 0; a < 3; ++a) energy[(a + 1) * kWaveCells + z] -= rate * first(c + z, a, w.d);
                    }
                }
            }
        }
    }
}

/// Adds what the matched layer adds to the Laplacian along one axis. psi lies halfway to the next cell outwards.
template <int axis>
void matchAxis(const WavePadded& p, const WaveDifferences& d, const WaveMemory& memory, float* added) {
    constexpr auto i = static_cast<std::size_t>(axis);
    constexpr std::ptrdiff_t stride = kPaddedStride[i];
    const std::ptrdiff_t psi_from = memory.outwards[i] > 0 ? 0 : -stride, slope_from = -stride - psi_from;
    // psi with cells of zeros on either side along the axis: the layer is one block thick.
    alignas(64) WavePadded q = {};
    alignas(32) float a[8], b[8];
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            for (int z = 0; z < 8; ++z) {
                const auto k = static_cast<std::size_t>(axis == 0 ? x : axis == 1 ? y : z);
                a[z] = memory.a_half[i][k], b[z] = memory.b_half[i][k];
            }
            const float* c = p[x + 2][y + 2] + 4 + psi_from;
            float* psi = memory.psi[i] + at(x, y, 0);
            float next[8];
            for (int z = 0; z < 8; ++z) next[z] = b[z] * psi[z] + a[z] * halfway(c + z, axis, d);
            std::memcpy(psi, next, 32);
            std::memcpy(q[x + 2][y + 2] + 4, next, 32);
        }
    }
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            for (int z = 0; z < 8; ++z) {
                const auto k = static_cast<std::size_t>(axis == 0 ? x : axis == 1 ? y : z);
                a[z] = memory.a[i][k], b[z] = memory.b[i][k];
            }
            const float *c = p[x + 2][y + 2] + 4, *from = q[x + 2][y + 2] + 4 + slope_from;
            float *zeta = memory.zeta[i] + at(x, y, 0), *sum = added + at(x, y, 0);
            float next[8], total[8];
            for (int z = 0; z < 8; ++z) {
                const float slope = d.step[i] * (from[z + stride] - from[z]);
                next[z] = b[z] * zeta[z] + a[z] * (second(c + z, axis, d) + slope);
                total[z] = sum[z] + slope + next[z];
            }
            std::memcpy(zeta, next, 32);
            std::memcpy(sum, total, 32);
        }
    }
}

void stepMatched(const WaveBlock& block, const WaveWeights& w, const WaveMemory& memory) {
    alignas(64) WavePadded p;
    pad(block, p);
    for (int k = 0; k < 2; ++k) {
        if (memory.mirrors & 1u) std::memcpy(p[1 - k], p[2 + k], sizeof p[0]);
        if (memory.mirrors & 2u) std::memcpy(p[10 + k], p[9 - k], sizeof p[0]);
        for (int x = 2; x < 10; ++x) {
            if (memory.mirrors & 4u) std::memcpy(p[x][1 - k], p[x][2 + k], sizeof p[0][0]);
            if (memory.mirrors & 8u) std::memcpy(p[x][10 + k], p[x][9 - k], sizeof p[0][0]);
        }
    }
    alignas(64) float added[kWaveCells] = {};  // to the Laplacian
    if (memory.psi[0]) matchAxis<0>(p, w.d, memory, added);
    if (memory.psi[1]) matchAxis<1>(p, w.d, memory, added);
    if (memory.psi[2]) matchAxis<2>(p, w.d, memory, added);
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const float *c = p[x + 2][y + 2] + 4, *more = added + at(x, y, 0);
            float* other = block.other + at(x, y, 0);
            float next[8];
            if (block.speed2) {
                const float* speed2 = block.speed2 + at(x, y, 0);
                for (int z = 0; z < 8; ++z)
                    next[z] = varied(w, speed2[z], c[z], laplacian(c + z, w.d) + more[z], other[z]);
            } else {
                for (int z = 0; z < 8; ++z)
                    next[z] = w.keep * (2 * c[z] + w.scale * (laplacian(c + z, w.d) + more[z])) - w.lose * other[z];
            }
            std::memcpy(other, next, 32);
        }
}

void stepSponge(const WaveBlock& block, const WaveWeights& w, const std::array<std::array<float, 8>, 3>& damping) {
    alignas(64) WavePadded p;
    pad(block, p);
    const float own = (1 - w.keep) / w.keep;  // gamma dt of the medium
    for (std::size_t x = 0; x < 8; ++x)
        for (std::size_t y = 0; y < 8; ++y) {
            const float* c = p[x + 2][y + 2] + 4;
            float* other = block.other + at(static_cast<int>(x), static_cast<int>(y), 0);
            for (std::size_t z = 0; z < 8; ++z) {
                const float g = own + damping[0][x] + damping[1][y] + damping[2][z];
                other[z] = (2 * c[z] + w.scale * laplacian(c + z, w.d) - (1 - g) * other[z]) / (1 + g);
            }
        }
}

/// The largest towards each side of what is largest in the quarters along x and y, by z.
void byHalves(const float (&octant)[2][2][8], std::array<float, 6>& largest) {
    largest = {};
    for (int x = 0; x < 2; ++x)
        for (int y = 0; y < 2; ++y)
            for (int half = 0; half < 2; ++half) {
                const float* o = octant[x][y] + 4 * half;
                const float m = std::max(std::max(o[0], o[1]), std::max(o[2], o[3]));
                for (const int side : {x, 2 + y, 4 + half}) {
                    float& l = largest[static_cast<std::size_t>(side)];
                    l = std::max(l, m);
                }
            }
}

void halves(const float* now, const float* other, std::array<float, 6>& largest) {
    float octant[2][2][8] = {};  // x half, y half, by z
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) {
                const int i = at(x, y, z);
                float& m = octant[x >> 2][y >> 2][z];
                const float a = std::fabs(now[i]), b = std::fabs(other[i]);
                const float c = a > b ? a : b;
                m = c > m ? c : m;
            }
    byHalves(octant, largest);
}

#if defined(__AVX2__)
using Row = F8;

/// The upper half of `a` and the lower half of `b`.
inline Row joined(Row a, Row b) { return Row(_mm256_permute2f128_ps(__m256(a), __m256(b), 0x21)); }
/// In each half: elements from `by` of the half of `a`, then those of the half of `b`.
template <int by>
inline Row shifted(Row a, Row b) {
    return Row(_mm256_castsi256_ps(
        _mm256_alignr_epi8(_mm256_castps_si256(__m256(b)), _mm256_castps_si256(__m256(a)), 4 * by)));
}
inline Row loadRow(const float* from) { return load<Row>(from); }
inline Row all(float v) { return splat<Row>(v); }

/// As stepPadded without the copy: whole rows of 8 cells along z, whose neighbours along z are shuffled from the rows
/// of the blocks below and above.
template <WaveSum sum, bool look>
void stepRows(const WaveBlock& block, const WaveWeights& w) {
    const WaveDifferences& d = w.d;
    [[maybe_unused]] Row greatest[2][2] = {};  // |phi| by the halves along x and y
    const float k = w.keep * w.scale;
    const Row centre = all(w.keep * (2 + w.scale * (d.second_0[0] + d.second_0[1] + d.second_0[2])));
    const Row x1 = all(k * d.second_1[0]), x2 = all(k * d.second_2[0]), y1 = all(k * d.second_1[1]),
              y2 = all(k * d.second_2[1]), z1 = all(k * d.second_1[2]), z2 = all(k * d.second_2[2]);
    const Row lose = all(w.lose), per_two_steps = all(w.per_two_steps);
    for (int x = 0; x < 8; ++x) {
        const auto plane = [&](int i) {
            return i < 0   ? block.side[0] + at(8 + i, 0, 0)
                   : i > 7 ? block.side[1] + at(i - 8, 0, 0)
                           : block.now + at(i, 0, 0);
        };
        const float *xm2 = plane(x - 2), *xm1 = plane(x - 1), *here = plane(x), *xp1 = plane(x + 1),
                    *xp2 = plane(x + 2);
        const float *below = block.side[4] + at(x, 0, 0), *above = block.side[5] + at(x, 0, 0);
        Row line[12];  // the rows y = -2 .. 9
        for (int y = 0; y < 2; ++y) line[y] = loadRow(block.side[2] + at(x, 6 + y, 0));
        for (int y = 0; y < 8; ++y) line[y + 2] = loadRow(here + 8 * y);
        for (int y = 0; y < 2; ++y) line[y + 10] = loadRow(block.side[3] + at(x, y, 0));
#pragma GCC unroll 8
        for (int y = 0; y < 8; ++y) {
            const Row c = line[y + 2], low = loadRow(below + 8 * y), high = loadRow(above + 8 * y);
            const Row before_c = joined(low, c), after_c = joined(c, high);
            const Row zm1 = shifted<3>(before_c, c), zm2 = shifted<2>(before_c, c);
            const Row zp1 = shifted<1>(c, after_c), zp2 = shifted<2>(c, after_c);
            const Row am2 = loadRow(xm2 + 8 * y), am1 = loadRow(xm1 + 8 * y), ap1 = loadRow(xp1 + 8 * y),
                      ap2 = loadRow(xp2 + 8 * y);
            const Row bm2 = line[y], bm1 = line[y + 1], bp1 = line[y + 3], bp2 = line[y + 4];
            float* other = block.other + at(x, y, 0);
            const Row before = loadRow(other);
            Row next = centre * c - lose * before;
            next += x1 * (ap1 + am1) + x2 * (ap2 + am2);
            next += y1 * (bp1 + bm1) + y2 * (bp2 + bm2);
            next += z1 * (zp1 + zm1) + z2 * (zp2 + zm2);
            store(other, next);
            if constexpr (look) {
                Row& m = greatest[x >> 2][y >> 2];
                m = most(m, most(absolute(next), absolute(c)));
            }
            if constexpr (sum != WaveSum::Nothing) {
                float* energy = block.sums + at(x, y, 0);
                const Row rate = (next - before) * per_two_steps;
                store(energy, loadRow(energy) + rate * rate);
                if constexpr (sum == WaveSum::EnergyAndFlux) {
                    const auto subtract = [&](int a, Row p1, Row m1, Row p2, Row m2) {
                        float* flux = energy + (a + 1) * kWaveCells;
                        const auto i = static_cast<std::size_t>(a);
                        store(flux,
                              loadRow(flux) - rate * (all(d.first_1[i]) * (p1 - m1) + all(d.first_2[i]) * (p2 - m2)));
                    };
                    subtract(0, ap1, am1, ap2, am2);
                    subtract(1, bp1, bm1, bp2, bm2);
                    subtract(2, zp1, zm1, zp2, zm2);
                }
            }
        }
    }
    if constexpr (look) {
        float octant[2][2][8];
        for (int x = 0; x < 2; ++x)
            for (int y = 0; y < 2; ++y) store(octant[x][y], greatest[x][y]);
        byHalves(octant, *block.largest);
    }
}
#else
template <WaveSum sum, bool look>
void stepRows(const WaveBlock& block, const WaveWeights& w) {
    stepPadded<sum>(block, w);
    if constexpr (look) halves(block.now, block.other, *block.largest);
}
#endif

}  // namespace
}  // namespace photic::PHOTIC_ISA
