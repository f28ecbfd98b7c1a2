// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "bake/scene/scene.h"

namespace photic {

/// One way on from a specular surface.
struct SpecularBranch {
    glm::dvec3 direction{0};  ///< unit, world
    glm::dvec3 fraction{0};   ///< of the arriving power, per channel
    bool crosses = false;     ///< goes on on the other side
};

/// What becomes of light at a surface. Fractions of all branches, `untraced`, `dropped` and `absorbed` add up to 1.
struct SpecularEvent {
    std::array<SpecularBranch, 2> branches;
    int count = 0;
    double untraced = 0;     ///< the Fresnel branch that the surface's `event` leaves out (ledger: reflected)
    double dropped = 0;      ///< branches that would meet the same surface again at once (ledger: dropped)
    glm::dvec3 absorbed{0};  ///< by a metal, per channel (ledger: absorbed at surfaces)
};

/// What every method takes for one event:
/// - a branch that leaves on the wrong side of the face, or from a height field refracts upwards or reflects downwards,
///   would meet the surface a second time at once: it is dropped;
/// - total reflection goes on inside whatever `event` says but "refract", which leaves it out;
/// - a thin pane refracts nothing: both faces of it reflect, and light between them goes to and fro for ever, which
/// adds
///   up to R' = 2 R / (1 + R) (Stokes 1862);
/// - what a branch meets further on is the caller's to find.
///
/// @param ior_from, ior_to  on the side that the light comes from, and on the other (of a thin pane: between its faces)
/// @param direction  unit, of travel
/// @param normal     unit, smooth; on either side
/// @param face       unit, geometric; on the same side as `normal`; equals it for a height field
SpecularEvent specularEvent(const Surface& surface, double ior_from, double ior_to, const glm::dvec3& direction,
                            const glm::dvec3& normal, const glm::dvec3& face);

}  // namespace photic
