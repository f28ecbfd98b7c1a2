// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "bake/cli/verbs.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// Replaces the scene's settings by those of the command line, and checks that methods, options and grids exist.
/// @throws Error{Usage} for the command line's values, Error{Input} for the scene's
void applySettings(const BakeArguments& arguments, Scene& scene);

/// The file that a bake writes: `frame` goes in for "####", or before the extension; and the tile.
std::string outputPath(const BakeArguments& arguments, int frame);

/// `path` with the tile's number before its extension: "pool.tile3of8.vdb".
std::string withTile(const std::string& path, const Tile& tile);

/// `path` with `frame` for its "####", or before its extension.
std::string withFrame(const std::string& path, int frame);

/// The frame that a volume was baked of; none where it does not say.
std::optional<int> frameOf(const LightVolume& volume);

}  // namespace photic::cli
