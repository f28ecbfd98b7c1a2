// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/height_field_hit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace photic {
namespace {

// The point of the surface above or below (x, y).
SurfacePoint pointAt(const HeightField& field, const glm::dvec2& place) {
    glm::dvec2 uv = place;
    SurfacePoint point = field.at(uv);
    if (field.maxDisplacement() <= 0) return point;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec2 off = place - glm::dvec2(point.position);
        if (std::fabs(off.x) + std::fabs(off.y) < 1e-14) break;
        uv += off;
        point = field.at(uv);
    }
    return point;
}

}  // namespace

HeightFieldHit hitHeightField(const Surface& surface, const glm::dvec3& origin, const glm::dvec3& direction,
                              double start, double max_distance) {
    const HeightField& field = *surface.height_field;
    HeightFieldHit out;
    double from = start, to = max_distance;
    // The layer that the surface lies in, and the patch where nothing lies beyond.
    const auto clip = [&](double at, double slope, double low, double high) {
        if (slope == 0) {
            if (at < low || at > high) to = -1;
            return;
        }
        const double a = (low - at) / slope, b = (high - at) / slope;
        from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
    };
    const double thickness = field.maxZ() - field.minZ(),
                 margin = 1e-9 * (1 + std::fabs(field.maxZ())) + 1e-3 * thickness;
    clip(origin.z, direction.z, field.minZ() - margin, field.maxZ() + margin);
    if (surface.outside == Outside::None)
        for (int a = 0; a < 2; ++a)
            clip(origin[a], direction[a], surface.center[a] - 0.5 * surface.size[a],
                 surface.center[a] + 0.5 * surface.size[a]);
    if (!(from < to) || !std::isfinite(to)) return out;

    const auto above = [&](double t) {
        const glm::dvec3 p = origin + t * direction;
        return p.z - pointAt(field, {p.x, p.y}).position.z;
    };
    const double run = std::hypot(direction.x, direction.y);
    const double smooth = std::isfinite(field.featureSize()) ? 0.5 * field.featureSize() : to - from;
    double step = run > 0 ? smooth / run : to - from;
    step = std::clamp(step, (to - from) * 1e-5, to - from);
    double t0 = from, f0 = above(t0);
    while (t0 < to) {
        const double t1 = std::min(t0 + step, to), f1 = above(t1);
        if ((f0 > 0) != (f1 > 0)) {
            // The regula falsi, with a bisection where it would creep (Illinois).
            double a = t0, b = t1, fa = f0, fb = f1;
            for (int i = 0; i < 60 && b - a > 1e-13 * (1 + b); ++i) {
                const double t = i % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa), f = above(t);
                if (f == 0)
                    a = b = t;
                else if ((f > 0) == (fa > 0))
                    a = t, fa = f, fb *= 0.5;
                else
                    b = t, fb = f, fa *= 0.5;
            }
            out.distance = 0.5 * (a + b);
            const glm::dvec3 p = origin + out.distance * direction;
            const SurfacePoint point = pointAt(field, {p.x, p.y});
            out.position = p, out.normal = glm::normalize(point.normal);
            return out;
        }
        t0 = t1, f0 = f1;
    }
    return out;
}

bool standsBelow(const Light& light, const Surface& surface) {
    if (!light.position || !surface.height_field) return false;
    return std::isfinite(
        hitHeightField(surface, *light.position, {0, 0, 1}, 0, std::numeric_limits<double>::infinity()).distance);
}

}  // namespace photic
