// SPDX-License-Identifier: Apache-2.0
// Compiled for wide vectors (CMakeLists.txt): what costs as much as the feet themselves when it goes point by point.
#include "bake/methods/eikonal_shade.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/scene/vector_clones.h"

namespace photic {
namespace {

/// Light that arrives at the surface.
struct Coming {
    glm::dvec3 direction{0}, source{0};
    bool point = false;
    double squared = 1;  ///< of the distance at which a point's share is 1
    double above = 1, below = 1;
    bool infinite = false;
};

PHOTIC_VECTOR_CLONES
void shade(const Coming& coming, const ShadeRow& row, int count, const double* __restrict foot_x,
           const double* __restrict foot_y, const double* __restrict foot_z, const double* __restrict slope_x,
           const double* __restrict slope_y, const double* __restrict distance, const double* __restrict spread,
           const double* __restrict arrival, float* __restrict share, float* __restrict wx, float* __restrict wy,
           float* __restrict wz) {
    const Coming c = coming;
    const ShadeRow r = row;
    // Places are subtracted in double precision; what follows is right to 1e-6 in single, which is what is stored.
    const auto n1 = static_cast<float>(c.above), n2 = static_cast<float>(c.below);
    const auto half_step = static_cast<float>(0.5 * r.step), reference = static_cast<float>(c.squared);
    for (int i = 0; i < count; ++i) {
        const float over = 1.0f / static_cast<float>(distance[i]);
        const float x = static_cast<float>(r.x0 + i * r.step - foot_x[i]) * over,
                    y = static_cast<float>(r.y - foot_y[i]) * over, z = static_cast<float>(r.z - foot_z[i]) * over;
        auto dx = static_cast<float>(c.direction.x), dy = static_cast<float>(c.direction.y),
             dz = static_cast<float>(c.direction.z);
        float part = 1;
        if (c.point) {
            dx = static_cast<float>(foot_x[i] - c.source.x), dy = static_cast<float>(foot_y[i] - c.source.y);
            dz = static_cast<float>(foot_z[i] - c.source.z);
            const float squared = dx * dx + dy * dy + dz * dz, inverse = 1.0f / std::sqrt(squared);
            dx *= inverse, dy *= inverse, dz *= inverse, part = reference / squared;
        }
        const auto hx = static_cast<float>(slope_x[i]), hy = static_cast<float>(slope_y[i]);
        const float inverse = 1.0f / std::sqrt(1 + hx * hx + hy * hy);
        const float cos_i = (dx * hx + dy * hy - dz) * inverse, cos_t = (x * hx + y * hy - z) * inverse;
        // Fresnel's transmittance (bake/optics/snell.h), its two divisions as one.
        const float ii = n1 * cos_i, tt = n2 * cos_t, it = n2 * cos_i, ti = n1 * cos_t;
        const float s_sum = ii + tt, p_sum = it + ti, both = 1.0f / (s_sum * p_sum);
        const float r_s = (ii - tt) * p_sum * both, r_p = (it - ti) * s_sum * both;
        const float least = half_step * over, bound = least < 0.2f ? least : 0.2f;
        const auto spreads = static_cast<float>(spread[i]);
        const float spread_here = spreads > bound ? spreads : bound;
        const float enters =
            c.infinite ? cos_i / spread_here : (1 - 0.5f * (r_s * r_s + r_p * r_p)) * cos_i / (cos_t * spread_here);
        const float lit = cos_i > 0 && cos_t > 0 ? part * enters : 0.0f;
        share[i] = arrival[i] < FootPointLayer::kAboveSurface ? (r.lit ? lit : 1.0f) : -1.0f;
        wx[i] = x, wy[i] = y, wz[i] = z;
    }
}

void copyRow(const std::vector<double>& from, std::size_t first, int count, float* to) {
    if (!to) return;
    for (int i = 0; i < count; ++i) to[i] = static_cast<float>(from[first + static_cast<std::size_t>(i)]);
}

}  // namespace

void shadeRow(const EikonalFront& front, const FootPointLayer& layer, std::size_t first, int count, const ShadeRow& row,
              const ShadedRow& out) {
    const Light& light = front.light();
    Coming coming;
    coming.direction = light.direction, coming.infinite = front.infiniteIndex();
    coming.above = front.surface().ior_above, coming.below = front.slowness();
    if (light.position) {
        const glm::dvec3 way = front.surface().center - *light.position;
        coming.point = true, coming.source = *light.position, coming.squared = glm::dot(way, way);
    }
    shade(coming, row, count, &layer.foot_x[first], &layer.foot_y[first], &layer.foot_z[first], &layer.slope_x[first],
          &layer.slope_y[first], &layer.distance[first], &layer.spread[first], &layer.arrival[first], out.share, out.wx,
          out.wy, out.wz);
    copyRow(layer.curvature, first, count, out.curvature);
    copyRow(layer.arrival, first, count, out.arrival);
    copyRow(layer.distance, first, count, out.distance);
}

}  // namespace photic
