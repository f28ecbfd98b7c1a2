// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/file/checked_file.h"
#include "bake/report/bake_report.h"

namespace photic {

/// A tile's file.
struct TileFile {
    std::string path;
    std::string name;  ///< that messages call it
};

/// What tiles were merged to.
struct MergedTiles {
    int frame = 0;
    std::int64_t active_voxels = 0;
    /// Of all tiles together: power is counted whole in each of them, paths tile by tile.
    PowerLedger power;
    PathLedger path;
};

/// Joins the tiles of one volume to the file that one bake would have written: every voxel's bytes are as they were.
/// @param tiles  all of them, in any order
/// @param file   the caller commits it
/// @throws Error{Input} naming what is no tile, of another scene, frame, voxel size or settings, stored otherwise,
///         there twice, or missing; Error{Failed}
MergedTiles mergeTiles(const std::vector<TileFile>& tiles, CheckedFile& file);

}  // namespace photic
