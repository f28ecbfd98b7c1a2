// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/mat2x2.hpp>
#include <vector>

#include "bake/field/light_field.h"

namespace photic {

/// The image of the sun's disc in one layer of voxels: disc_from_unit * (unit disc), in voxels of x and y, evenly
/// bright.
struct LayerKernel {
    glm::dmat2 disc_from_unit{0.0};
};

/// What a voxel that is outside the frame, or that nobody needed, is taken to hold.
enum class BeyondNeeded {
    Dark,  ///< nothing: light that leaves is gone and none comes back
    Alike  ///< the mean of the known voxels under the disc: even light stays even up to the border; sums change there
};

/// Convolves every z layer, all channels, with an elliptical disc that varies from layer to layer: the sun's disc for
/// light that was traced from the disc's middle, exact where one refraction at a near-flat surface bent it.
///
/// Weights are the share of each voxel in the disc, which is first widened or narrowed along x and y until the weights'
/// own second moments are the disc's (shares alone move light to the middles of voxels: an error of first order for
/// discs near a voxel's size). They are never negative, add up to 1 and are the same on both sides. Layers whose disc
/// reaches less than 0.02 voxels are left alone. Light is kept within the layer; with `Dark` what crosses the border of
/// the needed voxels is lost, as it is known nowhere, and neighbours that are not needed count as dark: where only a
/// band is needed, it must be wider than the disc by the voxels that are to be right.
///
/// @param kernel_of_layer  called once for every layer index of the frame, from any thread
/// @return sum of irradiance after, divided by that before, minus 1; 0 for a dark field
double blurLayers(LightField& field, const std::function<LayerKernel(int k)>& kernel_of_layer,
                  BeyondNeeded beyond = BeyondNeeded::Dark);

/// The weights that blurLayers uses: (2 radius + 1)^2, rows of x, for offsets y, x from -radius to radius.
struct DiscStencil {
    int radius = 0;  ///< 0: the layer is left alone
    std::vector<double> weights{1.0};
    double at(int dx, int dy) const {
        if (dx < -radius || dx > radius || dy < -radius || dy > radius) return 0;
        return weights[static_cast<std::size_t>((dx + radius) * (2 * radius + 1) + dy + radius)];
    }
};
/// @throws Error{Input} when the disc reaches more than 64 voxels
DiscStencil discStencil(const LayerKernel& kernel);

}  // namespace photic
