// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/index_volume_bytes.h"

namespace photic::runtime {

/// packIndexVolumes(). @throws Failure
/// @param largest_flat  of 2D textures [texels a side]
IndexVolumeBytes atlasBytes(const std::vector<IndexVolume>& volumes, int largest_texture, int largest_flat);

}  // namespace photic::runtime
