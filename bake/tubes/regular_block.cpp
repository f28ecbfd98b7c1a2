// SPDX-License-Identifier: Apache-2.0
// The quick way of TubeBuilder: whole blocks of a regular mesh, straight from traced rows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/tubes/tube_builder.h"

namespace photic {

std::shared_ptr<const BlockTopology> regularTopology(int columns, int rows) {
    std::vector<BlockTopology::Triangle> triangles;
    const auto at = [&](int i, int j) { return static_cast<std::uint8_t>(j * (columns + 1) + i); };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            triangles.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}});
            triangles.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
        }
    return BlockTopology::fromTriangles((columns + 1) * (rows + 1), std::move(triangles));
}

bool TubeBuilder::regularMissesBox(const RayRow* row, int first, int columns, int rows) const {
    const double exit_w = row->dz[static_cast<std::size_t>(first)] < 0 ? frame_.min.z - 0.5 : frame_.max.z + 0.5;
    const double huge = std::numeric_limits<double>::infinity();
    double low[3] = {huge, huge, huge}, high[3] = {-huge, -huge, -huge};
    for (int j = 0; j <= rows; ++j) {
        const RayRow& r = row[j];
        for (int i = first; i <= first + columns; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const double dw = exit_w - r.w[k], u = r.u[k] + r.du[k] * dw, v = r.v[k] + r.dv[k] * dw;
            low[0] = std::min({low[0], r.u[k], u}), high[0] = std::max({high[0], r.u[k], u});
            low[1] = std::min({low[1], r.v[k], v}), high[1] = std::max({high[1], r.v[k], v});
            low[2] = std::min({low[2], r.w[k], exit_w}), high[2] = std::max({high[2], r.w[k], exit_w});
        }
    }
    for (int a = 0; a < 3; ++a)
        if (high[a] < frame_.min[a] - 0.5 || low[a] > frame_.max[a] + 0.5) return true;
    return false;
}

void TubeBuilder::countRegular(double third, double fraction, double untraced, double hit_distance, double exit_distance, bool culled) {
    if (light_.counts_emission) power_.emitted += third, power_.reflected += third * untraced;
    const double power = third * fraction;
    if (culled) {
        power_.culled += power;
        return;
    }
    double left = power;
    if (extinction_ != glm::dvec3(0)) {
        const double length = std::min(hit_distance, std::max(0.0, exit_distance));
        left = 0;
        for (int k = 0; k < 3; ++k) {
            // The channels of coloured light differ: each has its own share of the mean.
            const double mean = (light_.irradiance.x + light_.irradiance.y + light_.irradiance.z) / 3;
            const double channel = power / 3 * light_.irradiance[k] / mean;
            const double kept = channel * std::exp(-extinction_[k] * length);
            left += kept;
            if (extinction_[k] <= 0) continue;
            power_.absorbed_medium += (channel - kept) * light_.absorption[k] / extinction_[k];
            power_.scattered += (channel - kept) * light_.scattering[k] / extinction_[k];
        }
    }
    (std::isfinite(hit_distance) ? power_.received : power_.escaped) += left;
}

void TubeBuilder::addRegular(const std::shared_ptr<const BlockTopology>& topology, const RayRow* row, int first, int columns, int rows) {
    TubeSet& set = sets_[row->dz[static_cast<std::size_t>(first)] < 0 ? 4 : 5];
    const bool culled = regularMissesBox(row, first, columns, rows);
    const bool attenuated = extinction_ != glm::dvec3(0);
    const double mean_irradiance = (light_.irradiance.x + light_.irradiance.y + light_.irradiance.z) / 3;

    TubeBlock block{topology, static_cast<std::uint32_t>(set.corners.size()), static_cast<std::uint32_t>(set.tubes.size())};
    double exits[256];
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const RayRow& r = row[j];
            const auto k = static_cast<std::size_t>(first + i);
            if (!culled) {
                const double end = std::clamp(r.w_end[k], -1e30, 1e30);
                set.corners.push_back({r.u[k], r.v[k], r.w[k], r.du[k], r.dv[k], static_cast<float>(end)});
            }
            const double sense = r.dz[k] < 0 ? -1.0 : 1.0;
            exits[j * (columns + 1) + i] =
                attenuated ? exitDistance({r.u[k], r.v[k], r.w[k]}, glm::dvec3(r.du[k], r.dv[k], 1.0) * (sense / r.per_layer[k])) : 0.0;
        }

    const glm::dvec3 d = light_.direction;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            for (int half = 0; half < 2; ++half) {
                // (0,0) (1,0) (1,1) and (0,0) (1,1) (0,1), as in regularTopology
                const int ci[3] = {i, i + 1, half ? i : i + 1}, cj[3] = {j, half ? j + 1 : j, j + 1};
                glm::dvec3 p[3];
                double fraction = 0, untraced = 0, length = 0;
                glm::dvec3 travel(0);
                for (int c = 0; c < 3; ++c) {
                    const RayRow& r = row[cj[c]];
                    const auto k = static_cast<std::size_t>(first + ci[c]);
                    p[c] = {r.x[k], r.y[k], r.z[k]};
                    fraction += r.fraction[k], untraced += r.untraced[k], length += r.per_layer[k];
                    travel += glm::dvec3(r.dx[k], r.dy[k], r.dz[k]) * r.per_layer[k];
                }
                const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
                const glm::dvec3 area(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
                const double across = std::max(0.0, -0.5 * (area.x * d.x + area.y * d.y + area.z * d.z));
                const double third = across * mean_irradiance / 3;
                for (int c = 0; c < 3; ++c) {
                    const RayRow& r = row[cj[c]];
                    const auto k = static_cast<std::size_t>(first + ci[c]);
                    countRegular(third, r.fraction[k], r.untraced[k], r.hit_distance[k], exits[cj[c] * (columns + 1) + ci[c]], culled);
                }
                if (culled) continue;
                TubeConstants tube;
                for (int k = 0; k < 3; ++k) {
                    tube.power[k] = static_cast<float>(light_.irradiance[k] * across * fraction / 3);
                    tube.travel[k] = static_cast<float>(travel[k] / 3);
                }
                tube.length = static_cast<float>(length / 3);
                set.tubes.push_back(tube);
            }
        }
    }
    if (culled) return;
    tubes_ += 2 * std::int64_t{columns} * rows;
    const RayRow& r = row[rows / 2];
    const auto middle = static_cast<std::size_t>(first + columns / 2);
    const double weight = static_cast<double>(set.tubes.back().power[0]);
    set.slope_power += weight, set.slope_u_power += weight * r.du[middle], set.slope_v_power += weight * r.dv[middle];
    set.blocks.push_back(std::move(block));
}

}  // namespace photic
