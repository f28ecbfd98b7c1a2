// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "bake/field/grid_frame.h"
#include "bake/tubes/ray_casting.h"

namespace photic {

/// Layers of voxels beyond the one in which a receiver or blocker is hit that light goes on to fill. Without them a
/// trilinear look-up on the receiver would mix in darkness from behind it: half of the light is lost there.
inline constexpr double kOvershootVoxels = 2;

/// No track goes on further than this past a hit, in voxels along its own main axis: light that grazes a wall
/// would otherwise run behind it for ever.
inline constexpr double kMaxOvershootVoxels = 16;

/// Where deposits end in a grid. The power ledger counts what arrives at the hit itself; the deposit goes on.
class TrackEnd {
public:
    explicit TrackEnd(const GridFrame& frame)
        : frame_(frame), index_from_world_(glm::inverse(frame.world_from_index)) {}

    /// Distance [m] along the track at which its deposit ends.
    ///
    /// Layers are counted across the grid axis that is nearest to the face's normal, so that kOvershootVoxels whole
    /// layers behind the hit voxel are crossed by every track, whatever its slant.
    /// @param direction  unit, world
    /// @return infinity without a hit
    double operator()(const glm::dvec3& origin, const glm::dvec3& direction, const RayHit& hit) const {
        if (!hit) return std::numeric_limits<double>::infinity();
        const glm::dvec3 normal = glm::transpose(frame_.world_from_index) * hit.normal;
        const glm::dvec3 along = index_from_world_ * direction;
        const int axis = mainAxis(normal);
        const double longest = hit.distance + kMaxOvershootVoxels / std::fabs(along[mainAxis(along)]);
        if (along[axis] == 0) return longest;

        // The hit voxel is the one that the track comes from: a face on a voxel border must not fall to rounding.
        constexpr double kBorder = 1e-3;
        const double at = (index_from_world_ * (origin + hit.distance * direction - frame_.origin_world))[axis] + 0.5;
        // A hair short of the last layer's far side, which rounding must not push into the next.
        constexpr double kShort = 1e-9;
        const double end = along[axis] > 0 ? std::floor(at - kBorder) + 1 + kOvershootVoxels - kShort
                                           : std::floor(at + kBorder) - kOvershootVoxels + kShort;
        return std::min(longest, hit.distance + (end - at) / along[axis]);
    }

private:
    static int mainAxis(const glm::dvec3& v) {
        const glm::dvec3 a(std::fabs(v.x), std::fabs(v.y), std::fabs(v.z));
        return a.z >= a.x && a.z >= a.y ? 2 : a.y >= a.x ? 1 : 0;
    }

    GridFrame frame_;
    glm::dmat3 index_from_world_;
};

}  // namespace photic
