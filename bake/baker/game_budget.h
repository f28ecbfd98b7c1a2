// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bake/file/runtime_size.h"
#include "bake/file/vdb.h"
#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// What is left out of a volume so that it fits a game's memory.
struct ExportPlan {
    int factor = 1;           ///< voxels so many times as wide
    std::optional<int> band;  ///< voxels kept around receivers; nothing: all
    /// Added to the indices of what a band kept; nothing: what the fewest bricks take. Frames of a sequence share one.
    std::optional<glm::ivec3> shift = {};
    /// So many blocks are held by voxels twice as wide as this takes, the smoothest first (bake/field/two_levels.h)
    /// [bytes]; 0: none.
    std::int64_t two_levels_in = 0;
    GameTexels texels = GameTexels::Halves;
};

/// Which memory counts: what the run-time library takes of an .nvdb, in halves or in blocks, or a dense texture of the
/// lit box.
enum class MemoryModel { Runtime, RuntimeBc6h, Dense };

enum class ExportLevels { One, Two };

/// Plans from the least that is left out to the most: at each resolution everything first, then narrower bands where
/// receivers are known, then two levels in what is left.
/// @param budget_bytes  that two levels are to fit
std::vector<ExportPlan> exportPlans(const Scene* scene, ExportLevels levels, std::int64_t budget_bytes,
                                    GameTexels texels = GameTexels::Halves);

/// `plan` for a sequence that begins with `volume`, whose grids must stay alike.
ExportPlan sharedPlan(const LightVolume& volume, ExportPlan plan, const Scene* scene, Monitor& monitor);

/// Bytes that a volume takes in a game.
std::int64_t gameBytes(const LightVolume& volume, MemoryModel model);

/// The light of a volume and its metadata, as a plan has them; with texels of BC6H not yet compressed, which
/// compressLight() does.
LightVolume planned(const LightVolume& volume, const ExportPlan& plan, const Scene* scene, Monitor& monitor);

/// The first of `plans` from number `first` on that fits. @throws Error{Input} when none does, with what the last takes
std::size_t fittingPlan(const LightVolume& volume, const std::vector<ExportPlan>& plans, std::size_t first,
                        std::int64_t budget_bytes, MemoryModel model, const Scene* scene, Monitor& monitor);

}  // namespace photic
