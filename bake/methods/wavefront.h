// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/graded/front_integrators.h"
#include "bake/methods/catalogue.h"

namespace photic {

/// How the samples of an index become a spline (bake/graded/spline_index.h).
enum class WavefrontSpline { Auto, Through, Plain };

/// Which light a voxel keeps that several pieces of a front pass through (bake/deposit/strongest_arrival.h).
enum class WavefrontArrivals { All, Strongest };

/// Whose simulator goes through the medium: the method's own, or the paper's (bake/methods/paper_fronts.h).
enum class WavefrontPreset { None, Paper };

/// What the paper's preset takes for the area of a patch.
enum class PatchArea {
    Corners,  ///< that between its four particles
    Jacobian  ///< the paraxial one: of the map of its middle ray, by the derivatives of its steps
};

/// [bake.wavefront]
struct WavefrontOptions {
    double spacing = 1;                                    ///< [voxels] between the rays of a front where it starts
    int steps = 1;                                         ///< of a ray, a layer
    FrontIntegrator integrator = FrontIntegrator::Planes;  ///< of rays from layer to layer
    int disc_samples = 1;                                  ///< directions on the sun's disc; 1: a point sun
    int turns = 12;  ///< times that light may change the axis along which it is followed
    WavefrontSpline spline = WavefrontSpline::Auto;
    WavefrontArrivals arrivals = WavefrontArrivals::All;
    WavefrontPreset preset = WavefrontPreset::None;
    double smooth = 0.7;                  ///< [voxels] standard deviation by which the preset blurs n
    PatchArea area = PatchArea::Corners;  ///< of the preset's patches
    double rim = 0;  ///< share of the largest difference of n^2 from the air's that counts as being in a medium
};

/// The row of the catalogue: fronts of light through media whose index varies, marched plane by plane into the kernel
/// of the beams (the method: docs/wavefront.md; Ihrke et al. 2007, made conservative).
Method wavefrontMethod();

}  // namespace photic
