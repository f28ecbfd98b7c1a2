// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "bake/report/monitor.h"
#include "bake/threads/parallel_for.h"

namespace photic {

/// Place of a node in arrays, which have x fastest.
inline std::size_t flat(const glm::ivec3& count, const glm::ivec3& p) {
    return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(count.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(count.x) +
           static_cast<std::size_t>(p.x);
}

/// Calls visit(node, its place in arrays) for all nodes, layer by layer on all threads.
template <class Visit>
void forEachNode(const glm::ivec3& count, Monitor& monitor, const Visit& visit) {
    parallelFor(count.z, [&](std::int64_t layer) {
        monitor.checkCancelled();
        const int z = static_cast<int>(layer);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) visit(glm::ivec3(x, y, z), flat(count, {x, y, z}));
    });
}

/// Per two nodes, of what value(its place in arrays) has at each.
template <class Value>
glm::dvec3 differenceAt(const glm::ivec3& count, const glm::ivec3& node, const Value& value) {
    glm::dvec3 difference;
    for (int a = 0; a < 3; ++a) {
        glm::ivec3 ahead = node, behind = node;
        ahead[a] = std::min(node[a] + 1, count[a] - 1), behind[a] = std::max(node[a] - 1, 0);
        difference[a] = value(flat(count, ahead)) - value(flat(count, behind));
    }
    return difference;
}

}  // namespace photic
