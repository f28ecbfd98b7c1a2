// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "bake/field/grid_frame.h"
#include "bake/paths/optical_scene.h"
#include "bake/picture/view_shading.h"
#include "bake/scene/scene.h"

namespace photic {

/// Eye rays through glass and off mirrors: refracted and reflected as light is (Snell, Fresnel, total reflection,
/// nested media), whatever events the bake follows; radiance is scaled by T (n_eye / n_there)^2.
///
/// Planes are seen from their lit side, inside the domain. Receivers get the volume's light, and a sun's or lamp's own
/// where nothing stands between. Rays that leave through glass alone show the background, mirrored ones the sky.
class GlassView {
public:
    /// @param shading  must outlive the object
    GlassView(const Scene& scene, const GridFrame& frame, const ViewShading& shading);
    GlassView(const GlassView&) = delete;
    GlassView& operator=(const GlassView&) = delete;

    Rgba trace(const glm::dvec3& origin, const glm::dvec3& direction, std::uint32_t seed) const;

private:
    struct EyeRay {
        glm::dvec3 origin, direction, throughput{1};
        MediumStack inside;
        int events = 0;
        bool mirrored = false;
        std::uint32_t seed = 0;
    };
    struct Leg {
        OpticalScene::LegEnd end;
        double length = 0;  ///< [m] to the end
        MediumStack inside;
    };
    void follow(const EyeRay& ray, Rgba& out) const;
    void meetSurface(const EyeRay& ray, const Leg& leg, Rgba& out) const;
    Leg nextMeeting(const EyeRay& ray) const;
    bool isSeen(const RayHit& hit, const glm::dvec3& position, const glm::dvec3& direction) const;
    MediumStack insideAt(const glm::dvec3& eye) const;
    void addHaze(const EyeRay& ray, const Leg& leg, glm::dvec3& throughput, Rgba& out) const;
    glm::dvec3 direct(const glm::dvec3& position, const glm::dvec3& normal) const;

    Scene scene_;  // as the eye meets it: both branches of every surface, movables too
    OpticalScene optics_;
    const ViewShading& shading_;
    double size_;  // of the domain [m]
};

}  // namespace photic
