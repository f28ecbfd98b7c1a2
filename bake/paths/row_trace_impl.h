// SPDX-License-Identifier: Apache-2.0
// Tracing of regular rows in loops that a compiler vectorises; once per instruction set, as edge_kernel_impl.h.
#pragma once

#include "bake/paths/row_trace.h"
#include "bake/simd/lanes.h"

namespace photic::PHOTIC_ISA {

// Snell's law and Fresnel's equations (bake/optics/snell.h) in arithmetic only, so that the loop has no branch.
inline void traceInterface(const RowTraceSetup& setup, std::size_t count, const double* __restrict nx,
                           const double* __restrict ny, const double* __restrict nz, double* __restrict dx,
                           double* __restrict dy, double* __restrict dz, double* __restrict fraction,
                           double* __restrict untraced) {
    const double lx = setup.light_direction[0], ly = setup.light_direction[1], lz = setup.light_direction[2];
    const double n1 = setup.ior_from, n2 = setup.ior_to, eta = n1 / n2;
    const bool refract = setup.refract;
    const double kept = setup.traces_other_branch ? 0.0 : 1.0;  // of the other branch
    for (std::size_t i = 0; i < count; ++i) {
        const double inverse = 1.0 / __builtin_sqrt(nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]);
        const double ax = nx[i] * inverse, ay = ny[i] * inverse, az = nz[i] * inverse;
        const double cos_i = -(lx * ax + ly * ay + lz * az);
        const double cos2_t = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
        const double cos_t = __builtin_sqrt(cos2_t > 0.0 ? cos2_t : 0.0);
        const double r_s = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
        const double r_p = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
        const double reflectance = 0.5 * (r_s * r_s + r_p * r_p);
        const double k = refract ? eta * cos_i - cos_t : 2.0 * cos_i;
        const double e = refract ? eta : 1.0;
        dx[i] = e * lx + k * ax, dy[i] = e * ly + k * ay, dz[i] = e * lz + k * az;
        const double part = refract ? 1.0 - reflectance : reflectance;
        const bool usable = cos_i > 1e-9 && (!refract || cos2_t > 0.0);
        fraction[i] = usable ? part : 0.0;
        untraced[i] = kept * (1.0 - part);
    }
}

// Into the grid; rays that z layers do not serve lose their per_layer.
inline void placeInGrid(const RowTraceSetup& setup, std::size_t count, RayRow& row) {
    const auto& m = setup.index_from_world;
    const double ox = setup.grid_origin[0], oy = setup.grid_origin[1], oz = setup.grid_origin[2];
    const double want = setup.refract ? -1.0 : 1.0;
    const double* __restrict x = row.x.data(), * __restrict y = row.y.data(), * __restrict z = row.z.data();
    const double* __restrict dx = row.dx.data(), * __restrict dy = row.dy.data(), * __restrict dz = row.dz.data();
    const double* __restrict fraction = row.fraction.data();
    double* __restrict u = row.u.data(), * __restrict v = row.v.data(), * __restrict w = row.w.data();
    double* __restrict du = row.du.data(), * __restrict dv = row.dv.data(), * __restrict per_layer = row.per_layer.data();
    const double m00 = m[0][0], m01 = m[0][1], m02 = m[0][2], m10 = m[1][0], m11 = m[1][1], m12 = m[1][2],
                 m20 = m[2][0], m21 = m[2][1], m22 = m[2][2];
    for (std::size_t i = 0; i < count; ++i) {
        const double px = x[i] - ox, py = y[i] - oy, pz = z[i] - oz;
        u[i] = m00 * px + m10 * py + m20 * pz;
        v[i] = m01 * px + m11 * py + m21 * pz;
        w[i] = m02 * px + m12 * py + m22 * pz;
        const double gw = m02 * dx[i] + m12 * dy[i] + m22 * dz[i];
        const double inverse = 1.0 / gw;
        du[i] = (m00 * dx[i] + m10 * dy[i] + m20 * dz[i]) * inverse;
        dv[i] = (m01 * dx[i] + m11 * dy[i] + m21 * dz[i]) * inverse;
        const double au = __builtin_fabs(du[i]), av = __builtin_fabs(dv[i]);
        const bool serves = fraction[i] > 0.0 && dz[i] * want > 0.0 && au <= 1.5 && av <= 1.5;
        per_layer[i] = serves ? __builtin_fabs(inverse) : 0.0;
    }
}

