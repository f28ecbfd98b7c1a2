// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace photic {

/// The eight z layers of a leaf together: one weight a layer for each offset; offsets without weight are left out.
struct LeafStencil {
    static constexpr int kLayers = 8;
    struct Tap {
        int dx, dy;
        float weight[kLayers];
    };
    int radius = 0;  ///< the largest |dx|, |dy|
    std::vector<Tap> taps;
};

/// out[x][y][z] = sum over taps of weight[z] * tile[x + dx][y + dy][z], for the 64 columns of a leaf.
/// @param tile  8 + 2 radius columns a side, z fastest
using ConvolveLeaf = void (*)(const LeafStencil&, const float* tile, float* out);

}  // namespace photic
