// SPDX-License-Identifier: Apache-2.0
// Compiled for wide vectors (CMakeLists.txt): what costs as much as the feet themselves when it goes point by point.
#include "bake/methods/eikonal_shade.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/optics/snell.h"
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
    for (int i = 0; i < count; ++i) {
        const double over = 1 / distance[i];
        const double x = (r.x0 + i * r.step - foot_x[i]) * over, y = (r.y - foot_y[i]) * over,
                     z = (r.z - foot_z[i]) * over;
        double dx = c.direction.x, dy = c.direction.y, dz = c.direction.z, part = 1;
        if (c.point) {
            dx = foot_x[i] - c.source.x, dy = foot_y[i] - c.source.y, dz = foot_z[i] - c.source.z;
            const double squared = dx * dx + dy * dy + dz * dz, inverse = 1 / std::sqrt(squared);
            dx *= inverse, dy *= inverse, dz *= inverse, part = c.squared / squared;
        }
        const double inverse = 1 / std::sqrt(1 + slope_x[i] * slope_x[i] + slope_y[i] * slope_y[i]);
        const double cos_i = (dx * slope_x[i] + dy * slope_y[i] - dz) * inverse;
        const double cos_t = (x * slope_x[i] + y * slope_y[i] - z) * inverse;
        const double enters = c.infinite ? cos_i : fresnelTransmittance(cos_i, cos_t, c.above, c.below) * cos_i / cos_t;
        const double least = 0.5 * r.step * over, bound = least < 0.2 ? least : 0.2;
        const double value = part * enters / (spread[i] > bound ? spread[i] : bound);
        const double lit = cos_i > 0 && cos_t > 0 ? value : 0.0;
        share[i] = arrival[i] < FootPointLayer::kAboveSurface ? static_cast<float>(r.lit ? lit : 1.0) : -1.0f;
        wx[i] = static_cast<float>(x), wy[i] = static_cast<float>(y), wz[i] = static_cast<float>(z);
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
