// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal_mercier.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace photic {
namespace {

/// One vertical side as a flat grid of cells (along, up).
struct DomainSide {
    int axis;  // that it is across
    int at;    // its cell along that axis
    int along_axis;
    glm::ivec3 cell(int along, int up) const {
        glm::ivec3 c(0, 0, up);
        c[axis] = at, c[along_axis] = along;
        return c;
    }
};

/// Costs of a cell under the surface: |grad T| of the front as it is seen within the side, and along its vertical edge.
struct Costs {
    double side, edge;
};
Costs costsAt(const EikonalFront& front, const glm::dvec3& place, int axis) {
    const HeightPoint s = front.table().at(glm::dvec2(place));
    const double squared = 1 + s.hx * s.hx + s.hy * s.hy, across = axis == 0 ? s.hx : s.hy;
    return {std::sqrt(1 - across * across / squared), 1 / std::sqrt(squared)};
}

/// One side of the grid, marched on its own.
class SideMarch {
public:
    SideMarch(const EikonalFront& front, EikonalGrid& grid, const DomainSide& side, int last)
        : front_(front),
          g_(grid),
          side_(side),
          last_(last),
          flat_(BlockGrid::blocksFor({last + 1, grid.size.z, 1})),
          fixed_(flat_),
          arrival_(flat_.cellCount(), kUnreached),
          cost_(flat_.cellCount(), 1.0f) {}

    /// Marches it at its own costs, and freezes what is found in the grid.
    void run() {
        fixBeyond();
        for (int along = kLow; along <= last_; ++along) seedColumn(along);
        EikonalProblem problem;
        problem.grid = &flat_, problem.spacing = g_.spacing, problem.fixed = &fixed_,
        problem.order = MarchingOrder::First;
        std::vector<double> pass = arrival_;
        marchBlocks(problem, {}, pass);
        spreadCosts(pass);
        problem.slownesses = cost_;
        marchBlocks(problem, {}, arrival_);
        for (int along = kLow; along <= last_; ++along)
            for (int up = 0; up < g_.size.z; ++up) {
                const glm::ivec3 cell = side_.cell(along, up);
                if (g_.fixed.get(g_.index(cell)) || !(arrival_[at(along, up)] < kUnreached)) continue;
                g_.freeze(cell, arrival_[at(along, up)]);
            }
    }

private:
    static constexpr int kLow = EikonalGrid::kGhosts;

    std::size_t at(int along, int up) const { return static_cast<std::size_t>(flat_.cellIndex({along, up, 0})); }

    /// Cells of the flat grid that are none of the side.
    void fixBeyond() {
        for (std::size_t c = 0; c < arrival_.size(); ++c) {
            const glm::ivec3 p = flat_.cellAt(static_cast<std::int64_t>(c));
            if (p.z > 0 || p.x < kLow || p.x > last_ || p.y >= g_.size.z) fixed_.set(static_cast<std::int64_t>(c));
        }
    }

    /// What is known of a column: its cells by the surface, and the edges, straight down at their own cost.
    void seedColumn(int along) {
        bool edge_done = false;
        for (int up = g_.size.z - 1; up >= 0; --up) {
            const glm::ivec3 cell = side_.cell(along, up);
            if (!g_.fixed.get(g_.index(cell))) {
                if (along != kLow && along != last_) break;
                const Costs costs = costsAt(front_, g_.centre(cell), side_.axis);
                if (!edge_done && up + 1 < g_.size.z && arrival_[at(along, up + 1)] < kUnreached) edge_done = true;
                if (!edge_done) break;
                arrival_[at(along, up)] = arrival_[at(along, up + 1)] + costs.edge * g_.spacing;
                cost_[at(along, up)] = static_cast<float>(costs.side);
                fixed_.set(static_cast<std::int64_t>(at(along, up)));
                continue;
            }
            arrival_[at(along, up)] = g_.at(cell);
            cost_[at(along, up)] = static_cast<float>(costsAt(front_, g_.centre(cell), side_.axis).side);
            fixed_.set(static_cast<std::int64_t>(at(along, up)));
        }
    }

