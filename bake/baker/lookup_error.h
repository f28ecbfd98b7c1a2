// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/baker/bake_settings.h"
#include "bake/file/vdb.h"
#include "bake/report/bake_report.h"
#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// A part of a planar receiver and the light that falls on it, by rays of its own.
struct ReceiverPatch {
    int columns = 0, rows = 0;
    std::vector<float> light;  ///< [W/m2] of each texel, row by row; < 0 where nobody looks: behind another plane
    std::vector<float> found;  ///< the volume's look-up there, mean over the texel
};

/// What look-ups in a volume were measured against.
struct MeasuredReceivers {
    std::vector<ReceiverError> errors;                ///< of each receiver that was measured
    std::vector<std::vector<ReceiverPatch>> patches;  ///< likewise
    std::string not_measured;                         ///< what was not, and why; empty when all of them were
    bool costs_too_much = false;                      ///< Measure::Quickly left some out that Measure::Wholly measures
    /// Of the receiver whose error is largest; 0 when nothing was measured.
    double largest() const;
};

/// Measures look-ups on the scene's flat receivers, planes and the triangles of meshes that get most light, where they
/// are seen: sum of |look-up - light| over the sum of light, on texels of `detail`, each the mean over its texel
/// (DESIGN 5; docs/accuracy.md). The light is planeIrradiance.
/// @param detail        [m]; 0: a 512th of each receiver's longer side
/// @param bake_seconds  that the bake is expected to take, of one thread
/// @throws Error{Cancelled}
MeasuredReceivers measureReceivers(const Scene& scene, const LightVolume& volume, double detail, double bake_seconds,
                                   Measure how, Monitor& monitor);

/// Error of look-ups between means over square voxels of `texels` texels a side, of which the light is known: what
/// voxels that wide would cost, but for what happens across the receiver. Mean over places of the voxels.
double simulatedError(const std::vector<ReceiverPatch>& patches, int texels);

/// The voxel size [m] at which look-ups would be off by `goal`, going by how the error of `measured` falls with
/// narrower voxels where its light is known; 0 when that is finer than the texels, or nothing was measured.
double voxelSizeFor(double goal, const MeasuredReceivers& measured, double voxel_size);

}  // namespace photic
