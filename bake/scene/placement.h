// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/scene/table_reader.h"
#include "bake/scene/triangle_mesh.h"

namespace photic {

/// Where a scene puts a shape: world = position + rotation (scale * p), p in the shape's own axes, Z up.
struct Placement {
    glm::dvec3 position{0};  ///< [m]
    glm::dmat3 rotation{1};  ///< about x first, then y, then z, as Blender's default
    glm::dvec3 scale{1};     ///< along the shape's own axes; negative ones mirror, and the sides stay what they are
    bool moves() const { return position != glm::dvec3(0) || rotation != glm::dmat3(1) || scale != glm::dvec3(1); }
};

/// The keys `position`, `rotation` and `scale`.
const std::vector<std::string>& placementKeys();
/// @throws Error{Input} for a scale of 0
Placement loadPlacement(const TableReader& table);
/// Moves positions and normals; the outside of a closed mesh stays its outside.
void place(TriangleMesh& mesh, const Placement& placement);

}  // namespace photic
