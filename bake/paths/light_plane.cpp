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

// Of a cell, between its side and the outline: no fraction that halving a cell would reach.
constexpr double kShift = 0.37;

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
    const glm::dvec2 size = most - least;
    if (static_cast<double>(mesh.triangles.size()) < kFine * size.x * size.y / (voxel * voxel)) return std::nullopt;
    // Corners speak for the cells around them: where an outline is straight and lies along the lattice, as many of them
    // must fall inside it as it is wide, at any fineness. So cells divide its extent, and are shifted against it.
    const glm::dvec2 cells = glm::max(glm::ceil(size / voxel), glm::dvec2(1)), step = size / cells;
    plane.min = least - kShift * step, plane.max = most + (1 - kShift) * step;
    plane.cells = glm::ivec2(cells) + 1;
    return plane;
}

}  // namespace photic
