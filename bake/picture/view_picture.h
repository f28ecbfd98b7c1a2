// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "bake/file/vdb.h"
#include "bake/image/image.h"
#include "bake/scene/scene.h"

namespace photic {

/// How the camera sees water.
enum class ViewLook {
    Cutaway,  ///< the box's sides are open and eye rays go straight on: the surface only reflects the sky
    Natural   ///< the box's sides are solid; eye rays refract and reflect at the surface
};

/// A perspective camera and what is shown besides the baked light.
struct ViewSettings {
    glm::dvec3 eye{0}, target{0};   ///< world [m]
    glm::dvec3 up{0, 0, 1};         ///< that the picture's upper edge lies towards
    double field_of_view_deg = 34;  ///< of the height
    int width = 960, height = 640;
    int samples = 2;                      ///< a side, per pixel
    glm::dvec3 albedo{0.80, 0.82, 0.84};  ///< of receivers that state none
    double tile_size = 0;                 ///< [m] of tiles drawn on receivers; 0: plain
    double ambient = 0.06;                ///< skylight on receivers, as a fraction of the reference irradiance
    /// Scattering seen by the camera [1/m]; absent: the scene's medium. Pictures only: the bake does not know it.
    std::optional<double> shaft_scattering;
    std::optional<double> shaft_anisotropy;
    ViewLook look = ViewLook::Cutaway;
    bool show_surface = true;  ///< false: no reflection or refraction of eye rays at all
    int march_steps = 64;      ///< across the domain's diagonal
};

/// The scene's first camera; without one, one that sees the whole domain from above at an angle, from the side that the
/// light comes from.
ViewSettings defaultView(const Scene& scene);

/// Looks at the scene's planes, water surface and lit water: linear radiance [W/m2/sr], RGBA, colour premultiplied.
///
/// Planes are seen from their lit side only. Receivers show albedo / pi x their irradiance from the volume, single
/// scattering is marched through the water. A natural look refracts and reflects eye rays at the surface (Snell,
/// Fresnel; radiance is scaled by T (n_camera / n_water)^2). The sky, skylight, solid sides and, without a medium in
/// the scene, the tint of clean water are decoration.
Image viewPicture(const Scene& scene, const LightVolume& volume, const ViewSettings& settings);

}  // namespace photic
