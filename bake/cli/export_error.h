// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/cli/json.h"
#include "bake/file/vdb.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// How far trilinear look-ups of irradiance in `exported`, rounded to half floats, are from those in `source`: at a
/// point in each kept voxel with light (all of them, or evenly spread ones of very many), and on planar receivers.
Json exportError(const LightVolume& source, const LightVolume& exported, const Scene* scene);

/// The number by which exports are compared: relative L1 on receivers, their mean, or in the volume where there are
/// none.
double meanError(const Json& error);

/// `exportError` for people.
std::string errorText(const Json& error);

}  // namespace photic::cli
