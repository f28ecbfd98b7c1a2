// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/patch.h"

#include <algorithm>
#include <cmath>

namespace photic {

RowRange rowInside(const Patch& patch, glm::dvec2 start, double step, std::size_t count) {
    if (count == 0 || !patch.containsY(start.y)) return {};
    if (!patch.bounded()) return {0, count};

    // A guess by division, put right by the very test that at() makes.
    const auto u = [&](std::size_t i) { return start.x + step * static_cast<double>(i); };
    const double limit = static_cast<double>(count);
    auto first = static_cast<std::size_t>(std::clamp(std::ceil((patch.min.x - start.x) / step), 0.0, limit));
    auto last = static_cast<std::size_t>(std::clamp(std::floor((patch.max.x - start.x) / step) + 1, 0.0, limit));
    while (first > 0 && patch.containsX(u(first - 1))) --first;
    while (first < last && !patch.containsX(u(first))) ++first;
    while (last < count && last > 0 && patch.containsX(u(last))) ++last;
    while (last > first && !patch.containsX(u(last - 1))) --last;
    return {first, std::max(first, last)};
}

void fillBeyond(const Patch& patch, glm::dvec2 start, double step, RowRange range, SurfaceRow& out) {
    const std::size_t count = out.px.size();
    const auto fill = [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i) {
            out.px[i] = start.x + step * static_cast<double>(i), out.py[i] = start.y, out.pz[i] = patch.outside_z;
            out.nx[i] = 0, out.ny[i] = 0, out.nz[i] = 1;
        }
    };
    fill(0, range.first);
    fill(range.last, count);
}

}  // namespace photic
