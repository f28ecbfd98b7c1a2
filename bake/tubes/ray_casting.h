// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <memory>

#include "bake/scene/scene.h"

namespace photic {

struct RayHit {
    double distance = std::numeric_limits<double>::infinity();  ///< [m] along the unit direction
    int object = -1;                                            ///< index in Scene::objects; -1: nothing
    explicit operator bool() const { return object >= 0; }
};

/// First hit of a ray with the scene's blocking objects (receivers and blockers, never movables).
/// Meshes go through Embree, planes are intersected in double. Thread-safe.
class RayCaster {
public:
    explicit RayCaster(const Scene& scene);
    ~RayCaster();
    RayCaster(RayCaster&&) noexcept;

    /// Nothing blocks at all.
    bool empty() const;
    /// Only planes block: shadows have no silhouettes inside a convex set of planes.
    bool planesOnly() const;

    /// @param direction     unit
    /// @param max_distance  [m]; hits at or beyond it are ignored
    RayHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction,
                    double max_distance = std::numeric_limits<double>::infinity()) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic
