// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "bake/file/vdb.h"

namespace photic {

/// What a game must know of a light volume besides its voxels, as the files for games carry it:
/// docs/schemas/runtime.md. Keys that the volume does not know are absent.
nlohmann::ordered_json runtimeMetadata(const LightVolume& volume);

}  // namespace photic
