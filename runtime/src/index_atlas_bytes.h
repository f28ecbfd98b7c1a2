// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/index_volume_bytes.h"

namespace photic::runtime {

/// packIndexVolumes(). @throws Failure
IndexVolumeBytes atlasBytes(const std::vector<IndexVolume>& volumes, int largest_texture);

}  // namespace photic::runtime
