// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/convex_region.h"

#include <cmath>

namespace photic {
namespace {

// A triangle cut by fourteen planes has at most seventeen corners.
struct Polygon {
    std::array<glm::dvec3, 20> points;
    std::size_t count = 0;
};

// Keeps the part with dot(normal, p) <= offset (Sutherland and Hodgman 1974).
Polygon cut(const Polygon& in, const glm::dvec3& normal, double offset) {
    Polygon out;
    for (std::size_t i = 0; i < in.count; ++i) {
        const glm::dvec3 &a = in.points[i], &b = in.points[i + 1 == in.count ? 0 : i + 1];
        const double da = offset - glm::dot(normal, a), db = offset - glm::dot(normal, b);
        if (da >= 0) out.points[out.count++] = a;
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) out.points[out.count++] = a + (da / (da - db)) * (b - a);
    }
    return out;
}

}  // namespace

double areaInside(const ConvexRegion& region, const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& direction,
                  bool& touches) {
    touches = false;
    const glm::dvec3 low = glm::min(glm::min(triangle[0], triangle[1]), triangle[2]);
    const glm::dvec3 high = glm::max(glm::max(triangle[0], triangle[1]), triangle[2]);
    for (int a = 0; a < 3; ++a)
        if (!(low[a] <= region.high[a] && high[a] >= region.low[a])) return 0;
    Polygon p;
    p.points[0] = triangle[0], p.points[1] = triangle[1], p.points[2] = triangle[2], p.count = 3;
    for (std::size_t s = 0; s < region.side_count && p.count > 0; ++s)
        p = cut(p, region.sides[s].normal, region.sides[s].offset);
    for (int a = 0; a < 3 && p.count > 0; ++a) {
        glm::dvec3 axis(0);
        axis[a] = 1;
        if (high[a] > region.high[a]) p = cut(p, axis, region.high[a]);
        if (low[a] < region.low[a] && p.count > 0) p = cut(p, -axis, -region.low[a]);
    }
    if (p.count < 3) return 0;
    touches = true;
    glm::dvec3 area(0);
    for (std::size_t i = 1; i + 1 < p.count; ++i)
        area += 0.5 * glm::cross(p.points[i] - p.points[0], p.points[i + 1] - p.points[0]);
    return std::fabs(glm::dot(area, direction));
}

}  // namespace photic
