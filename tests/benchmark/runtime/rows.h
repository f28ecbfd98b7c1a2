// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "photic/runtime_gl.h"
#include "tests/benchmark/table.h"
#include "tests/runtime/scene_view.h"

namespace photic::benchmark {

/// How much is done.
struct RuntimeEffort {
    double voxel = 1.0 / 128;  ///< [m], of a pool of a cubic metre
    std::size_t samples = 1000000;
    int width = 1920, height = 1080;
    int repeats = 3;
};

/// What all rows are measured on.
struct RuntimeStage {
    const runtime::GpuContext& context;
    const RuntimeEffort& effort;
    runtime::Volume volume;
    runtime::Volume two_levels;  ///< the same light in three quarters of the memory
    runtime::Volume blocks;      ///< the same as BC6H
    test::DrawnView& view;       ///< of the pool's floor and wall, from above the water
    test::DrawnView& square;     ///< the same in fewer pixels, as wide as high
};

/// Time of `work`, which issues GL commands, up to their end [ms]. Short work is issued many times before the wait, as
/// frames are, so that neither the wait nor the clock is what is measured.
double milliseconds(const RuntimeStage& stage, const std::function<void()>& work);

/// Least time of a few runs [ms].
double leastMilliseconds(const RuntimeStage& stage, const std::function<void()>& work);

/// Look-ups by layout, random and coherent; memory of each.
Table lookUps(const RuntimeStage& stage);

/// Receivers and media lit by the volume.
void addVolumePasses(const RuntimeStage& stage, Table& passes);

/// The same receivers and water lit without a bake: the paper's look-up and god rays, caustic maps, warped volumes.
void addWaterPasses(const RuntimeStage& stage, Table& passes);

/// Baked light beside the paper's passes: turn by turn, so that what else the machine does strikes both alike.
Table sideBySide(const RuntimeStage& stage);

/// A bake each frame on the GPU, by voxels, mesh and sun: the GPU's time, and the processor's to ask for it.
Table liveBakes(const RuntimeStage& stage);

/// From a volume in memory to textures, by layout.
Table uploads(const RuntimeStage& stage);

/// Baked, mapped and looked-up light on a floor whose light is known.
Table floorAccuracy(const RuntimeStage& stage);

}  // namespace photic::benchmark
