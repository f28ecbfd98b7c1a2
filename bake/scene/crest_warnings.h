// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// For methods in which waves do not shade each other: where they are so steep under so low a sun that a crest stands
/// between it and the water behind, a sentence with its share of the light and the remedy. The light that goes on
/// behind the crest is baked as if the crest were not there.
std::vector<std::string> crestWarnings(const Scene& scene);

}  // namespace photic
