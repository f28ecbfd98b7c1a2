// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bake/file/vdb.h"

namespace photic {

/// What was written of a box of voxels.
struct DenseWritten {
    std::vector<std::string> files;  ///< in the order of writing, the sidecar last
    glm::ivec3 size{0};              ///< of the box, along Photic's axes
    std::int64_t clamped = 0;        ///< values that were not finite or above 65504, and were cut
};

// A box of voxels here is one of the grid that a dense file is laid out from: the volume's own, or the straight one
// that a sheared volume is resampled to.

/// The voxels of `volume` with light; nothing when it is dark.
std::optional<VoxelBox> litBox(const LightVolume& volume);

/// The smallest box around both; nothing when neither is there.
std::optional<VoxelBox> together(const std::optional<VoxelBox>& a, const std::optional<VoxelBox>& b);

/// A volume's field on axes that readers of dense files understand: its own, or resampled when it is sheared.
/// The volume must outlive it.
class StraightField {
public:
    explicit StraightField(const LightVolume& volume);
    const LightField& field() const { return resampled_ ? *resampled_ : volume_.field; }
    /// The second lobe on the same axes, or null.
    const LightField* second() const {
        return resampled_second_ ? &*resampled_second_ : volume_.second ? &*volume_.second : nullptr;
    }
    bool resampled() const { return resampled_.has_value(); }
    /// The box that was asked for, or that of the voxels with light; one voxel for a dark volume.
    VoxelBox box(const std::optional<VoxelBox>& wanted) const;

private:
    const LightVolume& volume_;
    std::optional<LightField> resampled_, resampled_second_;
};

}  // namespace photic
