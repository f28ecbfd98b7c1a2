// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/file/vdb.h"

namespace photic {

/// A volume of a sequence, as a layer of USD names it.
struct UsdFrame {
    int frame = 0;
    std::string file;  ///< its .vdb, relative to the layer
};

/// A text layer of USD that refers to light volumes: a `Volume` with an `OpenVDBAsset` for each grid, metres, Z up, the
/// metadata as `customData`. The voxels stay in the .vdb.
/// @param first   of the frames: says what grids there are, and their metadata
/// @param frames  one, or those of a sequence, in order: then files are time samples
std::string usdaLayer(const std::string& name, const LightVolume& first, const std::vector<UsdFrame>& frames,
                      double frames_per_second);

}  // namespace photic
