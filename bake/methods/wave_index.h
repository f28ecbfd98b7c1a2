// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bake/methods/wave_release.h"
#include "bake/scene/index_volume.h"

namespace photic {

/// What the stepper sends, and how.
struct WaveScheme {
    WavePulse pulse;
    double dt = 0;
    int order = 4;     ///< of the differences
    double speed = 1;  ///< where n is least
};

/// An index n(x) as waves see it: (n / n0)^2 phi_tt = lap phi in times measured as lengths where n is least, n0.
///
/// Flux is -phi_t grad phi, and a single arrival's irradiance n / n0 phi_t^2. The scheme conserves flux with its own
/// differences (half the derivative of the second difference's symbol is the first difference's), so what a plane wave
/// carries for its phi_t^2 is known at every n from planeSums().
class WaveIndex {
public:
    /// @param horizontal  x and y: index times direction of the light across flat water, which no layer changes
    WaveIndex(const IndexVolume& volume, const WaveCells& cells, const WaveScheme& scheme,
              const glm::dvec3& horizontal);

    double at(const glm::dvec3& world) const { return volume_.at(world); }
    /// n / n0
    double slownessAt(const glm::dvec3& world) const { return volume_.at(world) / volume_.least(); }
    /// Irradiance for the same sum of phi_t^2, over that at n0: n / n0 in the limit of fine cells.
    double carriedAt(const glm::dvec3& world) const;
    /// (n0 / n)^2 in the cells of a block.
    void fillSpeed2(int block, float* speed2) const;

private:
    const IndexVolume& volume_;
    const WaveCells& cells_;
    std::vector<double> carried_;  // from slowness 1 to the largest
};

}  // namespace photic
