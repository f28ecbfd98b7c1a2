// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/another_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "bake/field/scene_grid.h"

namespace photic::cli {

void warnOfAnotherScene(const Scene& scene, const LightVolume& volume, const std::string& path, Terminal& terminal) {
    const double baked = volume.reference_irradiance, now = scene.referenceIrradiance();
    if (std::fabs(baked - now) > 1e-6 * now)
        terminal.warn(fmt::format("'{}' seems to be of another scene: its light has {:.6g} W/m2, that of '{}' {:.6g}",
                                  path, baked, scene.file, now));
    const GridFrame& lit = volume.field.frame();
    const GridFrame domain = sceneFrame(scene);
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);  // of the scene's box, in the volume's voxels
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at(corner & 1 ? domain.max.x : domain.min.x, corner & 2 ? domain.max.y : domain.min.y,
                            corner & 4 ? domain.max.z : domain.min.z);
        const glm::dvec3 index = lit.indexFromWorld(domain.worldFromIndex(at));
        low = glm::min(low, index), high = glm::max(high, index);
    }
    for (int a = 0; a < 3; ++a) {
        if (high[a] >= lit.min[a] && low[a] <= lit.max[a]) continue;
        terminal.warn(fmt::format("'{}' seems to be of another scene: it lies wholly outside the domain of '{}'", path,
                                  scene.file));
        return;
    }
}

}  // namespace photic::cli
