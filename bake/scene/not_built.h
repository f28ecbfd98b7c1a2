// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/scene/scene.h"

namespace photic {

/// What of a scene no method can bake yet, by name and with what would do, or "". Every method's refusal begins with
/// it.
std::string notBuiltYet(const Scene& scene);

}  // namespace photic
