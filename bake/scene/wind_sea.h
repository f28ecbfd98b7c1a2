// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "bake/scene/spline_grid.h"

namespace photic {

/// A sea raised by a steady wind, periodic over its patch.
struct WindSea {
    double wind_speed = 5;          ///< at 10 m height [m/s]
    double fetch = 10000;           ///< length of water that the wind has blown over [m]
    glm::dvec2 direction{1, 0};     ///< unit, that the wind blows towards
    double peak_enhancement = 3.3;  ///< JONSWAP's gamma
    double spreading = 8;           ///< s of cos^2s(angle / 2)
    std::uint64_t seed = 1;
    double choppiness = 0;           ///< horizontal over vertical displacement of each harmonic; 0: none
    double shortest_wavelength = 0;  ///< [m]; shorter waves are left out
    double period = 0;               ///< [s] after which it repeats; 0: never
    double gravity = 9.81;           ///< [m/s2]
};

/// JONSWAP energy spectrum [m2 s] at angular frequency `omega` [rad/s]: K. Hasselmann et al., 1973.
double jonswap(const WindSea& sea, double omega);
/// Angular frequency of its peak [rad/s].
double peakFrequency(const WindSea& sea);
/// Its significant wave height, 4 sqrt(integral of the spectrum up to the shortest wavelength) [m].
double significantHeight(const WindSea& sea);

/// Samples of the sea at one time: heights and, with choppiness, displacement along x and y [m].
struct SeaSamples {
    SampleGrid heights;
    std::vector<SampleGrid> displacement;  ///< two, or none
    double variance = 0;                   ///< sum of amplitude^2 / 2 over the harmonics [m2]
};

/// The sum of all harmonics that fit the patch `size` [m] a whole number of times, at cell centres of width x height
/// cells, with amplitudes from the spectrum and cos^2s spreading, phases from an integer hash of (seed, harmonic) and
/// deep-water dispersion omega^2 = g k. The same seed gives the same sea on every machine and at every resolution.
/// Directions of x and y count from the patch's centre.
SeaSamples seaSamples(const WindSea& sea, glm::dvec2 size, int width, int height, double time);

}  // namespace photic
