// SPDX-License-Identifier: Apache-2.0
// Feet of points on a height field, a register of points at a time. Included by one translation unit per instruction
// set, which defines PHOTIC_ISA.
#pragma once

#include "bake/numerics/foot_kernel.h"
#include "bake/simd/double_lanes.h"

namespace photic::PHOTIC_ISA {
namespace {

constexpr int kMaxSteps = 40;

struct SplineWeights {
    Lanes w[4], d[4], s[4];
};
inline void weightsAt(const Lanes& t, SplineWeights& k) {
    const Lanes u = 1 - t, t2 = t * t, u2 = u * u;
    k.w[0] = u2 * u * (1.0 / 6), k.w[1] = 2.0 / 3 - t2 + 0.5 * t2 * t;
    k.w[2] = 2.0 / 3 - u2 + 0.5 * u2 * u, k.w[3] = t2 * t * (1.0 / 6);
    k.d[0] = -0.5 * u2, k.d[1] = 1.5 * t2 - 2 * t, k.d[2] = 2 * u - 1.5 * u2, k.d[3] = 0.5 * t2;
    k.s[0] = u, k.s[1] = 3 * t - 2, k.s[2] = 1 - 3 * t, k.s[3] = t;
}

struct SurfaceLanes {
    Lanes h, hx, hy, hxx, hxy, hyy;
};
inline void surfaceAt(const HeightTable& table, const Lanes& x, const Lanes& y, SurfaceLanes& out) {
    const double inverse = 1 / table.spacing();
    const Lanes px = most(least((x - table.corner().x) * inverse, splat(table.countX() - 3)), splat(1));
    const Lanes py = most(least((y - table.corner().y) * inverse, splat(table.countY() - 3)), splat(1));
    std::int32_t i[8], j[8], at[8];
    const Lanes tx = px - floorOf(px, i), ty = py - floorOf(py, j);
    for (int l = 0; l < kLanes; ++l) at[l] = (j[l] - 1) * table.countX() + i[l] - 1;
    SplineWeights kx, ky;
    weightsAt(tx, kx), weightsAt(ty, ky);
    out.h = out.hx = out.hy = out.hxx = out.hxy = out.hyy = Lanes{};
    for (int b = 0; b < 4; ++b) {
        const double* row = table.coefficients() + static_cast<std::int64_t>(b) * table.countX();
        const Lanes c0 = gather(row, at), c1 = gather(row + 1, at), c2 = gather(row + 2, at), c3 = gather(row + 3, at);
        const Lanes value = kx.w[0] * c0 + kx.w[1] * c1 + kx.w[2] * c2 + kx.w[3] * c3;
        const Lanes first = kx.d[0] * c0 + kx.d[1] * c1 + kx.d[2] * c2 + kx.d[3] * c3;
        const Lanes second = kx.s[0] * c0 + kx.s[1] * c1 + kx.s[2] * c2 + kx.s[3] * c3;
        out.h += ky.w[b] * value, out.hx += ky.w[b] * first, out.hy += ky.d[b] * value;
        out.hxx += ky.w[b] * second, out.hxy += ky.d[b] * first, out.hyy += ky.s[b] * value;
    }
    out.hx *= inverse, out.hy *= inverse;
    const double inverse2 = inverse * inverse;
    out.hxx *= inverse2, out.hxy *= inverse2, out.hyy *= inverse2;
}

inline Lanes placesOf(const FootRow& row, int first) {
    Lanes x = splat(row.x0 + row.step * first);
    for (int l = 1; l < kLanes; ++l) x[l] += row.step * l;
    return x;
}

/// The register of points that starts at `first`. `kPoint`: what comes in comes from a point.
template <bool kPoint>
inline void solveFeet(const FrontOnSurface& front, const FootRow& row, int first, FootPointLayer& here) {
    const std::size_t at = row.first + static_cast<std::size_t>(first);
    const double n = front.slowness, outside = front.outside;
    Lanes gx = splat(front.gradient.x), gy = splat(front.gradient.y), gz = splat(front.gradient.z);
    const Lanes x = placesOf(row, first);
    Lanes u = load(&here.foot_x[at]), v = load(&here.foot_y[at]);
    const double small = 3e-6 * row.step, longest = 2 * row.step, nearest = 1e-12 * row.step;
    SurfaceLanes s;
    Lanes r, px, py, pz, a11, a12, a22, m11, m12, m22, before{};
    // A point whose last step was small is done: its arrival is right to the square of that.
    for (int step = 0; step < kMaxSteps; ++step) {
        surfaceAt(*front.surface, u, v, s);
        px = x - u, py = row.y - v, pz = row.z - s.h;
        r = most(squareRoot(px * px + py * py + pz * pz), splat(nearest));
        const Lanes inverse = 1 / r;
        px *= inverse, py *= inverse, pz *= inverse;  // unit direction of travel
        const Lanes wu = px + pz * s.hx, wv = py + pz * s.hy;
        Lanes q11{}, q12{}, q22{};
        if constexpr (kPoint) {  // what comes from a point has a curvature of its own
            const Lanes sx = u - front.source.x, sy = v - front.source.y, sz = s.h - front.source.z;
            before = squareRoot(sx * sx + sy * sy + sz * sz);
            const Lanes scale = outside / before, over = 1 / (before * before);
            gx = sx * scale, gy = sy * scale, gz = sz * scale;
            const Lanes su = sx + sz * s.hx, sv = sy + sz * s.hy;
            q11 = scale * (1 + s.hx * s.hx - su * su * over), q12 = scale * (s.hx * s.hy - su * sv * over);
            q22 = scale * (1 + s.hy * s.hy - sv * sv * over);
        }
        const Lanes g1 = gx + gz * s.hx - n * wu, g2 = gy + gz * s.hy - n * wv;
        // Hessian times distance: r A + n P.
        const Lanes bend = gz - n * pz;
        a11 = bend * s.hxx + q11, a12 = bend * s.hxy + q12, a22 = bend * s.hyy + q22;
        m11 = 1 + s.hx * s.hx - wu * wu, m12 = s.hx * s.hy - wu * wv, m22 = 1 + s.hy * s.hy - wv * wv;
        Lanes h11 = r * a11 + n * m11, h12 = r * a12 + n * m12, h22 = r * a22 + n * m22;
        const LaneMask convex = (h11 * h22 > h12 * h12) & (h11 > 0);
        // Past a focus the parabola opens downwards: without its bend it points downhill.
        h11 = convex ? h11 : n * m11 + r * absolute(a11) + r * absolute(a12);
        h12 = convex ? h12 : splat(0);
        h22 = convex ? h22 : n * m22 + r * absolute(a22) + r * absolute(a12);
        const Lanes scale = -r / (h11 * h22 - h12 * h12);
        Lanes du = (h22 * g1 - h12 * g2) * scale, dv = (h11 * g2 - h12 * g1) * scale;
        const Lanes size = most(absolute(du), absolute(dv));
        const Lanes shorten = longest / most(size, splat(longest));
        du *= shorten, dv *= shorten;
        const LaneMask moving = size > small;
        if (!any(moving) || step + 1 == kMaxSteps) break;
        u = moving ? u + du : u, v = moving ? v + dv : v;
    }
    const Lanes inverse = 1 / (n * (m11 * m22 - m12 * m12));
    const Lanes trace = (m22 * a11 - 2 * m12 * a12 + m11 * a22) * inverse;
    const Lanes det = (a11 * a22 - a12 * a12) * inverse / n;
    const Lanes spread = 1 + r * (trace + r * det);
    const Lanes foot_arrival = kPoint ? outside * before : gx * u + gy * v + gz * s.h;
    store(&here.foot_x[at], u), store(&here.foot_y[at], v), store(&here.foot_z[at], s.h);
    store(&here.foot_arrival[at], foot_arrival);
    store(&here.slope_x[at], s.hx), store(&here.slope_y[at], s.hy);
    store(&here.arrival[at], foot_arrival + n * r), store(&here.distance[at], r);
    store(&here.curvature[at], (trace + 2 * r * det) / spread), store(&here.spread[at], spread);
}

void solveFootRow(const FrontOnSurface& front, const FootRow& row, FootPointLayer& here) {
    if (front.outside > 0)
        for (int first = 0; first < row.count; first += kLanes) solveFeet<true>(front, row, first, here);
    else
        for (int first = 0; first < row.count; first += kLanes) solveFeet<false>(front, row, first, here);
}

/// Arrival at points by the feet that others found.
inline Lanes arrivalBy(const FootPointLayer& layer, std::size_t at, const Lanes& x, double y, double z,
                       double slowness) {
    const Lanes dx = x - load(&layer.foot_x[at]), dy = y - load(&layer.foot_y[at]), dz = z - load(&layer.foot_z[at]);
    return load(&layer.foot_arrival[at]) + slowness * squareRoot(dx * dx + dy * dy + dz * dz);
}

void guessFootRow(const FrontOnSurface& front, const FootRow& row, const FootPointLayer& above, FootPointLayer& here) {
    const std::size_t pitch = above.pitch;
    for (int first = 0; first < row.count; first += kLanes) {
        const std::size_t at = row.first + static_cast<std::size_t>(first);
        const Lanes x = placesOf(row, first);
        const Lanes own_x = load(&above.foot_x[at]), own_y = load(&above.foot_y[at]);
        Lanes best = arrivalBy(above, at, x, row.y, row.z, front.slowness), u = own_x, v = own_y;
        for (const std::size_t n : {at - 1, at + 1, at - pitch, at + pitch}) {
            const Lanes t = arrivalBy(above, n, x, row.y, row.z, front.slowness);
            const LaneMask better = t < best;
            best = better ? t : best, u = better ? load(&above.foot_x[n]) : u, v = better ? load(&above.foot_y[n]) : v;
        }
        // On the same sheet of rays the foot goes on as it did from the layer before.
        const Lanes on_x = own_x - load(&here.foot_x[at]), on_y = own_y - load(&here.foot_y[at]);
        const LaneMask same = (absolute(u - own_x) < row.apart) & (absolute(v - own_y) < row.apart);
        const LaneMask steady = (absolute(on_x) < row.apart) & (absolute(on_y) < row.apart);
        u = same ? own_x + (steady ? on_x : splat(0)) : u, v = same ? own_y + (steady ? on_y : splat(0)) : v;
        const LaneMask known = load(&above.foot_arrival[at]) < 0.5 * FootPointLayer::kAboveSurface;
        store(&here.foot_x[at], known ? u : x), store(&here.foot_y[at], known ? v : splat(row.y));
    }
}

bool footRowImprovable(const FrontOnSurface& front, const FootRow& row, double margin, const FootPointLayer& here) {
    LaneMask found{};
    for (int first = 0; first < row.count; first += kLanes) {
        const std::size_t at = row.first + static_cast<std::size_t>(first);
        const Lanes x = placesOf(row, first), own = load(&here.arrival[at]) - margin;
        const LaneMask known = own < 0.5 * FootPointLayer::kAboveSurface;
        for (const std::size_t n : {at - 1, at + 1, at - here.pitch, at + here.pitch})
            found |= known & (arrivalBy(here, n, x, row.y, row.z, front.slowness) < own);
    }
    return any(found);
}

}  // namespace
}  // namespace photic::PHOTIC_ISA
