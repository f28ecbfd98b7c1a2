// SPDX-License-Identifier: Apache-2.0
// The quick way of TubeBuilder: whole blocks of a regular mesh, straight from traced rows.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/tubes/tube_builder.h"

namespace photic {
namespace {

// Half the cross product of a tube's sides: (0,0) (1,0) (1,1) for half 0 and (0,0) (1,1) (0,1) for half 1, as in
// regularTopology.
glm::dvec3 regularArea(const RayRow* row, int column, int j, int half) {
    const RayRow &low = row[j], &high = row[j + 1], &other = half ? high : low;
    const auto k = static_cast<std::size_t>(column);
    const std::size_t m = half ? k : k + 1;
    const glm::dvec3 diagonal(high.x[k + 1] - low.x[k], high.y[k + 1] - low.y[k], high.z[k + 1] - low.z[k]);
    const glm::dvec3 side(other.x[m] - low.x[k], other.y[m] - low.y[k], other.z[m] - low.z[k]);
    return (half ? -0.5 : 0.5) * glm::cross(side, diagonal);
}

}  // namespace

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
    const double exit_w = row->dz[static_cast<std::size_t>(first)] < 0 ? frame().min.z - 0.5 : frame().max.z + 0.5;
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
        if (high[a] < frame().min[a] - 0.5 || low[a] > frame().max[a] + 0.5) return true;
    return false;
}

// The power of the block's corners: a third of each adjoining tube.
/// @param across  per corner, the cross-sections of the adjoining tubes [m2]
void TubeBuilder::countRegular(const RayRow* row, int first, int columns, int rows, const std::vector<double>& across,
                               bool culled) {
    const MediumSides& sides = optics_->sides(emission_->surfaceIndex());
    const bool down = row->dz[static_cast<std::size_t>(first)] < 0;
    const OpticalMedium& medium = optics_->medium(down ? sides.inside : sides.outside);
    std::size_t corner = 0;
    for (int j = 0; j <= rows; ++j) {
        const RayRow& r = row[j];
        for (int i = 0; i <= columns; ++i, ++corner) {
            const auto k = static_cast<std::size_t>(first + i);
            const glm::dvec3 arriving = emission_->sample().strength * (across[corner] / 3);
            arriving_ += channelMean(arriving);
            if (launch_.counts_emission) power_.emitted += channelMean(arriving);
            if (launch_.counts_event) power_.reflected += channelMean(arriving) * r.untraced[k];
            kept_ += channelMean(arriving) * r.untraced[k];
            const glm::dvec3 power = arriving * r.fraction[k];
            leaving_ += channelMean(power);
            if (culled) {
                power_.culled += channelMean(power);
                continue;
            }
            const double hit = r.hit_distance[k];
            double exit = std::numeric_limits<double>::infinity();
            if (!medium.clear() || std::isfinite(hit))
                exit = exitDistance({r.u[k], r.v[k], r.w[k]},
                                    glm::dvec3(r.du[k], r.dv[k], 1.0) * ((down ? -1.0 : 1.0) / r.per_layer[k]));
            const bool hits = std::isfinite(hit) && hit <= exit;
            double PowerLedger::*const end = hits ? &PowerLedger::received : &PowerLedger::escaped;
            if (medium.clear())
                power_.*end += channelMean(power);
            else
                countLeg(medium, power, std::min(hit, exit), end, power_);
        }
    }
}

// The corners and the tubes' constants.
/// @param areas  cross-sections of the tubes, in their order [m2]
void TubeBuilder::layRegular(const TubeBlock& block, const RayRow* row, int first, int columns, int rows,
                             const std::vector<double>& areas, TubeSet& set) {
    set.corners.resize(set.corners.size() + static_cast<std::size_t>((columns + 1) * (rows + 1)));
    set.tubes.resize(set.tubes.size() + static_cast<std::size_t>(2 * columns * rows));
    CornerRay* corner = &set.corners[block.first_corner];
    for (int j = 0; j <= rows; ++j) {
        const RayRow& r = row[j];
        for (auto k = static_cast<std::size_t>(first); k <= static_cast<std::size_t>(first + columns); ++k)
            *corner++ = {r.u[k], r.v[k], r.w[k], r.du[k], r.dv[k], std::clamp(r.w_end[k], -1e30, 1e30)};
    }
    const glm::dvec3 power_per_area = emission_->sample().strength / 3.0;
    TubeConstants* tube = &set.tubes[block.first_tube];
    const double* area = areas.data();
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            for (int half = 0; half < 2; ++half, ++tube, ++area) {
                const RayRow &low = row[j], &high = row[j + 1], &other = half ? high : low;
                const auto k = static_cast<std::size_t>(first + i);
                const std::size_t m = half ? k : k + 1;
                const double across = *area;
                const double fraction = low.fraction[k] + high.fraction[k + 1] + other.fraction[m];
                const double la = low.per_layer[k] * (1.0 / 3), lb = high.per_layer[k + 1] * (1.0 / 3),
                             lc = other.per_layer[m] * (1.0 / 3);
                for (int c = 0; c < 3; ++c) tube->power[c] = static_cast<float>(power_per_area[c] * across * fraction);
                tube->length = static_cast<float>(la + lb + lc);
                tube->travel[0] = static_cast<float>(low.dx[k] * la + high.dx[k + 1] * lb + other.dx[m] * lc);
                tube->travel[1] = static_cast<float>(low.dy[k] * la + high.dy[k + 1] * lb + other.dy[m] * lc);
                tube->travel[2] = static_cast<float>(low.dz[k] * la + high.dz[k + 1] * lb + other.dz[m] * lc);
            }
}

void TubeBuilder::addRegular(const std::shared_ptr<const BlockTopology>& topology, const RayRow* row, int first,
                             int columns, int rows) {
    const bool down = row->dz[static_cast<std::size_t>(first)] < 0;
    const RayRow& r = row[rows / 2];
    const auto middle = static_cast<std::size_t>(first + columns / 2);
    const int s = setFor(2, !down, {r.dx[middle], r.dy[middle], r.dz[middle]});
    closeBlock(s);
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    const bool culled = regularMissesBox(row, first, columns, rows);
    thread_local std::vector<double> across;  // per corner, of the adjoining tubes [m2]
    across.assign(static_cast<std::size_t>((columns + 1) * (rows + 1)), 0.0);
    thread_local std::vector<double> areas;  // of the tubes
    areas.clear();
    const auto cornerAt = [&](int i, int j) -> double& {
        return across[static_cast<std::size_t>(j * (columns + 1) + i)];
    };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            for (int half = 0; half < 2; ++half) {
                const double area = emission_->across(regularArea(row, first + i, j, half));
                areas.push_back(area);
                cornerAt(i, j) += area, cornerAt(i + 1, j + 1) += area, cornerAt(i + 1 - half, j + half) += area;
            }
    countRegular(row, first, columns, rows, across, culled);
    if (culled) return;

    const MediumSides& sides = optics_->sides(emission_->surfaceIndex());
    TubeBlock block{topology, static_cast<std::uint32_t>(set.corners.size()),
                    static_cast<std::uint32_t>(set.tubes.size()),
                    optics_->medium(down ? sides.inside : sides.outside).extinction()};
    layRegular(block, row, first, columns, rows, areas, set);
    tubes_ += 2 * std::int64_t{columns} * rows;
    set.addSlope(r.du[middle], r.dv[middle], 2.0 * columns * rows * static_cast<double>(set.tubes.back().power[0]));
    set.blocks.push_back(std::move(block));
}

}  // namespace photic
