// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace photic {

/// The axis along which a vector is longest; z where it is no shorter than the others, then y.
inline int mainAxis(const glm::dvec3& v) {
    const glm::dvec3 a(std::fabs(v.x), std::fabs(v.y), std::fabs(v.z));
    return a.z >= a.x && a.z >= a.y ? 2 : a.y >= a.x ? 1 : 0;
}

/// Voxels from min to max, both inside.
struct VoxelBox {
    glm::ivec3 min{0}, max{-1};
    glm::ivec3 size() const { return max - min + 1; }
    bool contains(const glm::ivec3& voxel) const {
        return voxel.x >= min.x && voxel.y >= min.y && voxel.z >= min.z && voxel.x <= max.x && voxel.y <= max.y &&
               voxel.z <= max.z;
    }
};

/// An affine voxel grid: voxel (i,j,k) is centred at world = linear * (i,j,k) + origin.
/// Index bounds are inclusive; the box that is covered reaches half a voxel further.
class GridFrame {
public:
    GridFrame() = default;
    /// @param world_from_index  linear part [m per voxel]; may be sheared
    /// @param origin            centre of voxel (0,0,0) [m]
    GridFrame(const glm::dmat3& world_from_index, const glm::dvec3& origin, const glm::ivec3& low = glm::ivec3(0),
              const glm::ivec3& high = glm::ivec3(-1))
        : origin_world(origin), min(low), max(high) {
        setWorldFromIndex(world_from_index);
    }

    glm::dvec3 origin_world{0};  ///< centre of voxel (0,0,0)
    glm::ivec3 min{0}, max{-1};

    /// The linear part [m per voxel], and its inverse [voxels per m].
    const glm::dmat3& worldFromIndex() const { return world_from_index_; }
    const glm::dmat3& indexFromWorld() const { return index_from_world_; }
    void setWorldFromIndex(const glm::dmat3& linear) {
        world_from_index_ = linear, index_from_world_ = glm::inverse(linear);
    }

    glm::dvec3 worldFromIndex(const glm::dvec3& p) const { return world_from_index_ * p + origin_world; }
    glm::dvec3 indexFromWorld(const glm::dvec3& p) const { return index_from_world_ * (p - origin_world); }
    /// Voxels that a ray crosses along each axis for each metre, from its unit direction in the world.
    glm::dvec3 indexDirection(const glm::dvec3& direction) const { return index_from_world_ * direction; }
    /// Normal of a plane in index space (not of unit length), from its normal in the world.
    glm::dvec3 indexNormal(const glm::dvec3& normal) const { return glm::transpose(world_from_index_) * normal; }

    /// Distance [m] at which a ray from inside or outside leaves the box for good; < 0 when that lies behind it.
    /// @param position   in index space
    /// @param direction  in index space, voxels a metre (indexDirection)
    double exitDistance(const glm::dvec3& position, const glm::dvec3& direction) const {
        double exit = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
            if (direction[a] == 0) continue;
            const double side = direction[a] > 0 ? max[a] + 0.5 : min[a] - 0.5;
            exit = std::min(exit, (side - position[a]) / direction[a]);
        }
        return exit;
    }

    /// Distance [m] at which a ray leaves the box along its main axis; < 0 when that lies behind it. One that passes
    /// beside the box goes on as far as its neighbours do that enter it.
    double passDistance(const glm::dvec3& position, const glm::dvec3& direction) const {
        const int a = mainAxis(direction);
        return ((direction[a] > 0 ? max[a] + 0.5 : min[a] - 0.5) - position[a]) / direction[a];
    }

    /// Part of a ray inside the box, from 0 on [in units of `direction`]; false when it misses.
    /// @param origin, direction  in the world
    bool clip(const glm::dvec3& origin, const glm::dvec3& direction, double& begin, double& end) const {
        begin = 0, end = std::numeric_limits<double>::infinity();
        const glm::dvec3 p = indexFromWorld(origin) + 0.5, d = indexDirection(direction);
        for (int a = 0; a < 3; ++a) {
            const double low = min[a], high = max[a] + 1;
            if (d[a] == 0) {
                if (p[a] < low || p[a] >= high) return false;
                continue;
            }
            const double inverse = 1.0 / d[a], t0 = (low - p[a]) * inverse, t1 = (high - p[a]) * inverse;
            begin = std::max(begin, std::min(t0, t1)), end = std::min(end, std::max(t0, t1));
        }
        return begin < end;
    }

    glm::ivec3 size() const { return max - min + 1; }
    std::int64_t voxelCount() const {
        const auto s = size();
        return std::int64_t(s.x) * s.y * s.z;
    }
    /// Volume of a voxel [m3].
    double voxelVolume() const { return std::fabs(glm::determinant(world_from_index_)); }
    bool axisAligned() const {
        const auto& m = world_from_index_;
        return m[0][1] == 0 && m[0][2] == 0 && m[1][0] == 0 && m[1][2] == 0 && m[2][0] == 0 && m[2][1] == 0;
    }

private:
    glm::dmat3 world_from_index_{1.0}, index_from_world_{1.0};
};

}  // namespace photic
