// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/tubes/ray_casting.h"
#include "bake/tubes/specular_event.h"
#include "bake/tubes/track_end.h"

namespace photic {

/// A place on a specular surface that tubes are subdivided between.
/// Height field: `position` is (u, v, 0) and `normal` unused. Mesh: a point of a flat triangle and the interpolated
/// normal, NOT normalised, so that the middle of two is the interpolation of their own triangle.
struct SurfaceParam {
    glm::dvec3 position{0}, normal{0};
};

enum class CornerFate : std::uint8_t {
    Lit,      ///< light goes on along `direction`
    Blocked,  ///< an object stands between the light and the surface; `direction` is where light would go
    Hidden,   ///< another part of a specular mesh stands before it, and has launched this light
    Dark      ///< the surface sends nothing this way (total reflection, a branch that would meet the surface again)
};

/// One traced corner ray of a tube.
struct Corner {
    SurfaceParam param;
    glm::dvec3 position{0};   ///< world
    glm::dvec3 direction{0};  ///< unit, world; 0 where the interface sends none
    double fraction = 0;      ///< of the arriving power that goes on along `direction`
    double untraced = 0;      ///< Fresnel branch that is left out (counted once a corner)
    double dropped = 0;       ///< branches that would meet the surface again
    CornerFate fate = CornerFate::Dark;
    int end_object =
        -1;  ///< what it hits: index in Scene::objects; kEndsOnSurface: a second specular surface; -1: nothing
    double hit_distance = 0;  ///< [m]; infinity when it hits nothing
    double end_distance = 0;  ///< where its deposit ends, overshoot included [m]

    static constexpr int kEndsOnSurface = -2;
};

/// Which of an interface's two branches is traced.
enum class Branch { Refracted, Reflected };

/// Traces corner rays of one surface, one direction of light and one branch. Thread-safe.
class CornerTracer {
public:
    /// @param objects, meshes  casters of the scene; must outlive the tracer
    CornerTracer(const Scene& scene, const Surface& surface, const glm::dvec3& light_direction, Branch branch,
                 const GridFrame& frame, const RayCaster& objects, const RayCaster& meshes);

    /// @param face  geometric normal, unit, of the mesh triangle; unused for height fields
    Corner trace(const SurfaceParam& param, const glm::dvec3& face) const;
    /// From a point of a height field that is known already.
    Corner traceAt(const SurfaceParam& param, const glm::dvec3& position, const glm::dvec3& normal,
                   const glm::dvec3& face) const;

    const Surface& surface() const { return surface_; }
    const glm::dvec3& lightDirection() const { return light_direction_; }
    Branch branch() const { return branch_; }
    /// The planes that block light, when nothing else in the scene casts a shadow; null otherwise.
    const std::vector<Plane>* planes() const {
        return meshes_.empty() && (objects_.empty() || objects_.planesOnly()) ? &planes_ : nullptr;
    }

private:
    const Surface& surface_;
    glm::dvec3 light_direction_;
    Branch branch_;
    const RayCaster& objects_;
    const RayCaster& meshes_;
    TrackEnd track_end_;
    std::vector<Plane> planes_;
};

inline SurfaceParam middle(const SurfaceParam& a, const SurfaceParam& b) {
    return {0.5 * (a.position + b.position), 0.5 * (a.normal + b.normal)};
}

}  // namespace photic
