// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include "bake/graded/front_kernel.h"
#include "bake/graded/spline_index.h"

namespace photic {

/// How a front's rays go from the middle of a layer to that of the next.
enum class FrontIntegrator {
    Planes,      ///< drift, kick, drift: second order, one look at the index a step; the vectorised kernel
    RungeKutta,  ///< the classical one, fourth order
    Yoshida,     ///< fourth order, symplectic
    Controlled   ///< Runge-Kutta steps as long as their error allows: a millionth of a voxel each
};

/// What stands beside a FrontMarch where rays are followed one by one.
struct FrontPlaces {
    const SplineIndex* index = nullptr;
    int axes[3] = {0, 1, 2};   ///< that u, v and w lie along
    glm::ivec3 first_node{0};  ///< of the index, as the rays' voxels count
    int steps = 1;             ///< a layer; Controlled finds its own
};

/// As FrontKernel, by one of the slower integrators (bake/graded/ray_integrator.h): in double precision between layers,
/// the last of each layer's steps being repeated until it ends on the plane. To compare with.
void marchFrontBy(FrontIntegrator integrator, const FrontPlaces& places, const FrontMarch& march, FrontRays& rays,
                  std::size_t first, std::size_t count, float* rows, std::size_t stride);

}  // namespace photic
