// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <vector>

#include "bake/numerics/wave_stepper.h"

namespace photic::wave_test {

/// Block and cell of a cell of the box.
struct Place {
    int block = 0, cell = 0;
};
inline Place placeOf(const WaveGrid& grid, const glm::ivec3& c) {
    return {grid.index(c >> 3), (c.x & 7) << 6 | (c.y & 7) << 3 | (c.z & 7)};
}

/// A smooth bump at rest, of radius `radius` cells about `middle`.
inline WaveSource bumpAt(const WaveGrid& grid, const glm::dvec3& middle, double radius) {
    WaveSource source;
    source.pulse = WavePulse(radius * grid.spacing.x);
    const glm::ivec3 size = grid.blocks * kWaveSide;
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y)
            for (int z = 0; z < size.z; ++z) {
                const double r = glm::length(glm::dvec3(x, y, z) - middle) / radius;
                if (r > 5) continue;
                const Place p = placeOf(grid, {x, y, z});
                source.start.push_back(
                    {p.block, static_cast<std::uint16_t>(p.cell), static_cast<float>(std::exp(-0.5 * r * r))});
            }
    return source;
}

/// A plane pulse that runs along `direction` (z component below 0), driven in the three highest layers of the box:
/// arrival 0 at the middle of the top.
inline WaveSource planeFromTop(const WaveGrid& grid, const glm::dvec3& direction, const WavePulse& pulse) {
    WaveSource source;
    source.pulse = pulse;
    const glm::ivec3 size = grid.blocks * kWaveSide;
    const glm::dvec3 middle = 0.5 * glm::dvec3(size.x, size.y, 2.0 * size.z);
    std::map<int, WaveHeld> held;
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y)
            for (int z = size.z - 3; z < size.z; ++z) {
                const Place p = placeOf(grid, {x, y, z});
                const glm::dvec3 from = (glm::dvec3(x, y, z) - middle) * grid.spacing;
                source.driven.push_back({p.block, static_cast<std::uint16_t>(p.cell), 1.0f, glm::dot(from, direction)});
                WaveHeld& h = held[p.block];
                h.block = p.block;
                h.cells[static_cast<std::size_t>(p.cell >> 6)] |= std::uint64_t{1} << (p.cell & 63);
            }
    for (const auto& [block, h] : held) source.held.push_back(h);
    return source;
}

inline WaveStepper::Sink nowhere() {
    return [](int, const float*) {};
}

}  // namespace photic::wave_test
