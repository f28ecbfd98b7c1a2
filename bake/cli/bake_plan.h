// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/cli/json.h"
#include "bake/cli/verbs.h"
#include "bake/field/needed_voxels.h"
#include "bake/methods/catalogue.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// Replaces the scene's settings by those of the command line, adds what a medium implies, and checks that methods,
/// options and grids exist.
/// @throws Error{Usage} for the command line's values, Error{Input} for the scene's
void applySettings(const BakeArguments& arguments, Scene& scene);

/// All settings that a bake's result depends on besides the scene's files.
Json settingsJson(const Scene& scene, const Method& method, const VdbOptions& file);

/// 16 hexadecimal digits that change with any input of a frame: its files, settings and the program's version.
std::string inputHash(const Scene& scene, const Json& settings);

/// The file that a bake writes: `frame` goes in for "####", or before the extension.
std::string outputPath(const BakeArguments& arguments, int frame);

/// `path` with `frame` for its "####", or before its extension.
std::string withFrame(const std::string& path, int frame);

/// What a bake will take.
struct BakeEstimate {
    GridFrame frame;
    std::int64_t needed_voxels = 0, leaves = 0;
    std::int64_t memory_bytes = 0;  ///< peak of the field, its table, and the grids while they are written
    std::int64_t file_bytes = 0;
    double seconds = 0;  ///< on this machine's number of threads; within a factor of three or so
};

/// From the needed voxels, or when `needed` is null from the frame's box: an upper bound.
BakeEstimate estimateBake(const Scene& scene, const Method& method, const GridFrame& frame, const NeededVoxels* needed,
                          const VdbOptions& file);

/// Planar receivers so close to the grid's edge that trilinear look-ups on them lose light: they need a voxel behind.
std::vector<std::string> receiversAtTheEdge(const Scene& scene, const GridFrame& frame);

/// The memory limit of the machine or of its container [bytes].
std::int64_t machineMemory();

/// @throws Error{Failed} when the estimate does not fit `max_memory_bytes` (0: the machine's)
void checkMemory(const BakeEstimate& estimate, std::int64_t max_memory_bytes);

}  // namespace photic::cli
