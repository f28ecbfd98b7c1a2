// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_index.h"

#include <algorithm>
#include <cmath>

#include "bake/numerics/wave_calibration.h"

namespace photic {

WaveIndex::WaveIndex(const IndexVolume& volume, const WaveCells& cells, const WaveScheme& scheme,
                     const glm::dvec3& horizontal)
    : volume_(volume), cells_(cells) {
    constexpr int kSteps = 8;  // what they carry is smooth in n
    const double most = volume.largest() / volume.least();
    for (int k = 0; k <= kSteps; ++k) {
        const double slowness = 1 + (most - 1) * k / kSteps, n = slowness * volume.least();
        const glm::dvec2 across = glm::dvec2(horizontal) / n;
        const glm::dvec3 direction(across, -std::sqrt(std::max(0.0, 1 - glm::dot(across, across))));
        carried_.push_back(
            planeSums(scheme.pulse, {scheme.dt, cells.grid.spacing, scheme.order}, direction, slowness / scheme.speed)
                .flux);
    }
    for (std::size_t k = carried_.size(); k-- > 0;) carried_[k] /= carried_[0];
}

double WaveIndex::carriedAt(const glm::dvec3& world) const {
    const auto steps = static_cast<double>(carried_.size() - 1);
    const double range = volume_.largest() - volume_.least();
    const double place = range > 0 ? std::clamp((volume_.at(world) - volume_.least()) / range, 0.0, 1.0) * steps : 0.0;
    const std::size_t k = std::min(static_cast<std::size_t>(place), carried_.size() - 2);
    const double part = place - static_cast<double>(k);
    return carried_[k] * (1 - part) + carried_[k + 1] * part;
}

void WaveIndex::fillSpeed2(int block, float* speed2) const {
    const glm::ivec3 first = cells_.lowCell() + cells_.grid.place(block) * kWaveSide;
    for (int i = 0; i < kWaveCells; ++i) {
        const double s = slownessAt(cells_.world(glm::dvec3(first + glm::ivec3(i >> 6, i >> 3 & 7, i & 7))));
        speed2[i] = static_cast<float>(1 / (s * s));
    }
}

}  // namespace photic
