// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/scene/index_volume.h"

namespace photic {

double Light::spotFalloff(double cos_to_axis) const {
    if (type != LightType::Spot) return 1;
    const double rim = std::cos(0.5 * cone_angle_deg * std::numbers::pi / 180);
    if (cos_to_axis <= rim) return 0;
    const double within = (cos_to_axis - rim) / (1 - rim);
    if (within >= blend) return 1;
    const double t = within / blend;
    return t * t * (3 - 2 * t);
}

Medium sideOf(const Scene& scene, const Surface& surface, Side side) {
    const int named = side == Side::Above ? surface.medium_above : surface.medium_below;
    if (named >= 0) return scene.media[static_cast<std::size_t>(named)];
    Medium medium;
    if (side == Side::Above) {
        medium.ior = surface.ior_above;
        return medium;
    }
    const bool lets_in = surface.event != SurfaceEvent::Reflect && surface.event != SurfaceEvent::Mirror;
    if (lets_in && !surface.closed) medium = scene.medium;  // the water lies around what is closed
    medium.ior = surface.ior_below;
    return medium;
}

bool Scene::coloured() const {
    const auto coloured = [](const Medium& m) { return m.coloured() || m.ior.disperses(); };
    const auto tinted = [](const Surface& s) {
        return s.event == SurfaceEvent::Mirror && (s.colour.x != s.colour.y || s.colour.y != s.colour.z);
    };
    if (index)
        for (const GradedObject& object : index->objects())
            if (object.coloured()) return true;
    return medium.coloured() || std::any_of(media.begin(), media.end(), coloured) ||
           std::any_of(surfaces.begin(), surfaces.end(), tinted) ||
           std::any_of(lights.begin(), lights.end(), [](const Light& light) { return light.coloured(); });
}

double Scene::referenceIrradiance() const {
    glm::dvec3 sum(0);
    for (const Light& light : lights) sum += light.irradiance;
    const double largest = std::max({sum.x, sum.y, sum.z});
    return largest > 0 ? largest : 1;
}

}  // namespace photic
