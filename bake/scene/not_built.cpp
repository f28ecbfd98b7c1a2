// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/not_built.h"

#include <fmt/format.h>

#include "bake/scene/index_volume.h"

namespace photic {
namespace {

std::string lightNotBuilt(const Scene& scene, const Light& light) {
    if (light.type == LightType::Spot || light.type == LightType::Rectangle)
        return fmt::format("the light '{}' is a {}, which is not built yet; use type = \"sun\" or \"point\"",
                           light.name, light.type == LightType::Spot ? "spot" : "rectangle");
    if (light.type == LightType::Point)
        for (const Surface& surface : scene.surfaces)
            if (surface.height_field && !(light.position->z > surface.height_field->maxZ()))
                return fmt::format(
                    "the point light '{}' lies at z = {} m, not above the surface '{}', which reaches up to "
                    "{:.4g} m; raise it",
                    light.name, light.position->z, surface.name, surface.height_field->maxZ());
    return {};
}

std::string surfaceNotBuilt(const Scene& scene, const Surface& surface) {
    if (surface.event == SurfaceEvent::Mirror)
        return fmt::format(
            "surface '{}' is a mirror, which is not built yet; event = \"reflect\" has the reflection of "
            "water or glass",
            surface.name);
    if (surface.thin) return fmt::format("surface '{}' is a thin pane, which is not built yet", surface.name);
    const bool refracts = surface.event != SurfaceEvent::Reflect;
    if (surface.closed && refracts)
        return fmt::format(
            "surface '{}' is closed: light that goes in and out again is not built yet; leave the mesh "
            "open, as water seen from above is, or set event = \"reflect\"",
            surface.name);
    if (!surface.closed_part.empty() && refracts)
        return fmt::format(
            "a part of surface '{}' ({}) is closed: light that goes in and out again is not built yet; "
            "remove drops and bubbles from the mesh",
            surface.name, surface.closed_part);
    for (const int medium : {surface.medium_above, surface.medium_below})
        if (medium >= 0)
            return fmt::format(
                "surface '{}' has the medium '{}' beside it, and named media are not built yet; give its "
                "ior as ior_above or ior_below, and what is below the water as [medium]",
                surface.name, scene.media[static_cast<std::size_t>(medium)].name);
    return {};
}

}  // namespace

std::string gradedRefusal(const Scene& scene) {
    if (!scene.index || scene.index->objects().empty()) return {};
    return fmt::format(
        "light bends on its way through the medium '{}', whose index varies, and rays go straight here; choose "
        "another method, or leave it to method = \"auto\"",
        scene.index->objects().front().name);
}

std::string notBuiltYet(const Scene& scene) {
    if (std::string why = gradedRefusal(scene); !why.empty()) return why;
    for (const Light& light : scene.lights)
        if (std::string why = lightNotBuilt(scene, light); !why.empty()) return why;
    for (const Surface& surface : scene.surfaces)
        if (std::string why = surfaceNotBuilt(scene, surface); !why.empty()) return why;
    if (scene.bake.bounces.value_or(1) != 1)
        return fmt::format("[bake] asks for {} bounces, and one event a path is built for now; remove 'bounces'",
                           *scene.bake.bounces);
    if (scene.bake.threshold)
        return "[bake] has a 'threshold', which belongs to several bounces, not built yet; remove it";
    return {};
}

}  // namespace photic
