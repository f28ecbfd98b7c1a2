// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace photic {

/// Carries a density from layer to layer along the rays of a front, conservatively.
///
/// Power that crosses layers of constant depth, Q = I cos(angle), obeys dQ/ds + div(Q b) = 0 across, with s the depth
/// and b = (dx/ds, dy/ds) the slopes of the rays. Finite volumes with van Leer's limited slopes and Heun's method
/// (MUSCL, second order); what leaves one cell enters its neighbour, so the sum changes by what crosses the border
/// alone. At the border the density goes on as it is.
class AmplitudeTransport {
public:
    /// @param count_x, count_y  cells of a layer, x fastest
    AmplitudeTransport(int count_x, int count_y);

    /// From one layer to the next. Steps are divided until no ray crosses half a cell in one.
    /// @param slope_x, slope_y  of the rays, in cells a layer, at cell centres; at the layer that is left and the one
    /// reached
    void advance(std::span<double> density, std::span<const double> slope_x_from, std::span<const double> slope_y_from,
                 std::span<const double> slope_x_to, std::span<const double> slope_y_to);

private:
    void rate(std::span<const double> density, double part, std::span<double> out);

    int nx_, ny_;
    std::span<const double> from_x_, from_y_, to_x_, to_y_;
    std::vector<double> first_, second_, middle_;
};

}  // namespace photic
