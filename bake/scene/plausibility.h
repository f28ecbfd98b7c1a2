// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// What of a scene is allowed and yet is hardly meant: water that lies upside down, a file that is Y up, an index
/// volume beside the water, a domain that holds nothing, surfaces finer than the voxels, light that cannot get in,
/// waves that would shade each other, endless planes between the sun and the water, and what shapeWarnings() tells.
/// Each a sentence with its number (watts, or a share) and the remedy.
///
/// Cost: some thousand points of each surface, and a walk over each mesh.
std::vector<std::string> sceneWarnings(const Scene& scene);

}  // namespace photic
