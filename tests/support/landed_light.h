// SPDX-License-Identifier: Apache-2.0
// Photons counted where they land: what look-ups on receivers are held against, without any voxel.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/field/grid_frame.h"
#include "bake/file/vdb.h"
#include "bake/methods/photons.h"
#include "bake/methods/plane_light.h"
#include "bake/scene/scene.h"

namespace photic::support {

/// Light that comes to one side of a plane [W/m2, mean of the channels], texel by texel, row by row.
struct FaceLight {
    std::vector<double> mean, error;  ///< of each texel, and its standard error
};

/// Both sides of a plane: `front` is the one that its normal points to.
struct PlaneLight {
    FaceLight front, back;
};

struct LandedOptions {
    std::int64_t count = 4'000'000;  ///< photons in all
    int shifts = 16;                 ///< independent repetitions, whose spread gives the standard errors
    PhotonSampling sampling = PhotonSampling::Quasi;
    int wavelengths = 12;
};

/// Follows photons through a scene and counts the power of those that cross each texel, apart for the two sides. Planes
/// stop nothing: those that are to stop light are objects of the scene too.
std::vector<PlaneLight> landedLight(const Scene& scene, const GridFrame& frame, const std::vector<PlaneTexels>& planes,
                                    const LandedOptions& options);

/// A plane to look at: a receiver of the scene, or a card held into its light.
struct LookedAt {
    std::string name;
    PlaneTexels texels;
};

/// The planar receivers of a scene and three cards through the middle of its box, in texels of `voxels` voxels a side.
std::vector<LookedAt> planesOf(const Scene& scene, double voxels);

/// What look-ups in a volume find on one side of a plane, mean over each texel [W/m2]; NaN where nobody looks: behind
/// or within two voxels of a plane that stops light (but for the one that is looked at), of glass or of a mirror, or
/// where voxels are missing.
std::vector<double> lookedUpLight(const Scene& scene, const LightVolume& volume, const LookedAt& plane, bool front);

/// How far found light is off landed light where both are known.
struct Agreement {
    double light = 0;  ///< sum of the landed light over the texels [W/m2]
    double found = 0;  ///< of the found light
    double apart = 0;  ///< sum of |found - landed| over the sum of the landed
    double noise = 0;  ///< what `apart` would be by the photons' noise alone: sum of sqrt(2 / pi) x error
    std::int64_t texels = 0;
};
Agreement agreementOf(const std::vector<double>& found, const FaceLight& landed);

}  // namespace photic::support
