// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/grid_frame.h"
#include "bake/paths/ray_casting.h"

namespace photic {

/// Layers of voxels beyond the one in which a receiver is hit that light goes on to fill. Without them a trilinear
/// look-up on the receiver would mix in darkness from behind it: half of the light is lost there.
inline constexpr double kOvershootVoxels = 2;

/// No leg goes on further than this past a hit, in voxels along its own main axis: light that grazes a wall would
/// otherwise run behind it for ever.
inline constexpr double kMaxOvershootVoxels = 16;

/// Through a part of the receiver that is thinner than this along the leg [voxels], light goes on as far as this: a
/// sheet is looked up as well as a solid. What is thicker ends the light where the leg leaves it, so that nothing
/// shines through the flank of a ball.
inline constexpr double kThinVoxels = 2;

/// Where deposits end in a grid. The power ledger counts what arrives at the hit itself; the deposit goes on behind
/// receivers, which are looked up, and stops at blockers.
class LightEnd {
public:
    /// @param caster, scene  must outlive the object
    /// @param behind_walls   [voxels] that light goes on further behind planes that stand: as far as a blur of layers
    ///                       reaches, which would mix the darkness there into the light before them
    LightEnd(const Scene& scene, const GridFrame& frame, const RayCaster& caster, double behind_walls = 0)
        : scene_(scene), frame_(frame), caster_(caster), behind_walls_(behind_walls) {}

    /// How far light goes on behind a plane, counted across the grid's axis nearest to its normal [voxels].
    double behindPlane(int axis) const { return kOvershootVoxels + (axis == 2 ? 0 : behind_walls_); }
    /// The same along a leg, at most. A blur takes up what steep light lays behind a wall over any number of layers.
    double longestBehindPlane(int axis) const {
        constexpr double kAnyLayers = 1e6;
        return axis != 2 && behind_walls_ > 0 ? kAnyLayers : kMaxOvershootVoxels;
    }

    /// Distance [m] along a leg at which its deposit ends.
    ///
    /// Layers are counted across the grid axis that is nearest to the face's normal, so that kOvershootVoxels whole
    /// layers behind the hit voxel are crossed by every leg, whatever its slant. Bodies that touch or overlap are one
    /// solid: in the corner where a wall stands on a floor light goes on inside of both. Where a leg comes out of the
    /// solid it ends, but for the far side of a thin sheet; never through a second object beyond. Behind a plane all
    /// is solid but for what blocks, which ends it.
    /// @param direction  unit, world
    /// @return infinity without a hit
    double distance(const glm::dvec3& origin, const glm::dvec3& direction, const RayHit& hit) const;

private:
    /// How far [m] a leg goes on from a point of the target where it was hit, at most `end`.
    double throughSolids(const glm::dvec3& point, const glm::dvec3& direction, const Target& first, double end) const;
    /// Whether closed bodies enclose a point, or a plane parts it from one that is known to lie outside of all.
    bool insideSolid(const glm::dvec3& point, const glm::dvec3& direction, const glm::dvec3& outside) const;

    const Scene& scene_;
    GridFrame frame_;
    const RayCaster& caster_;
    double behind_walls_ = 0;
};

}  // namespace photic
