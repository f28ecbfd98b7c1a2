// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace photic {

/// An indexed triangle mesh in world space [m], Z up, split vertices welded.
struct TriangleMesh {
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;  ///< unit, one per position: the file's, or area-weighted from the faces
    std::vector<std::array<std::uint32_t, 3>> triangles;
    bool shaded_smooth = false;  ///< the file gives normals, and not those of its flat faces
    /// Of each triangle's corners, unit, where some edges are creases over which normals are not averaged; else empty.
    std::vector<std::array<glm::dvec3, 3>> corner_normals;
};

}  // namespace photic
