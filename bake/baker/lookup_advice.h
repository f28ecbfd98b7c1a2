// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/baker/bake_settings.h"
#include "bake/baker/lookup_error.h"

namespace photic {

/// "floor: look-ups are off by 14 % at 4 mm; east_wall: ..."
std::string wordsOf(const std::vector<ReceiverError>& errors);

/// The scene with other voxels, their layers in proportion. Where nobody looks at the water, only those around
/// receivers are needed then.
Scene withVoxels(const Scene& scene, double voxel_size);

/// What would halve the largest error, with what it takes: "voxels of 8 mm around the receivers (--voxel-size 0.008
/// --where receivers): about 41 MB and 0.6 s". Empty where nothing is known.
std::string adviceFor(const Scene& scene, const Method& method, const MeasuredReceivers& measured,
                      const BakeChoices& choices, Monitor& monitor);

}  // namespace photic
