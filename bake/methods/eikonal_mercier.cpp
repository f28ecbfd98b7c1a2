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
         {DomainSide{0, low, 1}, DomainSide{0, high_x, 1}, DomainSide{1, low, 0}, DomainSide{1, high_y, 0}}) {
        const int last = side.axis == 0 ? high_y : high_x;
        BlockGrid flat(BlockGrid::blocksFor({last + 1, g.size.z, 1}));
        CellMask fixed(flat);
        std::vector<double> arrival(flat.cellCount(), kUnreached);
        std::vector<float> cost(flat.cellCount(), 1.0f);
        const auto at = [&](int along, int up) { return static_cast<std::size_t>(flat.cellIndex({along, up, 0})); };
        // Cells of the flat grid that are none of the side.
        for (std::size_t c = 0; c < arrival.size(); ++c) {
            const glm::ivec3 p = flat.cellAt(static_cast<std::int64_t>(c));
            if (p.z > 0 || p.x < low || p.x > last || p.y >= g.size.z) fixed.set(static_cast<std::int64_t>(c));
        }
        for (int along = low; along <= last; ++along) {
            bool edge_done = false;
            for (int up = g.size.z - 1; up >= 0; --up) {
                const glm::ivec3 cell = side.cell(along, up);
                if (!g.fixed.get(g.index(cell))) {
                    // The edges: straight down at their own cost.
                    if (along != low && along != last) break;
                    const Costs costs = costsAt(front, g.centre(cell), side.axis);
                    if (!edge_done && up + 1 < g.size.z && arrival[at(along, up + 1)] < kUnreached) edge_done = true;
                    if (!edge_done) break;
                    arrival[at(along, up)] = arrival[at(along, up + 1)] + costs.edge * g.spacing;
                    cost[at(along, up)] = static_cast<float>(costs.side);
                    fixed.set(static_cast<std::int64_t>(at(along, up)));
                    continue;
                }
                arrival[at(along, up)] = g.at(cell);
                cost[at(along, up)] = static_cast<float>(costsAt(front, g.centre(cell), side.axis).side);
                fixed.set(static_cast<std::int64_t>(at(along, up)));
            }
        }
        EikonalProblem problem;
        problem.grid = &flat, problem.spacing = g.spacing, problem.fixed = &fixed, problem.order = MarchingOrder::First;
        std::vector<double> pass = arrival;
        marchBlocks(problem, {}, pass);
        // Each cell takes the cost of the neighbour that reached it, in the order of arrival.
        std::vector<std::size_t> order;
        for (int along = low; along <= last; ++along)
            for (int up = 0; up < g.size.z; ++up)
                if (!fixed.get(static_cast<std::int64_t>(at(along, up))) && pass[at(along, up)] < kUnreached)
                    order.push_back(at(along, up));
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return pass[a] < pass[b]; });
        for (const std::size_t c : order) {
            const glm::ivec3 p = flat.cellAt(static_cast<std::int64_t>(c));
            std::size_t from = c;
            for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
                if (p.x + dx < low || p.x + dx > last || p.y + dy < 0 || p.y + dy >= g.size.z) continue;
                if (const std::size_t n = at(p.x + dx, p.y + dy); pass[n] < pass[from]) from = n;
            }
            cost[c] = cost[from];
        }
        problem.slownesses = cost;
        marchBlocks(problem, {}, arrival);
        for (int along = low; along <= last; ++along)
            for (int up = 0; up < g.size.z; ++up) {
                const glm::ivec3 cell = side.cell(along, up);
                if (g.fixed.get(g.index(cell)) || !(arrival[at(along, up)] < kUnreached)) continue;
                g.freeze(cell, arrival[at(along, up)]);
            }
    }
}

}  // namespace photic
