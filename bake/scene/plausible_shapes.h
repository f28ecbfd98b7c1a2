// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// The part of sceneWarnings() that is about what meshes and patches of water are like in themselves and beside the
/// domain: other units than metres, normals that belong to another shape, indices that are the same on both sides, two
/// surfaces in one place, and water that goes flat before light has entered the domain. Each a sentence with its number
/// and the remedy.
std::vector<std::string> shapeWarnings(const Scene& scene);

}  // namespace photic