// Nearest plane ahead of each ray; rays behind a plane as seen from the light are blocked.
inline void endOnPlanes(const RowTraceSetup& setup, std::size_t count, RayRow& row) {
    const double infinity = __builtin_inf();
    const double sense = setup.refract ? -1.0 : 1.0;
    const double* __restrict x = row.x.data(), * __restrict y = row.y.data(), * __restrict z = row.z.data();
    const double* __restrict dx = row.dx.data(), * __restrict dy = row.dy.data(), * __restrict dz = row.dz.data();
    double *__restrict hit = row.hit_distance.data(), *__restrict end = row.w_end.data(), *__restrict per_layer = row.per_layer.data();
    const double* __restrict u = row.u.data(), * __restrict v = row.v.data(), * __restrict w = row.w.data();
    const double* __restrict du = row.du.data(), * __restrict dv = row.dv.data();
    for (std::size_t i = 0; i < count; ++i) hit[i] = infinity, end[i] = sense * infinity;
    for (const RowPlane& plane : setup.planes) {
        const double nx = plane.normal[0], ny = plane.normal[1], nz = plane.normal[2];
        const double towards_light = -(nx * setup.sun_middle[0] + ny * setup.sun_middle[1] + nz * setup.sun_middle[2]);
        const int axis = plane.axis;
        for (std::size_t i = 0; i < count; ++i) {
            const double height = nx * x[i] + ny * y[i] + nz * z[i] - plane.offset;
            // A ray back to the light crosses the plane when it starts on the other side of it.
            const bool blocked = height * towards_light < 0.0;
            per_layer[i] = blocked ? 0.0 : per_layer[i];
            const double speed = nx * dx[i] + ny * dy[i] + nz * dz[i];
            const double t = -height / speed;
            // Grid coordinate along the plane's axis, per layer of w, and where the overshoot ends (TrackEnd).
            const double slope = axis == 0 ? du[i] : axis == 1 ? dv[i] : 1.0;
            const double start = axis == 0 ? u[i] : axis == 1 ? v[i] : w[i];
            const double layers = sense * t / (per_layer[i] > 0.0 ? per_layer[i] : 1.0);
            const double at = start + slope * layers + 0.5;
            const double along = slope * sense;
            const double border = along > 0.0 ? __builtin_floor(at - 1e-3) + 1.0 + plane.overshoot_layers
                                              : __builtin_floor(at + 1e-3) - plane.overshoot_layers;
            const double au = __builtin_fabs(du[i]), av = __builtin_fabs(dv[i]);
            const double steepest = au > av ? au : av;
            const double longest = plane.longest_overshoot / (steepest > 1.0 ? steepest : 1.0);
            const double extra = along == 0.0 ? longest : __builtin_fabs((border - at) / slope);
            const double beyond = plane.receives ? (extra < longest ? extra : longest) : 0.0;
            const double stop = w[i] + layers + sense * beyond;
            const bool nearer = t > 0.0 && t < hit[i];
            hit[i] = nearer ? t : hit[i];
            end[i] = nearer ? stop : end[i];
        }
    }
    // Light that goes on behind a wall ends at what stops it there.
    for (const RowPlane& plane : setup.planes) {
        if (plane.receives) continue;
        const double nx = plane.normal[0], ny = plane.normal[1], nz = plane.normal[2];
        for (std::size_t i = 0; i < count; ++i) {
            const double height = nx * x[i] + ny * y[i] + nz * z[i] - plane.offset;
            const double t = -height / (nx * dx[i] + ny * dy[i] + nz * dz[i]);
            const double stop = w[i] + sense * t / (per_layer[i] > 0.0 ? per_layer[i] : 1.0);
            const bool stops = t > hit[i] && (end[i] - stop) * sense > 0.0;
            end[i] = stops ? stop : end[i];
        }
    }
}

inline void traceRow(const RowTraceSetup& setup, const SurfaceRow& points, RayRow& row) {
    const std::size_t count = points.px.size();
    row.resize(count);
    __builtin_memcpy(row.x.data(), points.px.data(), count * sizeof(double));
    __builtin_memcpy(row.y.data(), points.py.data(), count * sizeof(double));
    __builtin_memcpy(row.z.data(), points.pz.data(), count * sizeof(double));
    traceInterface(setup, count, points.nx.data(), points.ny.data(), points.nz.data(), row.dx.data(), row.dy.data(),
                   row.dz.data(), row.fraction.data(), row.untraced.data());
    placeInGrid(setup, count, row);
    endOnPlanes(setup, count, row);
}

}  // namespace photic::PHOTIC_ISA
