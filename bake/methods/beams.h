// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/catalogue.h"

namespace photic {

/// What is done about the sun's disc.
enum class BeamsDisc {
    Auto,   ///< blur where one refraction at a gentle, unobstructed height field bends the disc; otherwise sample
    Off,    ///< a point sun
    Blur,   ///< one elliptical blur per layer
    Sample  ///< one bake per direction on the disc
};
enum class BeamsKernel { Edges, Scalar };
/// How density varies inside a tube.
enum class BeamsInterpolation {
    Constant,  ///< exact in energy
    Ernst      ///< the paper's interpolated areas (Ernst et al. 2005, section 3.4), sampled at voxel centres
};

/// [bake.beams]
struct BeamsOptions {
    int mesh = 0;               ///< cells a side of the launched patch; 0: see spacing
    double spacing = 0;         ///< [voxels] between corner rays; 0: adaptive
    double silhouette = 0.125;  ///< [voxels] smallest tube at a shadow's edge
    BeamsDisc disc = BeamsDisc::Auto;
    int disc_samples = 32;
    int wavelengths = 12;  ///< at which light is traced where media disperse
    BeamsKernel kernel = BeamsKernel::Edges;
    BeamsInterpolation interpolation = BeamsInterpolation::Constant;
};

/// The row of the catalogue: ray tubes between neighbouring corner rays, voxelised exactly in power (the method:
/// docs/methods.md; Ernst, Akenine-Moeller and Jensen 2005, made exact).
Method beamsMethod();

}  // namespace photic
