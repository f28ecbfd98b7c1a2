// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/src/index_volume_data.h"

namespace photic::runtime {

/// Several index volumes as the texels of one atlas: boxes beside one another along one axis.
struct IndexAtlas {
    static constexpr int kBlock = 2;  ///< nodes a side of a block that may be passed over

    struct Place {
        Int3 corner{0, 0, 0};    ///< first texel
        Int3 block{0, 0, 0};     ///< first block
        int channel_layers = 0;  ///< from a channel's spline to the next, in layers; 0: there is one
        int flags = 0;           ///< 1 attenuates, 2 glows, 4 has faces, 8 has a coat
    };
    std::vector<Place> places;
    Int3 texels{0, 0, 0};  ///< of all but the splines, which have three times the layers where light disperses
    Int3 blocks{0, 0, 0};
    int spline_layers = 0;
    bool attenuates = false, glows = false, has_faces = false, has_coat = false;

    /// How far blocks around one are alike, itself being 1, at most 255; 0: something changes within it.
    std::vector<std::uint8_t> reach;
    double even = 0;  ///< share of blocks with a reach

    /// @throws Failure{Limit} when no axis takes all
    IndexAtlas(const std::vector<IndexVolume>& objects, int largest_texture);

    std::vector<float> spline(const std::vector<IndexVolume>& objects) const;
    std::vector<Half4> gradients(const std::vector<IndexVolume>& objects) const;
    std::vector<Half4> attenuation(const std::vector<IndexVolume>& objects) const;
    std::vector<Half4> glow(const std::vector<IndexVolume>& objects) const;
    std::vector<std::uint8_t> faces(const std::vector<IndexVolume>& objects) const;
    /// The same, and behind it the coat: four bytes a node.
    std::vector<std::array<std::uint8_t, 4>> coat(const std::vector<IndexVolume>& objects) const;

private:
    bool lay(const std::vector<IndexVolume>& objects, std::size_t axis, int largest_texture);
    void findEven(const std::vector<IndexVolume>& objects);
    template <class T, class Value>
    std::vector<T> filled(const std::vector<IndexVolume>& objects, int layers, const Value& value) const;
};

}  // namespace photic::runtime
