// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include <algorithm>
#include <cmath>

#include "bake/graded/front_kernel.h"
#include "bake/simd/lanes.h"

namespace photic::PHOTIC_ISA {
namespace {

using V = WidestFloats;
constexpr int kWidth = laneCount<V>;
constexpr int kLayers = 16;
// Rows, as BentRows orders them.
enum Row { kU, kV, kSlopeU, kSlopeV, kLit, kMomentum, kLeft };

struct Weights {
    V value[4], slope[4];
};

Weights weightsAt(V t) {
    constexpr float kSixth = 1.0f / 6;
    const V u = 1.0f - t, t2 = t * t, u2 = u * u;
    return {{kSixth * u2 * u, kSixth * (4.0f - 6.0f * t2 + 3.0f * t2 * t), kSixth * (4.0f - 6.0f * u2 + 3.0f * u2 * u),
             kSixth * t2 * t},
            {-0.5f * u2, 0.5f * (3.0f * t - 4.0f) * t, 0.5f * (4.0f - 3.0f * u) * u, 0.5f * t2}};
}

struct Force {
    V value, u, v, w;  // n^2 / 2, and its slopes [1/voxel]
};

/// Four numbers in a row from each lane's place, one register for each of the four: each row is one load, and rows are
/// turned into columns in the registers. Lane by lane it took twice as long.
inline void rowsOfFour(const float* from, const std::int32_t* at, V (&out)[4]) {
#if defined(__AVX512F__)
    __m512 row[4];
    for (int q = 0; q < 4; ++q) {
        row[q] = _mm512_castps128_ps512(_mm_loadu_ps(from + at[q]));
        row[q] = _mm512_insertf32x4(row[q], _mm_loadu_ps(from + at[q + 4]), 1);
        row[q] = _mm512_insertf32x4(row[q], _mm_loadu_ps(from + at[q + 8]), 2);
        row[q] = _mm512_insertf32x4(row[q], _mm_loadu_ps(from + at[q + 12]), 3);
    }
    const __m512 a = _mm512_unpacklo_ps(row[0], row[1]), b = _mm512_unpackhi_ps(row[0], row[1]),
                 c = _mm512_unpacklo_ps(row[2], row[3]), d = _mm512_unpackhi_ps(row[2], row[3]);
    out[0] = (V)_mm512_shuffle_ps(a, c, 0x44), out[1] = (V)_mm512_shuffle_ps(a, c, 0xee);
    out[2] = (V)_mm512_shuffle_ps(b, d, 0x44), out[3] = (V)_mm512_shuffle_ps(b, d, 0xee);
#elif defined(__AVX2__)
    __m256 row[4];
    for (int q = 0; q < 4; ++q)
        row[q] =
            _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(from + at[q])), _mm_loadu_ps(from + at[q + 4]), 1);
    const __m256 a = _mm256_unpacklo_ps(row[0], row[1]), b = _mm256_unpackhi_ps(row[0], row[1]),
                 c = _mm256_unpacklo_ps(row[2], row[3]), d = _mm256_unpackhi_ps(row[2], row[3]);
    out[0] = (V)_mm256_shuffle_ps(a, c, 0x44), out[1] = (V)_mm256_shuffle_ps(a, c, 0xee);
    out[2] = (V)_mm256_shuffle_ps(b, d, 0x44), out[3] = (V)_mm256_shuffle_ps(b, d, 0xee);
#else
    for (int i = 0; i < 4; ++i) out[i] = gather<V>(from + i, at);
#endif
}

/// The index of a slice at some places [voxels].
Force forceAt(const IndexSlices& slices, std::size_t step, V u, V v) {
    const V x = u - slices.first_u, y = v - slices.first_v;
    const V low = splat<V>(1.0f), high_x = splat<V>(static_cast<float>(slices.columns) - 2.001f),
            high_y = splat<V>(static_cast<float>(slices.rows) - 2.001f);
    const V inside_x = clampTo(x, low, high_x), inside_y = clampTo(y, low, high_y);
    alignas(64) std::int32_t column[kWidth], row[kWidth], at[kWidth];
    const V whole_x = floorOf(inside_x, column), whole_y = floorOf(inside_y, row);
    const Weights wx = weightsAt(inside_x - whole_x), wy = weightsAt(inside_y - whole_y);
    const float *value = &slices.value[step * slices.plane()], *slope = &slices.slope[step * slices.plane()];
    Force f{};
    for (int j = 0; j < 4; ++j) {
        for (int l = 0; l < kWidth; ++l) at[l] = (row[l] - 1 + j) * slices.columns + column[l] - 1;
        V row_value{}, row_slope{}, row_w{}, c[4], d[4];
        rowsOfFour(value, at, c), rowsOfFour(slope, at, d);
        for (int i = 0; i < 4; ++i) {
            row_value = row_value + wx.value[i] * c[i];
            row_slope = row_slope + wx.slope[i] * c[i];
            row_w = row_w + wx.value[i] * d[i];
        }
        f.value = f.value + wy.value[j] * row_value;
        f.u = f.u + wy.value[j] * row_slope;
        f.v = f.v + wy.slope[j] * row_value;
        f.w = f.w + wy.value[j] * row_w;
    }
    // Beyond the nodes the index goes on as it is at their rim.
    const V zero{};
    f.u = x == inside_x ? f.u : zero;
    f.v = y == inside_y ? f.v : zero;
    return f;
}

