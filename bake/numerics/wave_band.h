// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bake/numerics/wave_kernel.h"

namespace photic {

/// A box of 8^3 blocks, z fastest, of which some may be left out.
struct WaveGrid {
    glm::ivec3 blocks{0};   ///< of the box
    glm::dvec3 spacing{1};  ///< of the cells
    std::array<bool, 3> periodic{};
    std::vector<std::uint8_t> present;  ///< by block; empty: all

    int count() const { return blocks.x * blocks.y * blocks.z; }
    int index(const glm::ivec3& b) const { return (b.x * blocks.y + b.y) * blocks.z + b.z; }
    glm::ivec3 place(int block) const {
        return {block / blocks.z / blocks.y, block / blocks.z % blocks.y, block % blocks.z};
    }
    bool has(int block) const { return present.empty() || present[static_cast<std::size_t>(block)] != 0; }
    /// The block beyond a side (-x, +x, -y, +y, -z, +z); -1 where there is none.
    int neighbour(int block, int side) const;
};

/// A block that takes part in the current steps.
struct WaveActive {
    int block = 0;
    float* field = nullptr;          ///< two time levels of 512 cells
    float* speed2 = nullptr;         ///< of 512 cells, behind the field; null where the speed is constant
    float* sums = nullptr;           ///< channels x 512 cells; null where nobody asked for them
    float* memory = nullptr;         ///< psi and zeta of the matched axes; null elsewhere
    std::array<int, 6> neighbour{};  ///< their number among the active; -1: not active
};

/// The blocks around the waves, and their memory. Blocks come and go; what remains keeps its values.
class WaveBand {
public:
    /// @param sum_channels    per cell of wanted blocks
    /// @param memory_fields   of 512 floats by block: 0 outside of the matched layer
    /// @param speed2          fills c^2 of a block that joins, from several threads; empty: the speed is constant
    WaveBand(const WaveGrid& grid, int sum_channels, std::vector<std::uint8_t> wanted,
             std::vector<std::uint8_t> memory_fields, std::function<void(int block, float* speed2)> speed2 = {});
    ~WaveBand();

    const std::vector<WaveActive>& active() const { return active_; }
    /// Number of a block among the active, or -1.
    int find(int block) const { return number_[static_cast<std::size_t>(block)]; }

    /// Makes exactly `blocks` (ascending) active; new ones hold zeros. `retire` sees each block that goes.
    void become(const std::vector<int>& blocks, const std::function<void(const WaveActive&)>& retire);

    std::int64_t bytes() const;  ///< of fields, sums and memory now
    std::int64_t peakBytes() const { return peak_bytes_; }
    std::size_t peakBlocks() const { return peak_blocks_; }

private:
    struct Pool;
    const WaveGrid& grid_;
    std::vector<std::uint8_t> wanted_, memory_fields_;
    std::function<void(int block, float* speed2)> speed2_;
    std::vector<std::unique_ptr<Pool>> pools_;  // fields, sums, memory of 2, 4 and 6 fields
    std::vector<WaveActive> active_;
    std::vector<std::int32_t> number_;
    std::int64_t peak_bytes_ = 0;
    std::size_t peak_blocks_ = 0;
};

}  // namespace photic
