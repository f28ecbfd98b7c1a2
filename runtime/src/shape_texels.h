// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "photic/index_volume.h"
#include "photic/volume_bytes.h"

namespace photic::runtime {

/// All shapes of some objects as one texture of four whole numbers a texel; floats by their bits
/// (docs/index_volumes.md, The shapes on a GPU).
struct ShapeTexels {
    static constexpr std::uint32_t kWidth = 2048;
    TextureBytes texture;              ///< Rgba32Uint, of one layer; one texel of zeros without shapes
    std::vector<std::int32_t> places;  ///< of each object's header; -1: it has no shape

    /// @throws Failure{Limit} for more than a texture of `largest_texture` rows holds
    ShapeTexels(const std::vector<IndexVolume>& objects, int largest_texture);
};

}  // namespace photic::runtime
