// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "bake/paths/emission.h"
#include "bake/paths/light_end.h"
#include "bake/paths/optical_scene.h"
#include "bake/paths/ray_casting.h"
#include "bake/paths/triangle_tree.h"

namespace photic {

/// Whether an object stands between a light and a place in the world.
bool standsBefore(const RayCaster& caster, const LightSample& sample, const glm::dvec3& place);

/// What ends fronts: the receivers and blockers of a scene and its surfaces, and which blocks of voxels they are in, so
/// that bent rays are held against them only there.
class FrontObstacles {
public:
    /// @param low, high  voxels that fronts cross, inclusive
    /// @param optics     of a scene with surfaces; must outlive the object
    FrontObstacles(const Scene& scene, const GridFrame& frame, const glm::ivec3& low, const glm::ivec3& high,
                   const OpticalScene* optics = nullptr);

    bool empty() const { return caster_.empty() && !optics_; }
    const RayCaster& caster() const { return caster_; }

    /// Where a ray starts, and on which surface; -1: on none.
    struct Start {
        glm::dvec3 voxel{0};
        int surface = -1;
    };
    struct Hit {
        double at = 0;         ///< share of the way, 0..1
        double deposit = 0;    ///< where the deposit ends, as a share of the way; more than 1 behind receivers
        glm::dvec3 normal{0};  ///< of the face, unit, in index space
        bool beside = false;   ///< the voxels that fronts cross: light has escaped
        Target target;
        Meeting meeting;     ///< of a surface
        MediumStack inside;  ///< where it is met
    };
    /// What a ray meets first on a straight way, in index space: on a short one, of a bent ray.
    /// @param start  of the ray, by which nothing is met that it leaves
    std::optional<Hit> onWay(const glm::dvec3& from, const glm::dvec3& to, const Start& start,
                             const MediumStack& inside) const;
    /// The same all along a straight ray; surfaces that part nothing are passed.
    /// @param to  where it leaves the voxels that fronts cross
    std::optional<Hit> straightOn(const Start& start, const glm::dvec3& to, const MediumStack& inside) const;
    /// Where a straight ray leaves the voxels that fronts cross; where it starts, if it is beside them.
    glm::dvec3 exitOf(const glm::dvec3& voxel, const glm::dvec3& direction) const;

    /// Whether a part of any mesh stands between three rays that are a fifth of a voxel apart or more.
    /// @param rays     of each, three places along it, in index space
    /// @param surface  that they start on, and that is not looked for; -1: none
    /// @param anywhere  along straight rays, and not only near their places
    bool standsBetween(const std::array<std::array<glm::dvec3, 3>, 3>& rays, int surface, bool anywhere) const;

private:
    static constexpr int kCells = 8;  // voxels a side of a block
    std::size_t blockOf(const glm::dvec3& voxel) const;
    void findBlocks(const Scene& scene);
    RayHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double most, Meeting& meeting) const;
    Hit describe(const glm::dvec3& start, const glm::dvec3& direction, const RayHit& hit, double length) const;

    GridFrame frame_;
    glm::ivec3 low_, high_, blocks_;
    const OpticalScene* optics_;
    RayCaster caster_;
    LightEnd light_end_;
    TriangleTree tree_;
    std::vector<std::uint8_t> near_;  // per block: something is in it, or in one beside it
};

}  // namespace photic
