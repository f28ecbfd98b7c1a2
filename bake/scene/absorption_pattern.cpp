// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/absorption_pattern.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace photic {
namespace {

/// -1 to 1 at a corner of a lattice, from a finaliser of MurmurHash3 [Appleby 2011].
double valueAt(const glm::ivec3& corner, std::uint32_t seed) {
    std::uint32_t h = seed;
    for (int a = 0; a < 3; ++a) {
        h = (h ^ static_cast<std::uint32_t>(corner[a])) * 0x9e3779b1u;
        h = (h ^ h >> 16) * 0x85ebca6bu, h = (h ^ h >> 13) * 0xc2b2ae35u, h ^= h >> 16;
    }
    return 2 * static_cast<double>(h) / 4294967295.0 - 1;
}

/// Value noise: smooth between corners of a unit lattice [Perlin 1985's lattice, with values in place of slopes].
double smoothNoise(const glm::dvec3& place, std::uint32_t seed) {
    const glm::dvec3 low = glm::floor(place), t = place - low, s = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    const glm::ivec3 corner(low);
    double sum = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 step(i & 1, i >> 1 & 1, i >> 2);
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= step[a] ? s[a] : 1 - s[a];
        sum += weight * valueAt(corner + step, seed);
    }
    return sum;
}

}  // namespace

glm::dvec3 AbsorptionPattern::at(const glm::dvec3& place, const glm::dvec3& even) const {
    glm::dvec3 absorption = even;
    if (!painted.empty()) {
        const auto above =
            std::find_if(painted.begin(), painted.end(), [&](const auto& layer) { return layer.first >= place.z; });
        if (above == painted.begin() || above == painted.end()) {
            absorption = above == painted.end() ? painted.back().second : above->second;
        } else {
            const auto& below = *(above - 1);
            absorption = glm::mix(below.second, above->second, (place.z - below.first) / (above->first - below.first));
        }
    }
    if (!(noise > 0)) return absorption;
    double sum = 0, strength = 1, all = 0, size = noise_size;
    for (int octave = 0; octave < octaves; ++octave, strength *= 0.5, size *= 0.5) {
        sum += strength * smoothNoise(place / size, seed + static_cast<std::uint32_t>(octave));
        all += strength;
    }
    return absorption * (1 + noise * sum / all);
}

}  // namespace photic