/// A register of rays.
struct Group {
    V u, v, w, pu, pv, pw, lit, depth[3], time, moving;
};

/// Adds the optical depth of `length` [m] in the media at a place [voxels].
void addDepth(const FrontMarch& march, V u, V v, float w, V length, V (&depth)[3]) {
    const FrontMedia& media = *march.media;
    const IndexSlices& slices = *march.slices;
    const auto layer = static_cast<std::size_t>(std::max(0.0f, w - static_cast<float>(march.node_w) + 0.5f));
    for (int l = 0; l < kWidth; ++l) {
        const float x = std::clamp(u[l] - slices.first_u + 0.5f, 0.0f, static_cast<float>(slices.columns) - 0.5f),
                    y = std::clamp(v[l] - slices.first_v + 0.5f, 0.0f, static_cast<float>(slices.rows) - 0.5f);
        const std::uint8_t medium =
            media.of_node[static_cast<std::size_t>(x) * media.stride_u + static_cast<std::size_t>(y) * media.stride_v +
                          layer * media.stride_w];
        if (medium == 0) continue;
        for (int k = 0; k < march.channels; ++k) depth[k][l] += media.extinction[medium][k] * length[l];
    }
}

/// Mean of exp(-x) over [depth - half, depth + half].
V meanLeft(V depth, V half) {
    const V x = 2.0f * half;
    // (1 - exp(-x)) / x; its series where that would cancel.
    const V series = 1.0f - x * (0.5f - x * (1.0f / 6 - x * (1.0f / 24))), large = most(x, splat<V>(0.1f));
    return exponential<V>(half - depth) * (x < splat<V>(0.1f) ? series : (1.0f - exponential<V>(-large)) / large);
}

/// One step, to the plane `target` [voxels]; `step` counts the slab's slices in the light's order.
/// @return lanes in which the ray turns away, which stay where they are: 1, others 0
V advance(const FrontMarch& march, std::size_t step, float target, Group& ray) {
    const float sense = static_cast<float>(march.sense), share = 1.0f / static_cast<float>(march.slices->steps);
    const V zero{}, one = splat<V>(1.0f);
    // What is left to the plane: a whole step, less for rays that start on the way, 0 for those that start later.
    const V height = clampTo(sense * (target - ray.w), zero, splat<V>(share)) * ray.moving;
    const V half = 0.5f * march.voxel[2] * height;  // [m]
    const float per_u = 1.0f / march.voxel[0], per_v = 1.0f / march.voxel[1], per_w = 1.0f / march.voxel[2];
    const V first = half / ray.pw;
    const V middle_u = ray.u + per_u * ray.pu * first, middle_v = ray.v + per_v * ray.pv * first;
    const Force f = march.even > 0.0f ? Force{splat<V>(march.even), zero, zero, zero}
                                      : forceAt(*march.slices, step, middle_u, middle_v);
    const V fw = (sense * per_w) * f.w;
    const V kicked = most(ray.pw + 2.0f * first * fw, 0.05f * ray.pw);
    const V whole = first + half / kicked;
    const V pu = ray.pu + per_u * f.u * whole, pv = ray.pv + per_v * f.v * whole, pw = ray.pw + fw * whole;
    const V square = pu * pu + pv * pv + pw * pw;
    const V limit = march.least_cosine * march.least_cosine * square;
    const V turns = ((pw > zero) & (pw * pw >= limit)) ? zero : one;
    const V stops = turns * (height > zero ? one : zero);
    const V second = half / most(pw, 0.05f * ray.pw);
    const V goes = one - stops;
    const V in_medium = absolute(f.value - march.air) > march.least_lit ? one : zero;
    ray.lit = most(ray.lit, in_medium * goes * (height > zero ? one : zero));
    if (march.media && march.media->of_node)
        addDepth(march, middle_u, middle_v, target - 0.5f * sense * share, squareRoot(square) * whole * goes,
                 ray.depth);
    ray.time = ray.time + 2.0f * f.value * whole * goes;  // dT = n^2 ds
    ray.u = stops > zero ? ray.u : middle_u + per_u * pu * second;
    ray.v = stops > zero ? ray.v : middle_v + per_v * pv * second;
    const V steps = goes * (height > zero ? one : zero);
    ray.pu = steps > zero ? pu : ray.pu, ray.pv = steps > zero ? pv : ray.pv, ray.pw = steps > zero ? pw : ray.pw;
    ray.w = steps > zero ? splat<V>(target) : ray.w;
    return stops;
}

