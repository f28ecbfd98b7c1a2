// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>

namespace photic {

/// A field that jumps to 0 at the rim of a body, made smooth: at each place its mean along the normal of the nearest
/// rim, weighted by a raised cosine. So a face has the same course across it wherever it lies in a grid, where means
/// over boxes have ripples that are aliases of the grid. All that is known of the body is whether places are in it; its
/// rim is found by halving.
/// Places are in nodes.
struct RimMean {
    std::function<bool(const glm::dvec3&)> inside;
    std::function<double(const glm::dvec3&)> value;  ///< asked for inside alone; 0 elsewhere
    double half_width = 3;                           ///< of the raised cosine, whose deviation is 0.36 of it

    /// @param towards  the inside, about: within half a right angle of the rim's normal
    /// @return nothing where the rim has an edge within two nodes, or more than a curvature of a quarter a node: a line
    /// does not stand for what is around it there
    std::optional<double> at(const glm::dvec3& place, const glm::dvec3& towards) const;
};

}  // namespace photic
