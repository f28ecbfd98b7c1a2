// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "bake/field/needed_voxels.h"

namespace photic {

/// Which channels a field carries. Storage order: irradiance (1 or 3), then flux x y z if present.
struct FieldChannels {
    int irradiance = 1;  ///< 1: white, 3: red green blue
    bool flux = true;    ///< flux vector [W/m2], weighted by the mean of the irradiance channels
    int count() const { return irradiance + (flux ? 3 : 0); }
};

enum class LeafState : std::uint8_t {
    Empty,     ///< all zero, no memory
    Constant,  ///< one value per channel
    Dense      ///< channels x 512 floats
};

/// Light on the needed voxels: physical fluence rate E [W/m2] and flux F = sum of E_j w_j [W/m2, world axes],
/// in single precision, 8^3 leaves in OpenVDB's voxel order ((x&7)<<6 | (y&7)<<3 | (z&7)), channel after channel.
/// Leaves are numbered by NeededVoxels' slots. Memory follows the leaves that hold light.
///
/// Writing different leaves from different threads is safe; one leaf belongs to one thread at a time.
class LightField {
public:
    static constexpr int kLeafVoxels = 512;

    LightField(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels);
    ~LightField();
    LightField(LightField&&) noexcept;
    LightField& operator=(LightField&&) noexcept;

    const NeededVoxels& needed() const { return *needed_; }
    std::shared_ptr<const NeededVoxels> neededPtr() const { return needed_; }
    const GridFrame& frame() const { return needed_->frame(); }
    FieldChannels channels() const { return channels_; }
    int leafCount() const { return needed_->leafCount(); }

    LeafState state(int slot) const { return states_[static_cast<std::size_t>(slot)]; }
    /// channels x 512 values of a Dense leaf.
    const float* dense(int slot) const { return data_[static_cast<std::size_t>(slot)]; }
    float* dense(int slot) { return data_[static_cast<std::size_t>(slot)]; }
    /// One value per channel of a Constant leaf.
    std::span<const float> constant(int slot) const {
        return {data_[static_cast<std::size_t>(slot)], static_cast<std::size_t>(channels_.count())};
    }

    /// Makes a leaf Dense, keeping its values (zero when Empty), and returns channels x 512 floats.
    float* makeDense(int slot);
    /// As makeDense, but the contents are undefined unless the leaf was not Empty; the caller writes all of it.
    /// `was_empty` tells whether to store or to add.
    float* makeDenseUninitialised(int slot, bool& was_empty);
    /// Makes a leaf Constant, or changes its values.
    void setConstant(int slot, std::span<const float> values);
    void setEmpty(int slot);

    /// Value of one channel at a voxel; 0 where not needed. Slow; for tests and look-ups.
    float value(const glm::ivec3& voxel, int channel) const;
    /// Mean of the irradiance channels at a voxel.
    double irradiance(const glm::ivec3& voxel) const;
    glm::dvec3 flux(const glm::ivec3& voxel) const;

    /// Bytes held, tables included.
    std::int64_t bytes() const;
    /// Sum over the needed voxels of one channel, in double, in a fixed order; of a part, over its tile.
    double sum(int channel) const { return sumOf(channel, false); }
    /// The same over what lies beside the tile of a part; 0 where it is none.
    double sumBesideTile(int channel) const { return needed_->isPart() ? sumOf(channel, true) : 0.0; }

private:
    struct Arena;
    double sumOf(int channel, bool beside_tile) const;
    std::shared_ptr<const NeededVoxels> needed_;
    FieldChannels channels_;
    std::vector<LeafState> states_;
    std::vector<float*> data_;
    std::unique_ptr<Arena> arena_;
};

}  // namespace photic
