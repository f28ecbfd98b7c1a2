// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "runtime/src/bytes.h"

namespace photic::runtime {

struct BrickPlan;
struct VolumeData;

/// One lobe's light as BC6H blocks of 4 x 4 texels, as `photic export --compress bc6h` makes them and docs/files.md
/// says: a texture of flux and one of colour, of one box of voxels or of bricks that lie one behind the other. GPUs
/// read them as they are; what they decode to stands in the file's other grids.
struct BlockTexels {
    using Int3 = std::array<int, 3>;
    static constexpr int kPitch = 12, kSide = 9;  ///< a brick's texels: 12 x 12 x 9, the first 9^3 of which are voxels
    static constexpr std::size_t kBlockBytes = 16;

    bool one_box = false;
    Int3 first{0, 0, 0};   ///< of one box: its first voxel
    Int3 texels{0, 0, 0};  ///< of each texture
    bool signed_flux = false;
    std::array<float, 3> mirror{0, 0, 0};  ///< flux = s - 2 mirror dot(mirror, s), where s is stored - bias
    float bias = 0;                        ///< on all components of both textures
    std::map<std::array<int, 4>, std::uint32_t> numbers;  ///< of bricks, by page and step
    std::vector<unsigned char> flux, colour;

    /// @throws Failure{Format}
    static std::shared_ptr<const BlockTexels> of(const Bytes& bytes);

    /// Whether all that a plan of the volume reads is there, laid out as the file has it.
    bool serve(const BrickPlan& plan, const VolumeData& data) const;

    static std::size_t blocksIn(int texels_along) { return (static_cast<std::size_t>(texels_along) + 3) / 4; }
    std::uint64_t bytes() const { return flux.size() + colour.size() + numbers.size() * 64; }
};

}  // namespace photic::runtime
