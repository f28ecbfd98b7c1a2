// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/file/vdb.h"
#include "bake/image/image.h"
#include "bake/scene/scene.h"

namespace photic {

/// A rectangle in the world that a picture is taken of: texel (x, y), top row first, is centred at
/// origin + (x + 1/2) / width * across + (1 - (y + 1/2) / height) * up.
struct PictureFrame {
    glm::dvec3 origin{0}, across{0}, up{0};  ///< [m]
    glm::dvec3 normal{0, 0, 1};              ///< unit, towards the light's side
    int width = 512, height = 512;
};

/// Irradiance on the receiver rectangle, looked up trilinearly in the volume:
/// E_c = irradiance_c * max(0, -n . direction) [W/m2]. 1 or 3 channels.
Image receiverPicture(const LightVolume& volume, const PictureFrame& frame);

/// One layer of voxels, unfiltered: fluence rate [W/m2], one pixel a voxel. axis 0..2, layer in index units.
/// x runs to the right and y up; z up where z is not the axis.
Image slicePicture(const LightVolume& volume, int axis, int layer);

/// Mean of the fluence rate along an axis over the frame's whole length, dark voxels included [W/m2]: an x-ray.
Image xrayPicture(const LightVolume& volume, int axis);

/// Irradiance on the receiver `name` [W/m2]: of a plane within the domain, upright; of a mesh as seen straight from
/// above, or from below where the scene's light comes from there, north (+y) up, 0 beside it.
/// @param resolution  texels of the longer side
/// @throws Error{Input} when `name` is no receiver (lists those that are), or lies outside the domain
Image receiverPicture(const LightVolume& volume, const Scene& scene, const std::string& name, int resolution);

/// Names of all receivers, movable ones included, in the scene's order.
std::vector<std::string> receiverNames(const Scene& scene);

/// Names of the planar receivers, movable ones included, in the scene's order.
std::vector<std::string> planarReceivers(const Scene& scene);

/// The rectangle of a planar receiver within the domain, upright as seen from its lit side: up is +y on floors and
/// ceilings, the sky on walls. Texels are square to rounding; `resolution` is that of the longer side.
/// @throws Error{Input} when `name` is no planar receiver (lists those that are)
PictureFrame receiverFrame(const Scene& scene, const std::string& name, int resolution);

}  // namespace photic
