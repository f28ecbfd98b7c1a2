// SPDX-License-Identifier: Apache-2.0
// The quick way of TubeBuilder: whole blocks of a regular mesh, straight from traced rows.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
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

void TubeBuilder::countRegular(double arriving, double fraction, double untraced, double hit_distance,
                               double exit_distance, bool culled) {
    if (light_.counts_emission) power_.emitted += arriving, power_.reflected += arriving * untraced;
    const double power = arriving * fraction;
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

// Derivatives along the lattice by central differences: exact enough for a slope, which only moves light inside a tube.
void TubeBuilder::addSpreads(const RayRow* row, int first, int columns, int rows, TubeSet& set) const {
    const int last = static_cast<int>(row[0].u.size()) - 1;
    const glm::dvec3 d = light_.direction;
    for (int j = 0; j <= rows; ++j) {
        const RayRow &below = row[j - 1], &here = row[j], &above = row[j + 1];
        for (int i = first; i <= first + columns; ++i) {
            const auto k = static_cast<std::size_t>(i), a = static_cast<std::size_t>(std::max(i - 1, 0)),
                       b = static_cast<std::size_t>(std::min(i + 1, last));
            CornerSpread& spread = set.spreads.emplace_back();
            if (here.per_layer[a] <= 0 || here.per_layer[b] <= 0 || below.per_layer[k] <= 0 || above.per_layer[k] <= 0)
                continue;
            const double s = 1.0 / static_cast<double>(b - a), t = 0.5;
            const auto along = [&](const std::vector<double> RayRow::*m) { return ((here.*m)[b] - (here.*m)[a]) * s; };
            const auto across = [&](const std::vector<double> RayRow::*m) {
                return ((above.*m)[k] - (below.*m)[k]) * t;
            };
            // Neighbours start at other heights: bring them to this ray's own along their slope.
            const double w_a = along(&RayRow::w), w_c = across(&RayRow::w), du = here.du[k], dv = here.dv[k];
            const double ua = along(&RayRow::u) - du * w_a, va = along(&RayRow::v) - dv * w_a;
            const double uc = across(&RayRow::u) - du * w_c, vc = across(&RayRow::v) - dv * w_c;
            const double dua = along(&RayRow::du), dva = along(&RayRow::dv), duc = across(&RayRow::du),
                         dvc = across(&RayRow::dv);
            const glm::dvec3 pa(along(&RayRow::x), along(&RayRow::y), along(&RayRow::z));
            const glm::dvec3 pc(across(&RayRow::x), across(&RayRow::y), across(&RayRow::z));
            spread.step[0][0] = static_cast<float>(ua), spread.step[0][1] = static_cast<float>(va);
            spread.step[1][0] = static_cast<float>(uc), spread.step[1][1] = static_cast<float>(vc);
            spread.step_per_layer[0][0] = static_cast<float>(dua),
            spread.step_per_layer[0][1] = static_cast<float>(dva);
            spread.step_per_layer[1][0] = static_cast<float>(duc),
            spread.step_per_layer[1][1] = static_cast<float>(dvc);
            spread.column = static_cast<float>(i - first), spread.row = static_cast<float>(j);
            spread.power = static_cast<float>(here.fraction[k] * std::fabs(glm::dot(glm::cross(pa, pc), d)));
            spread.length = static_cast<float>(here.per_layer[k]);
            spread.travel[0] = static_cast<float>(here.dx[k] * here.per_layer[k]);
            spread.travel[1] = static_cast<float>(here.dy[k] * here.per_layer[k]);
            spread.travel[2] = static_cast<float>(here.dz[k] * here.per_layer[k]);
        }
    }
}

void TubeBuilder::addRegular(const std::shared_ptr<const BlockTopology>& topology, const RayRow* row, int first,
                             int columns, int rows) {
    const int s = row->dz[static_cast<std::size_t>(first)] < 0 ? 4 : 5;
    closeBlock(s);
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    const bool culled = regularMissesBox(row, first, columns, rows);
    const double mean_irradiance = (light_.irradiance.x + light_.irradiance.y + light_.irradiance.z) / 3;
    const int stride = columns + 1;

    TubeBlock block{topology, static_cast<std::uint32_t>(set.corners.size()),
                    static_cast<std::uint32_t>(set.tubes.size())};
    double across_corner[256] = {};  // a third of the adjoining tubes' cross-sections [m2]
    const auto cornerAt = [&](int i, int j) { return static_cast<std::size_t>(j * stride + i); };
    if (!culled) {
        set.corners.resize(set.corners.size() + static_cast<std::size_t>(stride * (rows + 1)));
        set.tubes.resize(set.tubes.size() + static_cast<std::size_t>(2 * columns * rows));
        if (light_.density == TubeDensity::Linear) addSpreads(row, first, columns, rows, set);
        CornerRay* corner = &set.corners[block.first_corner];
        for (int j = 0; j <= rows; ++j) {
            const RayRow& r = row[j];
            for (auto k = static_cast<std::size_t>(first); k <= static_cast<std::size_t>(first + columns); ++k)
                *corner++ = {r.u[k],  r.v[k],  r.w[k],
                             r.du[k], r.dv[k], static_cast<float>(std::clamp(r.w_end[k], -1e30, 1e30))};
        }
    }
    const glm::dvec3 d = light_.direction;
    const glm::dvec3 power_per_area = light_.irradiance / 3.0;
    TubeConstants* tube = culled ? nullptr : &set.tubes[block.first_tube];
    for (int j = 0; j < rows; ++j) {
        const RayRow &low = row[j], &high = row[j + 1];
        for (int i = 0; i < columns; ++i) {
            // (0,0) (1,0) (1,1) and (0,0) (1,1) (0,1), as in regularTopology
            const auto k = static_cast<std::size_t>(first + i);
            const glm::dvec3 diagonal(high.x[k + 1] - low.x[k], high.y[k + 1] - low.y[k], high.z[k + 1] - low.z[k]);
            for (int half = 0; half < 2; ++half) {
                const RayRow& other = half ? high : low;
                const std::size_t m = half ? k : k + 1;
                const glm::dvec3 side(other.x[m] - low.x[k], other.y[m] - low.y[k], other.z[m] - low.z[k]);
                const double nx = side.y * diagonal.z - side.z * diagonal.y,
                             ny = side.z * diagonal.x - side.x * diagonal.z,
                             nz = side.x * diagonal.y - side.y * diagonal.x;
                const double facing = 0.5 * (half ? 1.0 : -1.0) * (nx * d.x + ny * d.y + nz * d.z);
                const double across = std::max(0.0, facing);
                across_corner[cornerAt(i, j)] += across, across_corner[cornerAt(i + 1, j + 1)] += across;
                across_corner[half ? cornerAt(i, j + 1) : cornerAt(i + 1, j)] += across;
                if (culled) continue;
                const double fraction = low.fraction[k] + high.fraction[k + 1] + other.fraction[m];
                const double la = low.per_layer[k] * (1.0 / 3), lb = high.per_layer[k + 1] * (1.0 / 3),
                             lc = other.per_layer[m] * (1.0 / 3);
                for (int c = 0; c < 3; ++c) tube->power[c] = static_cast<float>(power_per_area[c] * across * fraction);
                tube->length = static_cast<float>(la + lb + lc);
                tube->travel[0] = static_cast<float>(low.dx[k] * la + high.dx[k + 1] * lb + other.dx[m] * lc);
                tube->travel[1] = static_cast<float>(low.dy[k] * la + high.dy[k + 1] * lb + other.dy[m] * lc);
                tube->travel[2] = static_cast<float>(low.dz[k] * la + high.dz[k + 1] * lb + other.dz[m] * lc);
                ++tube;
            }
        }
    }
    for (int j = 0; j <= rows; ++j) {
        const RayRow& r = row[j];
        for (int i = 0; i <= columns; ++i) {
            const auto k = static_cast<std::size_t>(first + i);
            double exit = 0;
            if (extinction_ != glm::dvec3(0) && !culled)
                exit = exitDistance({r.u[k], r.v[k], r.w[k]},
                                    glm::dvec3(r.du[k], r.dv[k], 1.0) * ((r.dz[k] < 0 ? -1.0 : 1.0) / r.per_layer[k]));
            countRegular(across_corner[cornerAt(i, j)] * mean_irradiance / 3, r.fraction[k], r.untraced[k],
                         r.hit_distance[k], exit, culled);
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
