// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bake/cli/json.h"
#include "bake/cli/terminal.h"
#include "bake/file/vdb.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// What is left out of a volume so that it fits a game's memory.
struct ExportPlan {
    int factor = 1;           ///< voxels so many times as wide
    std::optional<int> band;  ///< voxels kept around receivers; nothing: all
    /// Added to the indices of what a band kept; nothing: what the fewest bricks take. Frames of a sequence share one.
    std::optional<glm::ivec3> shift = {};
};

/// Which memory counts: what the run-time library takes of an .nvdb, or a dense texture of the lit box.
enum class MemoryModel { Runtime, Dense };

/// Plans from the least that is left out to the most: at each resolution everything first, then narrower bands where
/// receivers are known.
std::vector<ExportPlan> exportPlans(const Scene* scene);

/// `plan` for a sequence that begins with `volume`, whose grids must stay alike.
ExportPlan sharedPlan(const LightVolume& volume, ExportPlan plan, const Scene* scene, Terminal& terminal);

/// Bytes that a volume takes in a game.
std::int64_t gameBytes(const LightVolume& volume, MemoryModel model);

/// The light of a volume and its metadata, as a plan has them.
LightVolume planned(const LightVolume& volume, const ExportPlan& plan, const Scene* scene, Terminal& terminal);

/// The first of `plans` from number `first` on that fits. @throws Error{Input} when none does, with what the last takes
std::size_t fittingPlan(const LightVolume& volume, const std::vector<ExportPlan>& plans, std::size_t first,
                        std::int64_t budget_bytes, MemoryModel model, const Scene* scene, Terminal& terminal);

/// How far trilinear look-ups of irradiance in `exported`, rounded to half floats, are from those in `source`: at a
/// point in each kept voxel with light (all of them, or evenly spread ones of very many), and on planar receivers.
Json exportError(const LightVolume& source, const LightVolume& exported, const Scene* scene);

/// `exportError` for people.
std::string errorText(const Json& error);

}  // namespace photic::cli
