// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>

#include "bake/field/needed_voxels.h"

namespace photic::cli {

/// Calls body(voxel) for every needed voxel, leaf by leaf.
template <class Body>
void forEachVoxel(const NeededVoxels& needed, const Body& body) {
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        const glm::ivec3 origin = needed.leafOrigin(slot);
        const auto& mask = needed.mask(slot);
        for (int word = 0; word < 8; ++word) {
            // Word w holds x = w; within it y is the upper and z the lower three bits.
            for (std::uint64_t bits = mask[static_cast<std::size_t>(word)]; bits != 0; bits &= bits - 1) {
                const int bit = std::countr_zero(bits);
                body(origin + glm::ivec3(word, bit >> 3, bit & 7));
            }
        }
    }
}

}  // namespace photic::cli
