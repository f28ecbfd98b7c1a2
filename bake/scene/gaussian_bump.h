// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>

#include "bake/scene/spline_grid.h"

namespace photic {

/// A Gaussian bump of water let go in a rectangular pool with reflecting walls.
struct GaussianBump {
    double height = 0.1;   ///< [m]; negative: a dip
    double radius = 0.1;   ///< standard deviation of the Gaussian [m]
    glm::dvec2 center{0};  ///< [m] from the pool's centre
    double speed = 1;      ///< of the waves [m/s]
    double damping = 0;    ///< [1/s]: amplitudes fall as exp(-damping t)
};

/// Highest number of cosine modes along a side.
constexpr int kMostBumpModes = 2048;
/// Cosine modes along a side of length `size` [m] until a Gaussian's spectrum falls below 1e-12.
int bumpModes(const GaussianBump& bump, double size);

/// Height [m] above the undisturbed level at time `time` [s] on width x height cell centres of a pool of `size` [m].
///
/// Solves h_tt + 2 damping h_t = speed^2 lap h with zero normal slope at the walls and h_t = 0 at the start, exactly in
/// time: each cosine mode is a damped oscillator of its own. At time 0 it is the Gaussian and its mirror images in the
/// walls. Cost: width * height * modes multiplications.
SampleGrid bumpHeights(const GaussianBump& bump, glm::dvec2 size, int width, int height, double time);

}  // namespace photic
