// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>

#include "bake/scene/scene.h"

namespace photic {

/// Something that a ray can meet: an object, which stops light, or a specular surface, which sends it on.
struct Target {
    enum class Kind : std::uint8_t { Nothing, Object, Surface };
    Kind kind = Kind::Nothing;
    int index = -1;  ///< in Scene::objects or Scene::surfaces
    bool operator==(const Target&) const = default;
};

/// How far from a sphere's surface [m], along a ray, another meeting with it is rounding: a ray that starts on the
/// surface and grazes it leaves it again within the square root of what its place is rounded by.
double roundingOnSphere(const Sphere& sphere);

/// Planes have no end: of the sun's light they may be asked about by the sun's middle (standsBefore).
enum class EndlessPlanes { Met, LeftOut };

struct RayHit {
    double distance = std::numeric_limits<double>::infinity();  ///< [m] along the unit direction
    Target target;
    std::uint32_t triangle = 0;  ///< of the target's mesh; 0 for a plane
    glm::dvec2 barycentric{0};   ///< weights of the triangle's second and third corner
    glm::dvec3 normal{0};        ///< world, unit, of the flat face, against the ray
    explicit operator bool() const { return target.kind != Target::Kind::Nothing; }
};

/// First hit of a ray with everything that stands in the scene: receivers and blockers (movables never), and specular
/// meshes. Meshes go through Embree, planes and spheres are intersected in double; all are met from either side. Height
/// fields are left out. Thread-safe.
///
/// Embree works in single precision on coordinates about the meshes' centre in units of their size, so neither a far
/// origin nor a large or tiny mesh loses digits; the distance is then found again in double on the face that was hit.
class RayCaster {
public:
    /// @throws Error{Failed} when Embree cannot hold the meshes; Error{Input} for a mesh with a position that is not
    /// finite
    explicit RayCaster(const Scene& scene);
    ~RayCaster();
    RayCaster(RayCaster&&) noexcept;

    /// Nothing stands in the scene at all.
    bool empty() const;
    /// Only planes do: shadows have no silhouettes inside a convex set of planes.
    bool planesOnly() const;
    bool hasPlanes() const;

    /// Hits closer than some 4e-6 of the meshes' size (planes: 1e-12 of the distance to the world's origin) are taken
    /// for the face that the ray starts on, and ignored. A ray that is not finite hits nothing.
    ///
    /// @param origin        world [m]
    /// @param direction     unit
    /// @param max_distance  [m]; hits at or beyond it are ignored
    RayHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction,
                    double max_distance = std::numeric_limits<double>::infinity(),
                    EndlessPlanes planes = EndlessPlanes::Met) const;

    /// Whether a point lies inside of an object's mesh: rays from there along `direction` and against it meet odd
    /// numbers of its faces (an open sheet has one of them at most). Faces that several meshes share are each met.
    bool insideBody(const glm::dvec3& point, const glm::dvec3& direction) const;

    /// Whether a plane stands between a point and a sun. A plane along the sun's own rays, to rounding, does not.
    /// @param travel  unit, of the light
    bool planeStandsBefore(const glm::dvec3& point, const glm::dvec3& travel) const;
    /// Whether a plane stands within `radius` [radians] of the way that light goes, and so parts a disc that wide.
    bool planeParts(const glm::dvec3& travel, double radius) const;

    /// A distance [m] from a point within which all meshes and spheres lie; 0 without any.
    double reachFrom(const glm::dvec3& point) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic
