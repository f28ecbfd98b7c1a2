// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/specular_event.h"

#include "bake/optics/snell.h"

namespace photic {

SpecularEvent specularEvent(const Surface& surface, double ior_from, double ior_to, const glm::dvec3& direction,
                            const glm::dvec3& normal, const glm::dvec3& face) {
    const bool turned = glm::dot(direction, face) >= 0;
    const glm::dvec3 face_here = turned ? -face : face;
    glm::dvec3 normal_here = turned ? -normal : normal;
    // A smoothed normal that turns away from the light.
    if (glm::dot(direction, normal_here) >= 0) normal_here = face_here;
    Interface i = interfaceAt(direction, normal_here, ior_from, ior_to);
    if (surface.thin) {
        const double once = 1 - i.transmittance;
        i.refracted = direction, i.transmittance = 1 - 2 * once / (1 + once);
    }
    const bool over_plane = surface.height_field != nullptr;

    SpecularEvent out;
    const auto branch = [&](bool traced, const glm::dvec3& to, const glm::dvec3& fraction, bool crosses) {
        const double mean = (fraction.x + fraction.y + fraction.z) / 3;
        if (mean <= 0) return;
        if (!traced) {
            out.untraced += mean;
            return;
        }
        const double side = glm::dot(to, face_here);
        const bool up = turned;  // light that comes from below a height field goes up
        const bool wrong_way = over_plane && (crosses == up ? to.z <= 0 : to.z >= 0);
        if ((crosses ? side >= 0 : side <= 0) || wrong_way) {
            out.dropped += mean;
            return;
        }
        out.branches[static_cast<std::size_t>(out.count++)] = {to, fraction, crosses};
    };
    if (surface.event == SurfaceEvent::Mirror) {
        out.absorbed = 1.0 - surface.colour;
        branch(true, i.reflected, surface.colour, false);
        // What is dropped is told as a mean of the channels: the rest of each is absorbed.
        if (out.count == 0) out.absorbed = glm::dvec3(1 - out.dropped);
        return out;
    }
    branch(surface.event != SurfaceEvent::Reflect, i.refracted, glm::dvec3(i.transmittance), true);
    branch(surface.event != SurfaceEvent::Refract, i.reflected, glm::dvec3(1 - i.transmittance), false);
    return out;
}

}  // namespace photic
