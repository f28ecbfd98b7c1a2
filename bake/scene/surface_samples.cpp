// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/scene/scattered_points.h"

namespace photic {
namespace {

struct Footprint {
    glm::dvec2 min{0}, max{0};
    bool empty() const { return !(min.x < max.x && min.y < max.y); }
};

Footprint footprintOf(const Surface& surface, const Domain& domain) {
    Footprint footprint{glm::dvec2(domain.min), glm::dvec2(domain.max)};
    if (surface.outside == Outside::Periodic) return footprint;
    const glm::dvec2 center(surface.center), half = 0.5 * surface.size;
    footprint.min = glm::max(footprint.min, center - half), footprint.max = glm::min(footprint.max, center + half);
    return footprint;
}

}  // namespace

std::vector<glm::dvec2> placesOn(const Surface& surface, const Domain& domain, int count) {
    const Footprint footprint = footprintOf(surface, domain);
    std::vector<glm::dvec2> places;
    if (footprint.empty()) return places;
    for (int i = 0; i < count; ++i)
        places.push_back(footprint.min + (footprint.max - footprint.min) * scatteredPoint(i));
    return places;
}

std::vector<SurfaceSample> samplesOf(const Surface& surface, const Domain& domain, int count) {
    std::vector<SurfaceSample> samples;
    if (surface.height_field) {
        const std::vector<glm::dvec2> places = placesOn(surface, domain, count);
        const Footprint footprint = footprintOf(surface, domain);
        const double share = (footprint.max.x - footprint.min.x) * (footprint.max.y - footprint.min.y) /
                             static_cast<double>(places.size());
        for (const glm::dvec2& uv : places) {
            const SurfacePoint point = surface.height_field->at(uv);
            const double stretch = glm::length(point.normal);
            if (stretch > 0) samples.push_back({point.position, point.normal / stretch, share * stretch});
        }
        return samples;
    }
    // Triangles in their order, a sample at every equal step of the area.
    const TriangleMesh& mesh = *surface.mesh;
    const auto areaVector = [&](const std::array<std::uint32_t, 3>& t) {
        return 0.5 *
               glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    };
    double area = 0;
    for (const auto& t : mesh.triangles) area += glm::length(areaVector(t));
    double passed = 0;
    int next = 0;
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 a = areaVector(t);
        const double size = glm::length(a);
        for (passed += size; next < count && passed >= (next + 0.5) * area / count; ++next) {
            glm::dvec2 b = scatteredPoint(next);
            if (b.x + b.y > 1) b = glm::dvec2(1) - b;
            const glm::dvec3 p =
                (1 - b.x - b.y) * mesh.positions[t[0]] + b.x * mesh.positions[t[1]] + b.y * mesh.positions[t[2]];
            samples.push_back({p, a / size, area / count});
        }
    }
    return samples;
}

}  // namespace photic
