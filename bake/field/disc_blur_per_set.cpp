// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include <cstring>

#include "bake/field/leaf_stencil.h"

namespace photic::PHOTIC_ISA {

void convolveLeaf(const LeafStencil& stencil, const float* tile, float* out) {
    constexpr int kLanes = LeafStencil::kLayers;
    const int side = 8 + 2 * stencil.radius;
    for (int x = 0; x < 8; ++x) {
        float sum[8 * kLanes] = {};
        for (const auto& tap : stencil.taps) {
            const float* row = tile + ((x + stencil.radius + tap.dx) * side + stencil.radius + tap.dy) * kLanes;
            for (int y = 0; y < 8; ++y)
                for (int k = 0; k < kLanes; ++k) sum[y * kLanes + k] += tap.weight[k] * row[y * kLanes + k];
        }
        std::memcpy(out + x * 64, sum, sizeof(sum));
    }
}

}  // namespace photic::PHOTIC_ISA
