// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>

#include "bake/methods/wavefront_sweep.h"
#include "bake/paths/emission.h"

namespace photic {

/// A box in index space.
struct FrontBox {
    glm::dvec3 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
    void add(const glm::dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
};

struct FrontLaunch {
    const GridFrame& frame;
    const FrontSpace& space;
    const FrontBox& target;  ///< voxels that a front has to cover
    double spacing = 1;      ///< [voxels] between rays
    bool lit = false;        ///< its light counts before it has been in a medium
    /// Whether a place in the world is in a medium: light that enters there has been in one.
    std::function<bool(const glm::dvec3&)> in_medium{};
};

/// Where a light has to enter the space to reach the whole target: a flat box on the side that it comes from.
FrontBox entryOf(const FrontLaunch& launch, const LightSample& sample);

/// The front of a light, as it enters the space by the side that the light comes from: as wide as the target's shadow
/// there. Where a medium reaches that side, light comes into it as through a flat face, without loss.
/// @throws Error{Input} for a lamp that is not outside of that side, and for more than 2^26 rays
Front launchFront(const FrontLaunch& launch, const Light& light, const LightSample& sample);

/// Some tubes of a launched front, each as four with rays of their own between its corners'.
Front splitTubes(const FrontLaunch& launch, const LightSample& sample, const Front& front,
                 const std::vector<std::uint32_t>& which);

}  // namespace photic
