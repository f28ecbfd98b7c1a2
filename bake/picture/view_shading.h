// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "bake/file/vdb.h"
#include "bake/picture/view_picture.h"
#include "bake/picture/volume_lookup.h"
#include "bake/scene/scene.h"

namespace photic {

/// What one eye ray brings back: linear radiance, premultiplied, and how much of the background it hides.
struct Rgba {
    glm::dvec3 colour{0};
    double alpha = 0;
};

/// A medium as the camera sees it [1/m].
struct Haze {
    glm::dvec3 extinction{0}, scattering{0};
    double anisotropy = 0;
};

/// How what eye rays meet looks: receivers and lit media by the light volume; the sky, skylight, tiles and the tint of
/// clean water are decoration. Shared by all ways of following eye rays. Thread-safe.
class ViewShading {
public:
    /// All must outlive the object.
    ViewShading(const Scene& scene, const LightVolume& volume, const ViewSettings& settings);

    /// A clear sky with the sun's glitter.
    glm::dvec3 sky(const glm::dvec3& direction) const;
    glm::dvec3 deepWater() const;
    /// Light that single scattering sends towards the eye along a stretch of the ray.
    /// @param seed  of the steps' jitter
    glm::dvec3 inScatter(const glm::dvec3& origin, const glm::dvec3& direction, double length, const Haze& haze,
                         std::uint32_t seed) const;
    /// Radiance of a receiver: albedo / pi times its light.
    /// @param object  in Scene::objects
    /// @param normal  unit, towards the eye
    /// @param direct  irradiance that has met no surface, which the volume does not hold [W/m2]
    glm::dvec3 receiver(const glm::dvec3& position, const glm::dvec3& normal, int object,
                        const glm::dvec3& direct) const;

    /// A medium's haze, or more of it where the settings ask for shafts.
    Haze hazeOf(const glm::dvec3& extinction, const glm::dvec3& scattering, double anisotropy) const;
    /// Of the water; clean water's where the scene sets no medium.
    const Haze& water() const { return water_; }
    double reference() const { return reference_; }
    double stepLength() const { return step_length_; }
    /// The brightest sun.
    const glm::dvec3& sunDirection() const { return sun_direction_; }
    const glm::dvec3& sunIrradiance() const { return sun_irradiance_; }

private:
    const Scene& scene_;
    const ViewSettings& settings_;
    VolumeLookup lookup_;
    Haze water_;
    double reference_;
    glm::dvec3 sun_direction_{0, 0, -1}, sun_irradiance_{0};
    double sky_scale_ = 0, step_length_ = 1;
};

}  // namespace photic
