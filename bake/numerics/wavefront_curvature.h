// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>

#include "bake/numerics/block_marching.h"

namespace photic {

/// What second differences say of a front in one block; cells that were not reached hold 0.
struct FrontBlock {
    double curvature[BlockGrid::kCells];     ///< div(grad T / |grad T|) [1/m]: negative where the front converges
    double direction[3][BlockGrid::kCells];  ///< grad T / |grad T|
};

/// Curvature kappa = lap(T)/n - grad T . grad n / n^2 and direction of arrivals that solve |grad T| = n, by central
/// differences of second order; one-sided where a neighbour was not reached. With constant n = 1 this is the Laplacian
/// of [Mercier 2014, eqs. 3, 4]. Where two fronts meet, kappa is about -(jump of direction)/h: only its integral
/// converges.
///
/// @param visit  called for every block, from several threads
/// Cost: about 12 ns a cell. Differences divide rounding and seed errors by h^2: arrivals must be doubles.
void wavefrontCurvature(const EikonalProblem& problem, std::span<const double> arrival,
                        const std::function<void(int slot, const FrontBlock&)>& visit);

}  // namespace photic
