// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <memory>

#include "bake/scene/scene.h"

namespace photic {

struct RayHit {
    double distance = std::numeric_limits<double>::infinity();  ///< [m] along the unit direction
    int object = -1;                                            ///< index in Scene::objects (or surfaces); -1: nothing
    glm::dvec3 normal{0};                                       ///< world, unit, of the flat face, against the ray
    explicit operator bool() const { return object >= 0; }
};

/// What a RayCaster knows of the scene.
enum class CastAgainst {
    BlockingObjects,  ///< receivers and blockers, never movables; RayHit::object indexes Scene::objects
    MeshSurfaces      ///< specular meshes (height fields are left out); RayHit::object indexes Scene::surfaces
};

/// First hit of a ray with the scene's blocking objects (receivers and blockers, never movables).
/// Meshes go through Embree, planes are intersected in double; both block from either side. Thread-safe.
///
/// Embree works in single precision on coordinates about the meshes' centre in units of their size, so neither a far
/// origin nor a large or tiny mesh loses digits; the distance is then found again in double on the face that was hit.
class RayCaster {
public:
    /// @throws Error{Failed} when Embree cannot hold the meshes; Error{Input} for a mesh with a position that is not
    /// finite
    explicit RayCaster(const Scene& scene, CastAgainst what = CastAgainst::BlockingObjects);
    ~RayCaster();
    RayCaster(RayCaster&&) noexcept;

    /// Nothing blocks at all.
    bool empty() const;
    /// Only planes block: shadows have no silhouettes inside a convex set of planes.
    bool planesOnly() const;

    /// Hits closer than some 4e-6 of the meshes' size (planes: 1e-12 of the distance to the world's origin) are taken
    /// for the face that the ray starts on, and ignored.
    ///
    /// @param origin        world [m]
    /// @param direction     unit
    /// @param max_distance  [m]; hits at or beyond it are ignored
    RayHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction,
                    double max_distance = std::numeric_limits<double>::infinity()) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic
