// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// Reads a scene file (docs/scene.md), or a glTF that is taken for one (gltf_scene.h), and everything that it refers
/// to, for one frame.
///
/// @param frame   replaces "####" in file names and is the time of animated surfaces
/// @param monitor receives warnings (half-float heights, unwelded meshes ...) and what of a glTF was assumed
/// @throws Error{Input} with file:line:column, value, limit and remedy; unknown keys are errors with "did you mean";
///         names of the schema that are not built yet are refused by name
Scene loadScene(const std::string& path, int frame, Monitor& monitor);

/// Frames a second [1/s] of a scene file, 24 where it does not say.
/// @throws Error{Input} when it cannot be read
double loadFrameRate(const std::string& path);

/// loadScene() from text, for tests; relative files are looked up in `directory`.
Scene parseScene(const std::string& text, const std::string& name, const std::string& directory, int frame,
                 Monitor& monitor);

/// The name in `known` closest to `given` by edit distance, or "" when none is near.
std::string nearestName(const std::string& given, const std::vector<std::string>& known);

}  // namespace photic
