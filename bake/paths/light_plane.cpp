// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/light_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/optics/tangent_frame.h"

namespace photic {
namespace {

// Triangles for each voxel that the surface shows: with fewer they are launched themselves.
constexpr double kFine = 0.5;

}  // namespace

std::optional<LightPlane> lightPlane(const OpticalScene& optics, const Emission& emission) {
    const Surface& surface = emission.surface();
    if (!surface.mesh || surface.sphere || !surface.closed || !surface.smooth) return std::nullopt;
    const TriangleMesh& mesh = *surface.mesh;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    const glm::dvec3 middle = 0.5 * (low + high);
    const std::optional<glm::dvec3>& source = emission.sample().source;
    const double radius = 0.5 * glm::length(high - low);
    if (source && glm::length(middle - *source) < 1.5 * radius) return std::nullopt;

    const glm::dvec3 direction = emission.directionAt(middle);
    const TangentFrame axes(direction);
    LightPlane plane{middle, axes.across, axes.up, {}, {}};
    glm::dvec2 least(std::numeric_limits<double>::infinity()), most(-least);
    for (const glm::dvec3& p : mesh.positions) {
        glm::dvec3 at = p;
        if (source) at = *source + glm::length(middle - *source) / glm::dot(p - *source, direction) * (p - *source);
        const glm::dvec2 place(glm::dot(at - middle, axes.across), glm::dot(at - middle, axes.up));
        least = glm::min(least, place), most = glm::max(most, place);
    }
    const double voxel = std::cbrt(optics.frame().voxelVolume());
    // A hair more: light that just passes the surface ends its outline.
    plane.min = least - 1e-6 * radius, plane.max = most + 1e-6 * radius;
    const glm::dvec2 size = plane.max - plane.min;
    if (static_cast<double>(mesh.triangles.size()) < kFine * size.x * size.y / (voxel * voxel)) return std::nullopt;
    return plane;
}

}  // namespace photic
