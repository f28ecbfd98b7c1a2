// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// What the components of a brick's values are.
enum class Channels {
    FluxAndIrradiance,  ///< 4: flux.xyz, irradiance
    Irradiance,         ///< 1
    FluxX,
    FluxY,
    FluxZ,  ///< 1 each
    Rgb,    ///< 3: irradiance per channel, beside its mean in another grid
    Red,
    Green,
    Blue,                ///< 1 each
    ColouredIrradiance,  ///< 3: irradiance per channel, whose mean is taken
    Direction            ///< 3: times the irradiance that was set before
};
bool holdsColour(Channels channels);

/// Makes a Volume: all bricks are named first, then filled, channel by channel.
///
///     VolumeBuilder b(transform, limit);
///     for (...) b.addBrick(origin);
///     b.allocate(coloured);
///     for (...) b.setBrick(origin, Channels::FluxAndIrradiance, values);
///     Volume v = b.finish();
///
/// Throws Failure: internal to the library.
class VolumeBuilder {
public:
    /// @param largest_memory  of the volume [bytes]
    VolumeBuilder(const VoxelTransform& transform, std::uint64_t largest_memory);

    void setMetadata(const Metadata& metadata) { data_->metadata = metadata; }

    /// @param origin  the brick's first voxel; a multiple of 8. Named twice is named once.
    void addBrick(const Int3& origin) { origins_.push_back(origin); }

    /// @throws Failure{Limit} when it would exceed the limit
    void allocate(bool coloured);

    /// Says that `channels` are there at all, also where no brick is set.
    void beginChannels(Channels channels);

    /// @param values  512 voxels, x fastest, components interleaved; what is not finite becomes 0, irradiance below 0
    /// too
    void setBrick(const Int3& origin, Channels channels, const float* values);

    /// The second lobe, or a dark volume where there is none.
    void setSecondLobe(const Volume& second) { data_->second = second.litVoxelCount() > 0 ? second.share() : nullptr; }

    /// The same light as blocks for a GPU. @throws Failure{Limit}
    void setBlocks(std::shared_ptr<const BlockTexels> blocks);

    Volume finish();

private:
    void requireMemory(std::uint64_t bytes) const;
    Half repaired(float value, float least);
    /// 512 values, `stride` apart, of one component as halves.
    std::array<Half, VolumeData::kVoxels> halves(const float* values, std::size_t stride, float least);

    std::shared_ptr<VolumeData> data_;
    std::uint64_t largest_memory_;
    std::vector<Int3> origins_;
};

}  // namespace photic::runtime
