// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/scene.h"

#include <algorithm>

namespace photic {

bool Scene::coloured() const {
    return medium.coloured() ||
           std::any_of(lights.begin(), lights.end(), [](const Light& light) { return light.coloured(); });
}

double Scene::referenceIrradiance() const {
    glm::dvec3 sum(0);
    for (const Light& light : lights) sum += light.irradiance;
    const double largest = std::max({sum.x, sum.y, sum.z});
    return largest > 0 ? largest : 1;
}

}  // namespace photic
