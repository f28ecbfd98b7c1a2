// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "bake/paths/launch_domain.h"
#include "bake/paths/path_tracer.h"
#include "bake/tubes/launch.h"

namespace photic {

/// A regular mesh over the part of a height field that light is launched through.
struct Lattice {
    glm::dvec2 origin{0}, step{0};
    int columns = 1, rows = 1;  ///< cells
    /// Its corners are those of a lattice over all of the plane, to the last bit: see layLattice.
    bool on_raster = false;
    EmissionParam param(int i, int j) const {
        return {{origin.x + step.x * i, origin.y + step.y * j, 0}, glm::dvec3(0)};
    }
};

/// Whether all rays are alike: a sun's through level water. A lamp's are not.
bool bendsNowhere(const PathTracer& tracer);

/// The lattice that the options ask for; where they leave it open, the one that costs least, refinement included.
///
/// What a map's light needs is bounded by its steepest slope, and would move all tubes when a corner of it changes. So
/// of a map it is whole blocks of cells of a lattice that begins at the grid's box: the tubes that stay are the same.
/// @throws Error{Input} for more than 1e10 cells
Lattice layLattice(const PathTracer& tracer, const LaunchDomain& domain, const LaunchOptions& options);

/// The lattice over the same part of a height field whose cells are as small as the smaller ones of two.
Lattice finerOf(const Lattice& a, const Lattice& b);

/// Blocks of a lattice, as a launch divides it, evenly spread: a tenth, at most `count`; of few, the whole.
std::vector<Lattice> someBlocks(const Lattice& lattice, int count);

}  // namespace photic
