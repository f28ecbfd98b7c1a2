// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/flat_blocks.h"

#include <algorithm>
#include <glm/common.hpp>

#include "bake/threads/parallel_for.h"

namespace photic {

FlatBlocks::FlatBlocks(const SplineIndex& index, const std::vector<std::uint8_t>& media) {
    // Less than this share is rounding of single precision.
    constexpr float kSame = 2e-7f;
    const glm::ivec3 nodes = index.nodes().count;
    count_ = (nodes + kCells - 1) / kCells;
    flat_.assign(
        static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) * static_cast<std::size_t>(count_.z),
        0);
    const auto node = [&](int x, int y, int z) {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(nodes.y) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(nodes.x) +
               static_cast<std::size_t>(x);
    };
    const auto isFlat = [&](const glm::ivec3& block) {
        // The spline in a cell reaches from the node before it to the second one after.
        const glm::ivec3 low = glm::max(block * kCells - 1, glm::ivec3(0)),
                         high = glm::min(block * kCells + kCells + 1, nodes - 1);
        const float* values = index.coefficients();
        const float first = values[node(low.x, low.y, low.z)];
        const std::uint8_t medium = media.empty() ? std::uint8_t{0} : media[node(low.x, low.y, low.z)];
        float least = first, most = first;
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y) {
                for (int x = low.x; x <= high.x; ++x) {
                    least = std::min(least, values[node(x, y, z)]), most = std::max(most, values[node(x, y, z)]);
                    if (!media.empty() && media[node(x, y, z)] != medium) return false;
                }
                if (most - least > kSame * most) return false;
            }
        return true;
    };
    parallelFor(count_.z, [&](std::int64_t z) {
        for (int y = 0; y < count_.y; ++y)
            for (int x = 0; x < count_.x; ++x) {
                const glm::ivec3 block(x, y, static_cast<int>(z));
                flat_[flatIndex(block)] = isFlat(block) ? 1 : 0;
            }
    });
}

glm::ivec3 FlatBlocks::blockOf(const glm::dvec3& node) const {
    return glm::clamp(glm::ivec3(glm::floor(node / double(kCells))), glm::ivec3(0), count_ - 1);
}

}  // namespace photic
