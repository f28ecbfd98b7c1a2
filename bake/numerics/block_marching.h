// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

#include "bake/numerics/block_grid.h"

namespace photic {

/// Value of a cell that no front has reached.
inline constexpr double kUnreached = 1e60;

enum class MarchingOrder { First, Second };

/// A point that a front starts from. Near it T = r (n + grad n . d / 2) + O(r^3), d from the point, r = |d|: what is
/// singular there, in closed form.
struct PointSource {
    glm::dvec3 place{0};     ///< from the centre of cell (0, 0, 0) [m]
    double slowness = 1;     ///< n at the point
    glm::dvec3 gradient{0};  ///< of n there [1/m]

    double arrival(const glm::dvec3& d) const { return glm::length(d) * (slowness + 0.5 * glm::dot(gradient, d)); }
    /// Gradient of arrival(); d != 0.
    glm::dvec3 slope(const glm::dvec3& d) const {
        const double r = glm::length(d);
        return d * ((slowness + 0.5 * glm::dot(gradient, d)) / r) + 0.5 * r * gradient;
    }
    double laplacian(const glm::dvec3& d) const { return 2 * (slowness + glm::dot(gradient, d)) / glm::length(d); }
};

/// What |grad T| = n is solved for.
struct EikonalProblem {
    const BlockGrid* grid = nullptr;
    double spacing = 1;                 ///< between cells [m]
    double slowness = 1;                ///< n where `slownesses` is empty; > 0
    std::span<const float> slownesses;  ///< n at each cell of the grid; > 0
    MarchingOrder order = MarchingOrder::Second;
    /// Cells that keep their value: seeds, and cells outside of the domain (kUnreached).
    const CellMask* fixed = nullptr;
    /// Where the front starts from a point: T is solved for as source.arrival() + u, of which only u, whose third
    /// derivatives are bounded, is differenced (the additive factorisation of Luo and Qian 2012, with one order more of
    /// the expansion). Otherwise the source's singularity costs h log h everywhere. Cells within about three cells of
    /// it must be fixed, to source->arrival(). Cost: about twice.
    const PointSource* source = nullptr;
};

struct BlockMarchingOptions {
    double tolerance = 1e-11;  ///< [n h] changes below this don't travel on
    /// Blocks whose next change is at most this far ahead of the earliest are advanced together [cells].
    double band = 6;
    std::span<const std::uint8_t> needed_blocks;  ///< one flag a slot; marching stops once those are final. Empty: all
    std::function<void(double)> progress;  ///< called now and then with the fraction of blocks reached; may throw
};

struct BlockMarchingReport {
    std::int64_t rounds = 0;
    std::int64_t visits = 0;              ///< of blocks
    std::int64_t row_updates = 0;         ///< of rows of eight cells
    std::int64_t first_order_blocks = 0;  ///< that found no rest in second order (slowness that jumps by decades)
    bool stopped_early = false;
    bool converged = true;  ///< false when a round limit was met
};

/// Solves |grad T| = n from the fixed cells outwards, by blocks.
///
/// The upwind discretisation of fast marching (first order: Rouy and Tourin 1992; second: Sethian 1999, section 8.4)
/// has one solution, which marching finds cell by cell in the order of arrival. Here whole 8^3 blocks march, in that
/// order, and are visited again where a neighbour changes (the heap-cell method of Chacon and Vladimirsky 2012; Yang
/// 2019), so eight cells at a time go through vector registers. Blocks of one colour of a checkerboard don't touch each
/// other's cells: they run side by side, and the result is bitwise the same for any number of threads.
///
/// @param arrival  one value a cell; fixed cells are read, the others overwritten (kUnreached where nothing arrives)
/// Cost: about 100 ns a cell on one core; 8 bytes a cell beside the caller's, 1/8 for the mask and 0.1 for the queue.
BlockMarchingReport marchBlocks(const EikonalProblem& problem, const BlockMarchingOptions& options,
                                std::span<double> arrival);

}  // namespace photic
