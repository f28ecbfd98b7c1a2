// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/field/light_field.h"

namespace photic {

class CheckedFile;
class OutputSet;
struct CompressedLight;

enum class Compression { None, Mask, Blosc, Zip };

struct VdbOptions {
    Compression compression = Compression::Mask;
    bool half = true;  ///< half floats; false: 32-bit
};

/// A light volume as it stands in a file: field in W/m2, extra scalar grids by name, metadata without the `photic:`
/// prefix.
struct LightVolume {
    LightField field;
    double reference_irradiance = 1;  ///< stored irradiance = field / this
    bool has_irradiance = true, has_direction = true;
    std::map<std::string, LightField> scalars;    ///< "caustic", "density", "arrival_time": one channel, no flux
    std::map<std::string, std::string> metadata;  ///< version, method, options, ledger (JSON) ...
    /// The second lobe, on the same voxels as `field`, which then holds the first: light that travels against the axis
    /// `lobe_axis` of the metadata, where light opposes itself. All light is the sum of both.
    std::optional<LightField> second = {};
    /// Both lobes as blocks for a GPU (compressed_light.h), or null; the fields then hold what those decode to.
    std::array<std::shared_ptr<const CompressedLight>, 2> compressed = {};
};

/// The volume with all light in one lobe.
LightVolume withoutLobes(LightVolume volume);

/// Writes `irradiance`, `direction` and the scalars on one transform and one topology (active: irradiance of all light
/// or density above 1e-6 of the reference, at least one leaf always), and the second lobe where it has light.
/// Serialises to memory-checked stream, temporary name beside `path`, fsync, read back, rename: on any failure the old
/// file is intact and nothing else is left.
/// @throws Error{Failed} (full disk, no permission)
/// @return number of active voxels
std::int64_t writeVdb(const std::string& path, const LightVolume& volume, const VdbOptions& options);
/// The same as a file of a set, which OutputSet::commit() renames.
std::int64_t writeVdb(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                      const VdbOptions& options);

/// The same into a file that the caller commits.
std::int64_t writeVdb(CheckedFile& file, const LightVolume& volume, const VdbOptions& options);

/// Reads a light volume, or any .vdb with `irradiance`. Needed voxels are the active ones.
/// @throws Error{Input} when missing, truncated, not a .vdb, or without a known grid (lists the grids present)
LightVolume readVdb(const std::string& path);

}  // namespace photic
