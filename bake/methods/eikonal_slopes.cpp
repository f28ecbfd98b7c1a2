// SPDX-License-Identifier: Apache-2.0
// Compiled for wide vectors (CMakeLists.txt).
#include "bake/methods/eikonal_slopes.h"

#include <algorithm>
#include <cmath>

#include "bake/scene/vector_clones.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// Difference of the arrivals beside a cell, per cell: central, one-sided where one is not reached, 0 where none is.
inline double difference(double low, double here, double high) {
    const double up = high < kUnreached ? high - here : 0.0, down = low < kUnreached ? here - low : 0.0;
    const bool both = high < kUnreached && low < kUnreached;
    return (up + down) * (both ? 0.5 : 1.0);
}

PHOTIC_VECTOR_CLONES
void rowSlopes(int count, const double* __restrict here, const double* __restrict south, const double* __restrict north,
               const double* __restrict below, const double* __restrict above, double* __restrict slope_x,
               double* __restrict slope_y, double* __restrict fall) {
    for (int i = 0; i < count; ++i) {
        const double t = here[i];
        const double x = difference(here[i - 1], t, here[i + 1]), y = difference(south[i], t, north[i]),
                     z = difference(below[i], t, above[i]);
        const double length = std::sqrt(x * x + y * y + z * z);
        const bool known = t < kUnreached && length > 0;
        const double inverse = known ? 1 / length : 0.0;
        const double down = known ? -z * inverse : 1.0, least = down > 0.1 ? down : 0.1;
        slope_x[i] = x * inverse / least, slope_y[i] = y * inverse / least, fall[i] = least;
    }
}

}  // namespace

RaySlopes::RaySlopes(const EikonalGrid& grid) : grid_(grid), pitch_(static_cast<std::size_t>(grid.size.x) + 2) {
    for (auto& layer : layers_) layer.assign(pitch_ * (static_cast<std::size_t>(grid.size.y) + 2), kUnreached);
    std::fill_n(held_, 3, -9);
}

void RaySlopes::fill(int z, std::vector<double>& out) const {
    const EikonalGrid& g = grid_;
    if (z < 0 || z >= g.size.z) {
        std::fill(out.begin(), out.end(), kUnreached);
        return;
    }
    parallelFor(g.size.y, [&](std::int64_t j) {
        double* to = &out[(static_cast<std::size_t>(j) + 1) * pitch_ + 1];
        for (int i = 0; i < g.size.x;) {
            const glm::ivec3 cell = glm::ivec3(i, static_cast<int>(j), z);
            const int run = std::min(8 - ((cell.x + g.shift.x) & 7), g.size.x - i);
            std::copy_n(&g.arrival[static_cast<std::size_t>(g.index(cell))], run, to + i);
            i += run;
        }
    });
}

const double* RaySlopes::rows(int z) {
    const int at = (z % 3 + 3) % 3;
    if (held_[at] != z) fill(z, layers_[at]), held_[at] = z;
    return layers_[at].data() + pitch_ + 1;
}

void RaySlopes::layer(int z, std::vector<double>& slope_x, std::vector<double>& slope_y, std::vector<double>& fall) {
    const double *above = rows(z + 1), *here = rows(z), *below = rows(z - 1);
    parallelFor(grid_.size.y, [&](std::int64_t j) {
        const std::size_t row = static_cast<std::size_t>(j) * pitch_,
                          at = static_cast<std::size_t>(j) * static_cast<std::size_t>(grid_.size.x);
        rowSlopes(grid_.size.x, here + row, here + row - pitch_, here + row + pitch_, below + row, above + row,
                  &slope_x[at], &slope_y[at], &fall[at]);
    });
}

}  // namespace photic
