// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "bake/paths/height_field_hit.h"
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

/// A light as emissions take it: one direction of a sun, or one place.
struct LightSample {
    glm::dvec3 direction{0, 0, -1};    ///< unit, of travel: of a sun's rays; of a lamp its axis
    std::optional<glm::dvec3> source;  ///< [m]; none for a sun
    glm::dvec3 strength{0};            ///< sun: across the beam [W/m2]; lamp: on its axis [W/sr]; per channel
    const Light* light = nullptr;      ///< how a lamp's strength falls off
};

/// The samples that stand for a light: a sun's centre, or `disc_samples` directions of its disc; a lamp's place, or the
/// points of a rectangle (the R sequence, centred).
std::vector<LightSample> lightSamples(const Light& light, int disc_samples);

/// A part of a plane across a light's rays. Its parameters are (u, v, 0): the point centre + u across + v up.
struct LightPlane {
    glm::dvec3 centre{0}, across{1, 0, 0}, up{0, 1, 0};  ///< [m]; unit, at right angles
    glm::dvec2 min{0}, max{0};                           ///< of (u, v) [m]
    glm::ivec2 cells{1};                                 ///< that it is cut into to begin with, of a voxel at most
};

/// One sample of a light as it enters through one specular surface. The domain is the surface's own: the parameter
/// plane of a height field, the triangles of a mesh. A triangle that another hides is told by its paths
/// (PathOutcome::Hidden) and divided along the shadow's edge, so that flat facets stay the tubes that they are. Fine
/// meshes are launched across the light's own rays instead (LightPlane).
class Emission {
public:
    /// @param surface  in Scene::surfaces; scene must outlive the emission
    Emission(const Scene& scene, int surface, const LightSample& sample)
        : Emission(scene, surface, sample,
                   sample.source && standsBelow(*sample.light, scene.surfaces[static_cast<std::size_t>(surface)])) {}
    /// @param from_below  what standsBelow() says, for those who ask often
    Emission(const Scene& scene, int surface, const LightSample& sample, bool from_below)
        : surface_(scene.surfaces[static_cast<std::size_t>(surface)]),
          index_(surface),
          sample_(sample),
          from_below_(from_below) {}

    const Surface& surface() const { return surface_; }
    int surfaceIndex() const { return index_; }
    /// A sun, whose rays are parallel.
    bool parallel() const { return !sample_.source; }
    const LightSample& sample() const { return sample_; }
    /// Launches across the light from here on.
    void launchAcross(const LightPlane& plane) { plane_ = plane; }
    const std::optional<LightPlane>& plane() const { return plane_; }
    /// The point of the plane.
    glm::dvec3 planePoint(const EmissionParam& param) const {
        return plane_->centre + param.position.x * plane_->across + param.position.y * plane_->up;
    }

    /// Of travel, where light meets a point.
    glm::dvec3 directionAt(const glm::dvec3& point) const;

    /// @param face  geometric normal, unit, of the mesh triangle; unused for height fields
    EmittedRay at(const EmissionParam& param, const glm::dvec3& face) const;

    /// Power per channel [W] through the triangle between three points of the surface, in the surface's orientation:
    /// height fields take light from the side only where the light stands, meshes from either. A sun's by its
    /// cross-section, a lamp's by the solid angle [Van Oosterom and Strackee 1983] and the mean of its strength over
    /// the triangle.
    glm::dvec3 power(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const;

    /// What a lamp's strength does between two points of the surface and as far beside them: corners speak for the
    /// light between them only where it is even. A cone is narrow where corners so far apart would not tell its power,
    /// and so is any lamp's light where they are farther from one another than from the lamp.
    enum class Between { Even, Uneven, Narrow, Dark };
    Between between(const glm::dvec3& a, const glm::dvec3& b) const;

    /// Irradiance across the rays at a point [W/m2].
    glm::dvec3 irradianceAt(const glm::dvec3& point) const;

    /// Cross-section of a sun's beam [m2] through an oriented area.
    double across(const glm::dvec3& area) const {
        const double facing = -glm::dot(area, sample_.direction);
        return surface_.mesh ? std::fabs(facing) : std::max(0.0, facing);
    }

private:
    glm::dvec3 strengthTowards(const glm::dvec3& direction) const;
    glm::dvec3 meanStrength(const std::array<glm::dvec3, 3>& to) const;

    const Surface& surface_;
    int index_;
    LightSample sample_;
    bool from_below_;
    std::optional<LightPlane> plane_;
};

}  // namespace photic
