// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/geometric.hpp>

#include "bake/optics/snell.h"
#include "bake/scene/scene.h"

namespace photic {

/// One way on from a specular surface.
struct SpecularBranch {
    glm::dvec3 direction{0};  ///< unit, world
    double fraction = 0;      ///< of the arriving power
    bool below = false;       ///< runs on the side of ior_below: through the medium
};

/// What becomes of light at a surface. Fractions of all branches, `untraced` and `dropped` add up to 1.
struct SpecularEvent {
    std::array<SpecularBranch, 2> branches;
    int count = 0;
    double untraced = 0;  ///< the Fresnel branch that the surface's `event` leaves out (ledger: reflected)
    double dropped = 0;   ///< branches that would meet the same surface again at once (ledger: dropped)
};

/// What every method takes for one event:
/// - meshes take light from either side, height fields from above;
/// - a branch that leaves on the wrong side of the face, or from a height field refracts upwards or reflects downwards,
///   would meet the surface a second time at once: it is dropped;
/// - what a branch meets further on is the caller's to find.
///
/// @param direction  unit, of travel
/// @param normal     unit, smooth; on the side of ior_above
/// @param face       unit, geometric; equals `normal` for a height field
inline SpecularEvent specularEvent(const Surface& surface, const glm::dvec3& direction, const glm::dvec3& normal,
                                   const glm::dvec3& face) {
    const bool from_above = glm::dot(direction, face) < 0;
    const glm::dvec3 face_here = from_above ? face : -face;
    glm::dvec3 normal_here = from_above ? normal : -normal;
    if (glm::dot(direction, normal_here) >= 0)
        normal_here = face_here;  // a smoothed normal that turns away from the light
    const Interface i = from_above ? interfaceAt(direction, normal_here, surface.ior_above, surface.ior_below)
                                   : interfaceAt(direction, normal_here, surface.ior_below, surface.ior_above);
    const bool over_plane = surface.height_field != nullptr;

    SpecularEvent out;
    const auto branch = [&](bool traced, const glm::dvec3& to, double fraction, bool crosses) {
        if (fraction <= 0) return;
        if (!traced) {
            out.untraced += fraction;
            return;
        }
        const double side = glm::dot(to, face_here);
        const bool meets_again =
            crosses ? side >= 0 || (over_plane && to.z >= 0) : side <= 0 || (over_plane && to.z <= 0);
        if (meets_again) {
            out.dropped += fraction;
            return;
        }
        out.branches[static_cast<std::size_t>(out.count++)] = {to, fraction, crosses == from_above};
    };
    branch(surface.event != SurfaceEvent::Reflect, i.refracted, i.transmittance, true);
    branch(surface.event != SurfaceEvent::Refract, i.reflected, 1 - i.transmittance, false);
    return out;
}

}  // namespace photic
