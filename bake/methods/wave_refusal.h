// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/scene/scene.h"

namespace photic {

/// Why waves cannot bake a scene, with what can; empty where they can.
std::string waveRefusal(const Scene& scene);

}  // namespace photic