    /// Each cell takes the cost of the neighbour that reached it, in the order of arrival.
    void spreadCosts(const std::vector<double>& pass) {
        std::vector<std::size_t> order;
        for (int along = kLow; along <= last_; ++along)
            for (int up = 0; up < g_.size.z; ++up)
                if (!fixed_.get(static_cast<std::int64_t>(at(along, up))) && pass[at(along, up)] < kUnreached)
                    order.push_back(at(along, up));
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return pass[a] < pass[b]; });
        for (const std::size_t c : order) {
            const glm::ivec3 p = flat_.cellAt(static_cast<std::int64_t>(c));
            std::size_t from = c;
            for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
                if (p.x + dx < kLow || p.x + dx > last_ || p.y + dy < 0 || p.y + dy >= g_.size.z) continue;
                if (const std::size_t n = at(p.x + dx, p.y + dy); pass[n] < pass[from]) from = n;
            }
            cost_[c] = cost_[from];
        }
    }

    const EikonalFront& front_;
    EikonalGrid& g_;
    const DomainSide side_;
    const int last_;
    BlockGrid flat_;
    CellMask fixed_;
    std::vector<double> arrival_;
    std::vector<float> cost_;
};

}  // namespace

void seedByVertices(const EikonalFront& front, double spacing, EikonalGrid& g) {
    const HeightTable& table = front.table();
    for (int j = 0; j < g.size.y; ++j)
        for (int i = 0; i < g.size.x; ++i)
            for (int k = g.size.z - 1; k >= 0; --k) {
                const glm::dvec3 p = g.centre({i, j, k});
                const bool ghost = g.isGhost({i, j, k});
                if (!ghost && p.z < table.at(glm::dvec2(p)).h) break;
                g.freeze({i, j, k}, kUnreached);
            }
    for (int j = 0; j < g.size.y; ++j)
        for (int i = 0; i < g.size.x; ++i)
            if (g.isGhost({i, j, 0}))
                for (int k = 0; k < g.size.z; ++k) g.freeze({i, j, k}, kUnreached);

    const glm::dvec3 corner = g.centre({EikonalGrid::kGhosts, EikonalGrid::kGhosts, 0}) - 0.5 * g.spacing;
    const glm::ivec2 inner(g.size.x - 2 * EikonalGrid::kGhosts, g.size.y - 2 * EikonalGrid::kGhosts);
    const auto nx = static_cast<int>(inner.x / spacing), ny = static_cast<int>(inner.y / spacing);
    for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) {
            const glm::dvec2 xy = glm::dvec2(corner) + glm::dvec2(i, j) * spacing * g.spacing;
            const glm::dvec3 vertex(xy, table.at(xy).h);
            const glm::dvec3 index = (vertex - g.centre({0, 0, 0})) / g.spacing;
            const glm::ivec3 cell(std::clamp(static_cast<int>(std::lround(index.x)), EikonalGrid::kGhosts,
                                             EikonalGrid::kGhosts + inner.x - 1),
                                  std::clamp(static_cast<int>(std::lround(index.y)), EikonalGrid::kGhosts,
                                             EikonalGrid::kGhosts + inner.y - 1),
                                  static_cast<int>(std::lround(index.z)));
            if (cell.z < 0 || cell.z >= g.size.z) continue;
            const double distance = glm::length(vertex - g.centre(cell));
            g.freeze(cell, std::min(g.at(cell), distance));
        }
}

void costsAtSides(const EikonalFront& front, EikonalGrid& g) {
    const int low = EikonalGrid::kGhosts, high_x = g.size.x - 1 - low, high_y = g.size.y - 1 - low;
    for (const DomainSide side :
         {DomainSide{0, low, 1}, DomainSide{0, high_x, 1}, DomainSide{1, low, 0}, DomainSide{1, high_y, 0}})
        SideMarch(front, g, side, side.axis == 0 ? high_y : high_x).run();
}

}  // namespace photic
