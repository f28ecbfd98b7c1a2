// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_refusal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "bake/paths/launch_domain.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/not_built.h"

namespace photic {

std::string waveRefusal(const Scene& scene) {
    if (std::string why = notBuiltYet(scene); !why.empty()) return why;
    if (scene.bake.paths == Paths::All) return "paths = \"all\" is not built yet; use paths = \"caustic\"";
    if (scene.bake.grids.arrival_time) return "waves have no grid 'arrival_time'; leave it out of bake.grids";
    Scene constant = scene;
    constant.index = nullptr;
    if (std::string refusal = specularRefusal(constant); !refusal.empty()) return refusal;
    for (const Light& light : scene.lights)
        if (light.type != LightType::Sun || light.position)
            return fmt::format("the light '{}' is no sun, and waves start from suns; use beams", light.name);
    if (scene.surfaces.size() > 1)
        return "waves run from one surface; bake the others as scenes of their own, or use beams";
    const Surface& surface = scene.surfaces.front();
    if (!surface.height_field) return "the surface is a mesh, and waves start from height fields; use beams";
    if (surface.event != SurfaceEvent::Refract)
        return "waves are not built for reflections; use event = \"refract\", or beams";
    if (scene.index && scene.index->least() < surface.ior_above)
        return fmt::format("the [[index]] goes down to {:.4g} under ior_above {}, where light can be reflected totally",
                           scene.index->least(), surface.ior_above);
    if (scene.domain.shear_mode != ShearMode::None)
        return "the grid leans, and waves step on upright ones; use shear = \"none\"";
    for (const Object& object : scene.objects) {
        if (!object.blocks()) continue;
        const Plane* plane = std::get_if<Plane>(&object.shape);
        const bool upright = plane && std::max({std::fabs(plane->normal.x), std::fabs(plane->normal.y),
                                                std::fabs(plane->normal.z)}) > 1 - 1e-9;
        if (!upright)
            return fmt::format(
                "object '{}' blocks light and is no plane along the grid, and waves cast no shadows; give it role = "
                "\"movable\" (light then goes on behind it), or use beams",
                object.name);
    }
    return {};
}

}  // namespace photic
