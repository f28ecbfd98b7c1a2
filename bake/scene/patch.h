// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <limits>

#include "bake/scene/height_field.h"

namespace photic {

/// The rectangle of the parameter plane on which a height field is given; beyond it lies a plane at `outside_z`.
struct Patch {
    glm::dvec2 min{-std::numeric_limits<double>::infinity()};
    glm::dvec2 max{std::numeric_limits<double>::infinity()};
    double outside_z = 0;  ///< [m]

    static Patch unbounded() { return {}; }
    /// Points that rounding has put beyond the edge belong to the patch: it is widened by 1e-9 of its size.
    static Patch around(glm::dvec2 center, glm::dvec2 size, double outside_z) {
        const glm::dvec2 half = size * (0.5 + 1e-9);
        return {center - half, center + half, outside_z};
    }

    bool bounded() const { return max.x < std::numeric_limits<double>::infinity(); }
    bool containsX(double u) const { return u >= min.x && u <= max.x; }
    bool containsY(double v) const { return v >= min.y && v <= max.y; }
    bool contains(glm::dvec2 uv) const { return containsX(uv.x) && containsY(uv.y); }
    SurfacePoint beyond(glm::dvec2 uv) const { return {{uv.x, uv.y, outside_z}, {0, 0, 1}}; }
};

/// Half-open range of the indices i of a row whose u = start.x + i * step lies in the patch. step > 0.
struct RowRange {
    std::size_t first = 0, last = 0;
};
RowRange rowInside(const Patch& patch, glm::dvec2 start, double step, std::size_t count);

/// Fills what a row has outside `range` with the patch's surroundings; `out` has its size.
void fillBeyond(const Patch& patch, glm::dvec2 start, double step, RowRange range, SurfaceRow& out);

}  // namespace photic
