// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/file/vdb.h"

namespace photic {

/// A leaf of a file: its voxels that are active, and where its light lies.
struct ActiveLeaf {
    glm::ivec3 origin;  ///< a multiple of 8
    int slot;           ///< of the light field, or -1
    NeededVoxels::Mask mask;
    std::int64_t count() const;  ///< active voxels
};

enum class ActiveBy { Light, LightOrMedium };

/// The topology that all grids of a file share: voxels with more than 1e-6 of the reference irradiance (or density), in
/// a fixed order, of a part those of its tile; one dark voxel when there are none.
std::vector<ActiveLeaf> activeLeaves(const LightVolume& volume, ActiveBy by);

/// Those of a volume's leaves where its second lobe has light.
std::vector<ActiveLeaf> secondLobeLeaves(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves);

/// Mean irradiance over the channels [W/m2] of the 512 voxels of a leaf that is not Empty.
void meanIrradiance(const LightField& field, int slot, float* mean);

}  // namespace photic
