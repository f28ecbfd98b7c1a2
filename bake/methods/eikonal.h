// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/catalogue.h"

namespace photic {

enum class EikonalPreset {
    Exact,   ///< refraction by Snell's law, feet on the smooth surface
    Mercier  ///< the paper's: infinite index, vertex splats, first order, its boundary costs and dissipation
};
enum class EikonalSolver {
    Auto,        ///< foot points: every scene that the method takes allows it
    FootPoints,  ///< Hopf-Lax by Newton's method
    Marching     ///< fast marching by blocks from seeds beside the surface
};
/// What the irradiance is past the first caustic, where there are several arrivals.
enum class EikonalBeyond {
    FirstArrival,  ///< that of the first
    Dark           ///< none: the voxels are not active
};

/// [bake.eikonal]
struct EikonalOptions {
    EikonalPreset preset = EikonalPreset::Exact;
    EikonalSolver solver = EikonalSolver::Auto;
    EikonalBeyond beyond = EikonalBeyond::FirstArrival;
    int order = 2;                ///< of the differences when marching
    double vertex_spacing = 0.5;  ///< [voxels] of the splatted mesh; the paper's preset only
    double threshold = 0.5;       ///< of the depth below the surface, where dissipation begins; the paper's preset only
    double dissipation_speed =
        0.15;  ///< [voxels per voxel of depth] of the waves that dissipate; the paper's preset only
};

/// The row of the catalogue: |grad T| = n below a height field from one sun; curvature as `caustic`, direction, first
/// arrival and irradiance of the first arrival (after [Mercier 2014]; docs/eikonal.md).
Method eikonalMethod();

}  // namespace photic
