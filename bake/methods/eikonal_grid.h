// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/methods/eikonal_front.h"
#include "bake/numerics/block_marching.h"

namespace photic {

/// Cells that a front is marched through: the voxels of a box from the surface down to the last needed layer, in blocks
/// that are the leaves of the light field. At the sides: ghost columns, whose arrivals are known from the feet on the
/// surface; where the index varies, as far as rays come from.
struct EikonalGrid {
    static constexpr int kGhosts = 2;

    /// @throws Error{Input} for a sheared grid, or voxels that are no cubes
    EikonalGrid(const NeededVoxels& needed, const EikonalFront& front, const std::string& file);

    glm::dvec3 centre(const glm::ivec3& cell) const { return frame.worldFromIndex(glm::dvec3(start + cell)); }
    bool isGhost(const glm::ivec3& cell) const {
        return slowness.empty() &&
               (cell.x < kGhosts || cell.y < kGhosts || cell.x >= size.x - kGhosts || cell.y >= size.y - kGhosts);
    }
    std::int64_t index(const glm::ivec3& cell) const { return blocks.cellIndex(cell + shift); }
    std::size_t flat(const glm::ivec3& block_cell) const {
        const glm::ivec3 c = block_cell - shift;
        return (std::size_t(c.z) * std::size_t(size.y) + std::size_t(c.y)) * std::size_t(size.x) + std::size_t(c.x);
    }
    /// The cell keeps this arrival.
    void freeze(const glm::ivec3& cell, double t) {
        const std::int64_t at = index(cell);
        fixed.set(at), arrival[std::size_t(at)] = t;
    }
    double at(const glm::ivec3& cell) const { return arrival[std::size_t(index(cell))]; }
    std::vector<std::uint8_t> neededBlocks(const NeededVoxels& needed) const;
    std::int64_t bytes() const;

    GridFrame frame;
    double spacing;
    glm::ivec3 start, size;  ///< voxel of cell (0, 0, 0), and cells along each axis
    glm::ivec3 low, shift;   ///< voxel of the blocks' first cell, a multiple of 8; start - low
    BlockGrid blocks;
    CellMask fixed;
    std::vector<double> arrival;
    std::vector<float> slowness;  ///< n at each cell; empty where it is constant

private:
    struct Box {
        glm::ivec3 start, size;
    };
    static Box boxOf(const NeededVoxels& needed, const EikonalFront& front);
};

}  // namespace photic
