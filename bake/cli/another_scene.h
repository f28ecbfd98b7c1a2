// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/cli/terminal.h"
#include "bake/file/vdb.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// A volume may be shown with a scene that has changed since; what cannot be of one bake is worth a word.
void warnOfAnotherScene(const Scene& scene, const LightVolume& volume, const std::string& path, Terminal& terminal);

}  // namespace photic::cli