/// What a lane's rows hold after its layer.
void writeRows(const FrontMarch& march, const Group& ray, float plane, bool timed, V (*rows)[kLayers], int lane) {
    const float sense = static_cast<float>(march.sense);
    const V slope_u = sense * (march.voxel[2] / march.voxel[0]) * ray.pu / ray.pw,
            slope_v = sense * (march.voxel[2] / march.voxel[1]) * ray.pv / ray.pw;
    // Before a ray starts it is where it would come from.
    const V before = plane - ray.w;
    rows[kU][lane] = ray.u + slope_u * before, rows[kV][lane] = ray.v + slope_v * before;
    rows[kSlopeU][lane] = slope_u, rows[kSlopeV][lane] = slope_v;
    rows[kLit][lane] = ray.lit;
    const V square = ray.pu * ray.pu + ray.pv * ray.pv + ray.pw * ray.pw;
    const V momentum = squareRoot(square);
    rows[kMomentum][lane] = momentum;
    // A voxel may be many times as deep as light goes: the mean over the layer is not what is left in its middle. A
    // layer in which the ray starts begins with it.
    V half[3] = {};
    if (march.media && march.media->of_node)
        addDepth(march, ray.u, ray.v, plane, (0.5f * march.voxel[2]) * momentum / ray.pw, half);
    for (int k = 0; k < march.channels; ++k)
        rows[kLeft + k][lane] = meanLeft(ray.depth[k], least(half[k], ray.depth[k]));
    if (timed) rows[kLeft + march.channels][lane] = ray.time + (sense * march.voxel[2]) * before * square / ray.pw;
}

}  // namespace

void marchFront(const FrontMarch& march, FrontRays& rays, std::size_t first, std::size_t count, float* rows,
                std::size_t stride) {
    const bool attenuates = !rays.depth[0].empty(), timed = !rays.time.empty();
    const int per_layer = march.slices->steps, kinds = kLeft + march.channels + (timed ? 1 : 0);
    for (std::size_t from = first; from < first + count; from += kWidth) {
        Group ray{load<V>(&rays.u[from]),
                  load<V>(&rays.v[from]),
                  load<V>(&rays.w[from]),
                  load<V>(&rays.pu[from]),
                  load<V>(&rays.pv[from]),
                  load<V>(&rays.pw[from]),
                  load<V>(&rays.lit[from]),
                  {},
                  {},
                  splat<V>(1.0f)};
        for (int k = 0; k < march.channels && attenuates; ++k) ray.depth[k] = load<V>(&rays.depth[k][from]);
        if (timed) ray.time = load<V>(&rays.time[from]);
        for (int l = 0; l < kWidth; ++l)
            ray.moving[l] = rays.stopped[from + static_cast<std::size_t>(l)] < 0 ? 1.0f : 0.0f;
        V table[kLeft + 4][kLayers] = {};
        for (int i = 0; i < march.layers; ++i) {
            const int lane = march.sense > 0 ? i : march.layers - 1 - i;
            const float plane = static_cast<float>(march.first_w + lane);
            for (int s = 0; s < per_layer; ++s) {
                const float target =
                    plane - static_cast<float>(march.sense * (per_layer - 1 - s)) / static_cast<float>(per_layer);
                const V stops = advance(march, static_cast<std::size_t>(i * per_layer + s), target, ray);
                if (mostLane(stops) <= 0.0f) continue;
                for (int l = 0; l < kWidth; ++l)
                    if (stops[l] > 0.0f)
                        rays.stopped[from + static_cast<std::size_t>(l)] = static_cast<std::int8_t>(lane),
                                            ray.moving[l] = 0;
            }
            writeRows(march, ray, plane, timed, table, lane);
        }
        store(&rays.u[from], ray.u), store(&rays.v[from], ray.v), store(&rays.w[from], ray.w);
        store(&rays.pu[from], ray.pu), store(&rays.pv[from], ray.pv), store(&rays.pw[from], ray.pw);
        store(&rays.lit[from], ray.lit);
        for (int k = 0; k < march.channels && attenuates; ++k) store(&rays.depth[k][from], ray.depth[k]);
        if (timed) store(&rays.time[from], ray.time);
        if (!rows) continue;
        for (int kind = 0; kind < kinds; ++kind)
            for (int lane = march.layers; lane < kLayers; ++lane) table[kind][lane] = table[kind][march.layers - 1];
        // Nothing of the padding.
        const std::size_t live = from < rays.count ? std::min<std::size_t>(kWidth, rays.count - from) : 0;
        for (std::size_t l = 0; l < live; ++l) {
            float* out = rows + (from + l) * stride;
            for (int kind = 0; kind < kinds; ++kind)
                for (int lane = 0; lane < kLayers; ++lane) *out++ = table[kind][lane][l];
        }
    }
}

}  // namespace photic::PHOTIC_ISA
