// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "bake/baker/bake_settings.h"
#include "bake/baker/lookup_error.h"
#include "bake/file/vdb.h"
#include "bake/report/bake_report.h"
#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// What bakeScene makes.
struct BakedScene {
    LightVolume volume;  ///< as it is written: prefiltered, with the grids that were asked for and metadata
    BakeReport report;   ///< without the seconds of what comes before and after
    /// The standard error of the mean irradiance as `irradiance` [W/m2], and the number of paths through each voxel as
    /// `path_count`; of methods that know them (Method::standard_error).
    std::optional<LightVolume> standard_error;
    MeasuredReceivers measured;  ///< where BakeChoices::measure asks for it
};

/// Bakes a scene: chooses its method, finds the voxels that are needed, refuses what does not fit the memory, runs the
/// method, and finishes the volume. The whole of `photic bake` between its scene file and its volume file.
///
/// Warnings go to `monitor` as they arise, and the report holds them too. Results are bitwise the same for any number
/// of threads.
/// @throws Error{Input} for what cannot be baked so; Error{Failed} for too much memory; Error{Cancelled}
/// Cost: bakeCost tells.
BakedScene bakeScene(const Scene& scene, Monitor& monitor, const BakeChoices& choices = {});

}  // namespace photic
