// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/scene/height_field.h"
#include "bake/simd/instruction_set.h"

namespace photic {

/// A plane that ends light, with what TrackEnd needs to know of it in the grid.
struct RowPlane {
    glm::dvec3 normal{0};                                ///< world, unit
    double offset = 0;                                   ///< normal . point
    int axis = 2;                                        ///< grid axis nearest to the plane's normal
    bool receives = true;                                ///< is looked up: light goes on behind it
    double overshoot_layers = 0, longest_overshoot = 0;  ///< as LightEnd::behindPlane and longestBehindPlane
};

/// What one interface does to a row of corner rays, for tubes that cross the grid's z layers.
struct RowTraceSetup {
    glm::dvec3 light_direction{0, 0, -1};
    glm::dvec3 sun_middle{0, 0, -1};  ///< what planes hide, they hide of all directions of a disc alike
    bool refract = true;
    bool traces_other_branch = false;  ///< in a history of its own: then it is not left out here
    double ior_from = 1, ior_to = 1;
    glm::dmat3 index_from_world{1.0};
    glm::dvec3 grid_origin{0};
    std::vector<RowPlane> planes;
};

/// Corner rays as arrays.
struct RayRow {
    std::vector<double> x, y, z;     ///< position, world
    std::vector<double> dx, dy, dz;  ///< unit direction, world
    std::vector<double> u, v, w;     ///< position in the grid
    std::vector<double> du, dv;      ///< slope against the grid's z
    std::vector<double> per_layer;   ///< path length per layer [m]; 0 marks a ray that needs the slow way
    std::vector<double> fraction, untraced;
    std::vector<double> hit_distance;  ///< [m]; infinity
    std::vector<double> w_end;         ///< where its deposit ends; -infinity or +infinity along its sense
    void resize(std::size_t count);
};

/// Traces a row of surface points: Snell, Fresnel, planes. The same results as PathTracer to rounding; rays that are
/// blocked, totally reflected, turned back or too slanting for z layers get per_layer = 0.
using RowTracer = void (*)(const RowTraceSetup&, const SurfaceRow&, RayRow&);
RowTracer rowTracer(InstructionSet set);

}  // namespace photic
