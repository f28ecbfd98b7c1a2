// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bake/file/vdb.h"

namespace photic {

/// How values are stored (docs/files.md).
enum class NvdbPrecision {
    Half,  ///< scalar grids of 16-bit codes between each leaf's least and largest value
    Float  ///< one grid of four floats a voxel
};
enum class NvdbCodec { None, Zip, Blosc };

struct NvdbOptions {
    NvdbPrecision precision = NvdbPrecision::Half;
    NvdbCodec codec = NvdbCodec::None;  ///< the run-time library reads None and Blosc
};

struct NvdbWritten {
    std::int64_t active_voxels = 0;
    std::int64_t clamped = 0;  ///< values that were not finite or above 65504, and were cut
};

/// Writes a light volume for games: NanoVDB 32.4, `flux` = irradiance * direction and irradiance in units of the
/// reference, on the voxels with light, at the volume's own affine transform. The run-time metadata
/// (runtime_metadata.h) is the blind data `photic` of the first grid. Equal volumes give equal bytes.
/// @throws Error{Failed} (full disk, no permission; nothing is left half-written); Error{Usage} for a codec that this
/// program was built without
NvdbWritten writeNvdb(const std::string& path, const LightVolume& volume, const NvdbOptions& options);
/// The same as a file of a set, which OutputSet::commit() renames.
NvdbWritten writeNvdb(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                      const NvdbOptions& options);

}  // namespace photic
