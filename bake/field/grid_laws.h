// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/field/light_field.h"

namespace photic {

/// Net power out of the box of voxels [min, max] (inclusive) divided by the sum of absolute power through its six
/// sides; 0 without absorption. Face flux is taken in the voxels on either side of the face, averaged.
double netFluxThroughBox(const LightField& field, const glm::ivec3& min, const glm::ivec3& max);

/// Downward power [W] through each z layer of voxels: -sum of (flux . area vector), one value per layer of the frame,
/// world normal of the layer's plane. Constant for periodic or fully contained light without absorption.
std::vector<double> layerPower(const LightField& field);

/// Checks of a field, each in words with its figure: finite values, irradiance >= 0, |flux| <= irradiance, the last two
/// up to the rounding of single-precision sums, 1e-5 of the brightest voxel.
struct LawCheck {
    std::string name;
    double value = 0, limit = 0;
    bool holds = false;
};
std::vector<LawCheck> checkLaws(const LightField& field);

/// Those of checkLaws that do not hold. Cost: where all hold, one pass over the field at the speed of memory.
std::vector<LawCheck> brokenLaws(const LightField& field);

/// Light that one direction a voxel does not tell: where beams cross, what is kept is the mean of their directions,
/// shorter the more they differ. A wall along that mean is lit by beams from its side alone, and is handed none of
/// them.
struct OpposedLight {
    double share = 0;  ///< of the light, in lobes of voxels whose mean direction is shorter than 0.9
    double lost = 0;  ///< of the light there, what such a wall is not handed: beams alike and 2 a apart give sin(a) / 2
};
/// Of some two thousand leaves, spread over the field.
/// @param second  the field's second lobe, or null
OpposedLight opposedLight(const LightField& field, const LightField* second = nullptr);

}  // namespace photic
