// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace photic {

/// Where bent rays meet the layers of one slab: what takes the place of straight corners there.
struct BentRows {
    static constexpr int kLanes = 16;
    /// What a ray's rows hold, one number a layer: place and slope in the middle of the layer [voxels], 1 once the ray
    /// has met what bends it (and 0 before), the length of its momentum (the index there), and the share of its power
    /// that is left, per channel; and, where asked for, its optical path so far [m].
    enum Row { kU, kV, kSlopeU, kSlopeV, kLit, kMomentum, kLeft };

    int first_column[2] = {0, 0};     ///< voxel that kU and kV count from: single precision holds no map's coordinates
    int channels = 1;                 ///< of kLeft
    bool timed = false;               ///< there is timeRow()
    float voxel[3] = {1, 1, 1};       ///< size along u, v and w [m]
    std::vector<float> values;        ///< per ray, per row, kLanes
    std::vector<std::uint32_t> rays;  ///< the ray of each of TubeSet::corners

    int timeRow() const { return kLeft + channels; }
    std::size_t rayStride() const { return static_cast<std::size_t>(kLeft + channels + (timed ? 1 : 0)) * kLanes; }
    const float* of(std::uint32_t corner) const { return &values[rays[corner] * rayStride()]; }
};

}  // namespace photic
