// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "bake/paths/path.h"
#include "bake/scene/scene.h"

namespace photic {

/// A ray on its way to the first surface, at the point where it meets it.
struct EmittedRay {
    glm::dvec3 position{0};   ///< on the surface [m]
    glm::dvec3 direction{0};  ///< unit, of travel
    glm::dvec3 normal{0};     ///< unit, smooth; on the side of ior_above
    glm::dvec3 face{0};       ///< unit, geometric
};

/// One light (or one direction of its disc) as it enters through one specular surface. The domain is the surface's own:
/// the parameter plane of a height field, the triangles of a mesh.
class Emission {
public:
    /// @param surface     in Scene::surfaces
    /// @param irradiance  across the beam, per channel [W/m2], of this part of the light
    /// @param direction   unit, of travel
    Emission(const Scene& scene, int surface, const glm::dvec3& irradiance, const glm::dvec3& direction)
        : surface_(scene.surfaces[static_cast<std::size_t>(surface)]),
          index_(surface),
          irradiance_(irradiance),
          direction_(direction) {}

    const Surface& surface() const { return surface_; }
    int surfaceIndex() const { return index_; }
    const glm::dvec3& direction() const { return direction_; }
    const glm::dvec3& irradiance() const { return irradiance_; }

    /// @param face  geometric normal, unit, of the mesh triangle; unused for height fields
    EmittedRay at(const EmissionParam& param, const glm::dvec3& face) const {
        if (surface_.height_field) {
            const SurfacePoint point = surface_.height_field->at({param.position.x, param.position.y});
            const glm::dvec3 normal = glm::normalize(point.normal);
            return {point.position, direction_, normal, normal};
        }
        const double length = glm::length(param.normal);
        const bool usable = length > 0 && glm::dot(param.normal, face) > 0;
        return {param.position, direction_, usable ? param.normal / length : face, face};
    }

    /// Power per channel [W] through the triangle between three points of the surface, in the surface's orientation:
    /// height fields take light from above, meshes from either side.
    glm::dvec3 power(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
        return irradiance_ * across(0.5 * glm::cross(b - a, c - a));
    }

    /// Cross-section of the beam [m2] through an oriented area.
    double across(const glm::dvec3& area) const {
        const double facing = -glm::dot(area, direction_);
        return surface_.mesh ? std::fabs(facing) : std::fmax(0.0, facing);
    }

private:
    const Surface& surface_;
    int index_;
    glm::dvec3 irradiance_, direction_;
};

}  // namespace photic
