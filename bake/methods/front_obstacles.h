// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "bake/paths/emission.h"
#include "bake/paths/light_end.h"
#include "bake/paths/ray_casting.h"
#include "bake/paths/triangle_tree.h"

namespace photic {

/// Whether an object stands between a light and a place in the world.
bool standsBefore(const RayCaster& caster, const LightSample& sample, const glm::dvec3& place);

/// What ends fronts: the receivers and blockers of a scene, and which blocks of voxels they are in, so that rays are
/// held against them only there.
class FrontObstacles {
public:
    /// @param low, high  voxels that fronts cross, inclusive
    FrontObstacles(const Scene& scene, const GridFrame& frame, const glm::ivec3& low, const glm::ivec3& high);

    bool empty() const { return caster_.empty(); }
    const RayCaster& caster() const { return caster_; }

    struct Hit {
        double at = 0;         ///< share of the way, 0..1
        double deposit = 0;    ///< where the deposit ends, as a share of the way; more than 1 behind receivers
        glm::dvec3 normal{0};  ///< of the face, unit, in index space
        bool beside = false;   ///< the voxels that fronts cross: light has escaped
        Target target;
    };
    /// What a ray meets first on a straight way, in index space.
    std::optional<Hit> onWay(const glm::dvec3& from, const glm::dvec3& to) const;

    /// Whether a part of any mesh stands between three rays that are a fifth of a voxel apart or more.
    /// @param rays  of each, three places along it, in index space
    bool standsBetween(const std::array<std::array<glm::dvec3, 3>, 3>& rays) const;

private:
    static constexpr int kCells = 8;  // voxels a side of a block
    std::size_t blockOf(const glm::dvec3& voxel) const;
    void findBlocks(const Scene& scene);

    GridFrame frame_;
    glm::ivec3 low_, high_, blocks_;
    RayCaster caster_;
    LightEnd light_end_;
    TriangleTree tree_;
    std::vector<std::uint8_t> near_;  // per block: something is in it, or in one beside it
};

}  // namespace photic
