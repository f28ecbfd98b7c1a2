// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>

#include "bake/report/monitor.h"
#include "bake/tubes/corner.h"
#include "bake/tubes/launch_domain.h"
#include "bake/tubes/refine.h"
#include "bake/tubes/tube_builder.h"

namespace photic {

/// How a surface is cut into tubes.
struct LaunchOptions {
    int mesh = 0;        ///< cells a side of the launched patch; 0: by `spacing`
    double spacing = 0;  ///< [voxels] of cells; 0: adaptive, by RefineOptions::tolerance
    RefineOptions refine;
};

/// What launching counted.
struct LaunchTotals {
    PowerLedger power;
    std::int64_t tubes = 0, corner_rays = 0;
    double seconds = 0;  ///< spent launching, without the sink
};

/// Takes tubes, a batch at a time: sets are indexed by axis * 2 + (sense > 0).
using TubeSink = std::function<void(const std::array<TubeSet, 6>&)>;

/// Cuts the part of a height field that can send light into the grid into tubes.
/// Batches follow one another over the patch; inside a batch rows are traced in parallel, with the same result for any
/// number of threads. Memory: some 150 bytes a tube of a batch of at most a million.
void launchHeightField(const CornerTracer& tracer, const LaunchDomain& domain, const TubeLight& light,
                       const GridFrame& frame, const LaunchOptions& options, const TubeSink& sink, LaunchTotals& totals,
                       Monitor& monitor);

/// Cuts a triangle mesh into tubes, triangle by triangle, subdividing where the map bends.
void launchMesh(const CornerTracer& tracer, const TubeLight& light, const GridFrame& frame,
                const LaunchOptions& options, const TubeSink& sink, LaunchTotals& totals, Monitor& monitor);

}  // namespace photic
