// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <vector>

namespace photic {

/// How much the edges of a launched lattice bend: second differences of the places where neighbouring rays cross a
/// plane, at the worst place on their way through the grid, in voxels, as beams are judged by. Tubes have straight
/// edges, and the middle of an edge is off by an eighth of it. And how long the edges are at most: where a lamp's
/// strength changes along one, a tube is wrong by a part of that.
struct FrontBends {
    /// The other end of an edge from a ray at (i, j): along rows, across them, along the cells' diagonals.
    static constexpr int kWays = 3;
    static constexpr int kWay[kWays][2] = {{1, 0}, {0, 1}, {1, 1}};

    /// Of an edge [voxels].
    struct Edge {
        float bend = 0, length = 0;
    };

    explicit FrontBends(const glm::ivec2& lattice_cells)
        : cells(lattice_cells), edges(static_cast<std::size_t>(kWays * (cells.x + 1) * (cells.y + 1))) {}
    std::size_t at(int i, int j, int way) const {
        return static_cast<std::size_t>(kWays * (j * (cells.x + 1) + i) + way);
    }
    /// Those of a lattice of every second ray, taken for the whole lattice's: an edge that is half as long bends a
    /// quarter as much.
    FrontBends ofTwiceTheRays() const;

    glm::ivec2 cells;
    std::vector<Edge> edges;  ///< per ray and way
};

}  // namespace photic
