// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/index_slices.h"

#include <algorithm>
#include <cmath>

#include "bake/threads/parallel_for.h"

namespace photic {

void collapseIndex(const SplineIndex& index, const FrontFrame& frame, int first_w, int layers, int sense, int steps,
                   IndexSlices& out) {
    const glm::ivec3 count = index.nodes().count;
    const std::size_t strides[3] = {1, static_cast<std::size_t>(count.x),
                                    static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y)};
    const int u = (frame.axis + 1) % 3, v = (frame.axis + 2) % 3, w = frame.axis;
    out.columns = count[u], out.rows = count[v], out.steps = steps;
    out.first_u = static_cast<float>(frame.first_node[u]), out.first_v = static_cast<float>(frame.first_node[v]);
    const int planes = layers * steps;
    out.value.resize(static_cast<std::size_t>(planes) * out.plane());
    out.slope.resize(out.value.size());
    parallelFor(std::int64_t{planes} * out.rows, [&](std::int64_t task) {
        const int plane = static_cast<int>(task / out.rows), row = static_cast<int>(task % out.rows);
        // The middle of a step, in nodes.
        const double from_entry = (plane + 0.5) / steps - 1;
        const double at = (sense > 0 ? first_w + from_entry : first_w + layers - 1 - from_entry) - frame.first_node[w];
        const double inside = std::clamp(at, 1.0, count[w] - 2.0);
        const int cell = std::min(static_cast<int>(inside), count[w] - 3);
        const CubicWeights weights = cubicBSpline(inside - cell);
        float value[4], slope[4];
        for (int k = 0; k < 4; ++k) {
            value[k] = static_cast<float>(weights.value[k]);
            slope[k] = inside == at ? static_cast<float>(weights.slope[k]) : 0.0f;
        }
        const float* from = index.coefficients() + static_cast<std::size_t>(row) * strides[v] +
                            static_cast<std::size_t>(cell - 1) * strides[w];
        const std::size_t sw = strides[w], su = strides[u];
        float* values = &out.value[static_cast<std::size_t>(plane) * out.plane() +
                                   static_cast<std::size_t>(row) * static_cast<std::size_t>(out.columns)];
        float* slopes = &out.slope[static_cast<std::size_t>(values - out.value.data())];
        for (int column = 0; column < out.columns; ++column, from += su) {
            const float c0 = from[0], c1 = from[sw], c2 = from[2 * sw], c3 = from[3 * sw];
            values[column] = value[0] * c0 + value[1] * c1 + value[2] * c2 + value[3] * c3;
            slopes[column] = slope[0] * c0 + slope[1] * c1 + slope[2] * c2 + slope[3] * c3;
        }
    });
}

}  // namespace photic
