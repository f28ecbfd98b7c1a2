// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

namespace photic {

/// A convex part of space: a box with sides along the axes, cut by some half-spaces. World coordinates [m].
struct ConvexRegion {
    /// The points p with dot(normal, p) <= offset.
    struct HalfSpace {
        glm::dvec3 normal{0};
        double offset = 0;
    };
    static constexpr std::size_t kMostSides = 8;

    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
    std::array<HalfSpace, kMostSides> sides;
    std::size_t side_count = 0;

    void include(const glm::dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
    /// Adds the half-space with this outward normal that just holds all of `points`; nothing for a normal of length 0.
    void addSide(const glm::dvec3& normal, std::span<const glm::dvec3> points) {
        const double length = glm::length(normal);
        if (!(length > 0) || side_count == kMostSides) return;
        HalfSpace side{normal / length, -std::numeric_limits<double>::infinity()};
        for (const glm::dvec3& p : points) side.offset = glm::max(side.offset, glm::dot(side.normal, p));
        sides[side_count++] = side;
    }
    void addSide(const HalfSpace& side) {
        if (side_count < kMostSides) sides[side_count++] = side;
    }
};

/// Area [m2] of a triangle's part inside the region, as seen along `direction` (unit). 0 when it stays outside.
/// A triangle that only touches the region counts as outside.
double areaInside(const ConvexRegion& region, const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& direction,
                  bool& touches);

}  // namespace photic
