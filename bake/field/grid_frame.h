// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

namespace photic {

/// An affine voxel grid: voxel (i,j,k) is centred at world = linear * (i,j,k) + origin.
/// Index bounds are inclusive; the box that is covered reaches half a voxel further.
struct GridFrame {
    glm::dmat3 world_from_index{1.0};  ///< linear part [m per voxel]; may be sheared
    glm::dvec3 origin_world{0};        ///< centre of voxel (0,0,0)
    glm::ivec3 min{0}, max{-1};

    glm::dvec3 worldFromIndex(const glm::dvec3& p) const { return world_from_index * p + origin_world; }
    glm::dvec3 indexFromWorld(const glm::dvec3& p) const { return glm::inverse(world_from_index) * (p - origin_world); }
    glm::ivec3 size() const { return max - min + 1; }
    std::int64_t voxelCount() const {
        const auto s = size();
        return std::int64_t(s.x) * s.y * s.z;
    }
    /// Volume of a voxel [m3].
    double voxelVolume() const { return std::fabs(glm::determinant(world_from_index)); }
    bool axisAligned() const {
        const auto& m = world_from_index;
        return m[0][1] == 0 && m[0][2] == 0 && m[1][0] == 0 && m[1][2] == 0 && m[2][0] == 0 && m[2][1] == 0;
    }
};

}  // namespace photic
