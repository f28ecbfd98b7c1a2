// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/scene/scene.h"

namespace photic {

/// What of a scene no method can bake yet, by name and with what would do, or "". Every method's refusal begins with
/// it.
std::string notBuiltYet(const Scene& scene);

/// Why a method that follows straight rays cannot bake a scene with a medium whose index varies in space, or "".
std::string gradedRefusal(const Scene& scene);

}  // namespace photic
