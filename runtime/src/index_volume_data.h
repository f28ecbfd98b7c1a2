// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "photic/index_volume.h"
#include "runtime/src/half_float.h"
#include "runtime/src/sharp_shape.h"
#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// What an IndexVolume holds. Arrays have x fastest; nodes are the transform's voxels.
struct IndexVolumeData {
    std::string name;
    VoxelTransform transform;
    Int3 count{0, 0, 0};
    std::array<std::vector<float>, 3> spline;  ///< coefficients of (n^2 - 1) / 2; the last two empty without dispersion
    std::vector<Half4> attenuation;            ///< absorption r, g, b [1/m], how much is there; or empty
    std::vector<Half4> glow;                   ///< emission r, g, b [W/(m3 sr)], g; or empty
    std::vector<std::uint8_t> faces;           ///< 255 around faces; or empty
    std::vector<std::array<std::uint8_t, 3>> coat;  ///< albedo of faces, of 255; or empty: `albedo` everywhere
    std::array<float, 3> albedo{0, 0, 0};
    float roughness = 0;                       ///< of highlights on faces; 0: none
    std::array<float, 3> scattering{0, 0, 0};  ///< [1/m]
    float anisotropy = 0;
    Double3 box_low{0, 0, 0}, box_high{0, 0, 0};
    bool sharp_sides = false;
    std::optional<SharpShape> shape;  ///< the object is what lies in it; without a spline of one index

    bool hasSamples() const { return !spline[0].empty(); }
    std::size_t nodeCount() const {
        return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
               static_cast<std::size_t>(count[2]);
    }
    std::size_t flat(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(count[0]) +
               static_cast<std::size_t>(x);
    }
};

}  // namespace photic::runtime
