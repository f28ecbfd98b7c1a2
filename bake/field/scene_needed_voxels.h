// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/field/needed_voxels.h"
#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// The voxels that the scene's `where` asks for: everything, a band around receivers, or the medium below the surface.
NeededVoxels sceneNeededVoxels(const Scene& scene, const GridFrame& frame, Monitor& monitor);

}  // namespace photic
