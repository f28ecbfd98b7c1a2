// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/bend_rows.h"

#include <cmath>

namespace photic {

void BendRows::measure(const RayRow* rays, int rows, double floor_w) {
    stride_ = static_cast<int>(rays[0].u.size());
    rows_ = rows;
    for (auto& bend : bend_) bend.assign(static_cast<std::size_t>(stride_ * (rows + 1)), 0.0f);
    for (int j = 0; j <= rows; ++j) {
        const RayRow& here = rays[j];
        const auto bendAlong = [&](int i, const RayRow& before, const RayRow& after, int di, double w) {
            const auto k = static_cast<std::size_t>(i), a = static_cast<std::size_t>(i - di),
                       b = static_cast<std::size_t>(i + di);
            // Where the three rays meet the plane w.
            const double u = before.u[a] + before.du[a] * (w - before.w[a]) + after.u[b] +
                             after.du[b] * (w - after.w[b]) - 2 * (here.u[k] + here.du[k] * (w - here.w[k]));
            const double v = before.v[a] + before.dv[a] * (w - before.w[a]) + after.v[b] +
                             after.dv[b] * (w - after.w[b]) - 2 * (here.v[k] + here.dv[k] * (w - here.w[k]));
            return static_cast<float>(std::max(std::fabs(u), std::fabs(v)));
        };
        for (int i = 0; i < stride_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const double w = here.dz[k] < 0 ? std::max(here.w_end[k], floor_w) : std::min(here.w_end[k], floor_w);
            // At the lattice's own rim a row has no neighbour: the next corner inside speaks for the edge.
            if (i > 0 && i + 1 < stride_) {
                bend_[0][at(i, j)] = bendAlong(i, here, here, 1, w);
                bend_[2][at(i, j)] = bendAlong(i, rays[j - 1], rays[j + 1], 1, w);
            }
            bend_[1][at(i, j)] = bendAlong(i, rays[j - 1], rays[j + 1], 0, w);
        }
    }
}

bool BendRows::endsApart(const RayRow* rays, int rows, int first, int columns, double floor_w) {
    const auto f = static_cast<std::size_t>(first);
    const double cell = std::max(std::fabs(rays[0].u[f + 1] - rays[0].u[f]), std::fabs(rays[1].v[f] - rays[0].v[f]));
    if (cell <= 1) return false;
    for (int j = 0; j <= rows; ++j) {
        const auto end = [&](const RayRow& r, std::size_t k) {
            return r.dz[k] < 0 ? std::max(r.w_end[k], floor_w) : std::min(r.w_end[k], floor_w);
        };
        for (auto k = f; k <= f + static_cast<std::size_t>(columns); ++k) {
            const double here = end(rays[j], k);
            if (k > f && std::fabs(end(rays[j], k - 1) - here) > 1) return true;
            if (j > 0 && std::fabs(end(rays[j - 1], k) - here) > 1) return true;
        }
    }
    return false;
}

double BendRows::most(int first, int columns) const {
    double most = 0;
    for (int j = 0; j <= rows_; ++j)
        for (int i = first; i <= first + columns; ++i)
            for (const auto& bend : bend_) most = std::max(most, static_cast<double>(bend[at(i, j)]));
    return most;
}

}  // namespace photic
