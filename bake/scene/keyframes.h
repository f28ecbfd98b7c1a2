// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/scene/config_tree.h"

namespace photic {

/// A scene's tables as they are at one frame: each [[light]], [[surface]] and [[object]] with
/// `keyframes = [{ frame = 1, position = [...] }, ...]` gets what those say at that frame in place of `keyframes`.
///
/// Between two of them `position`, `center` and `rotation` (degrees, number by number, as Blender's) go straight, and
/// `direction` along the great circle at an even pace; before the first and after the last nothing moves. A keyframe
/// may leave keys out: each key goes from one keyframe that has it to the next.
/// @throws Error{Input} with the place, for keys that do not move, frames that are there twice, directions that are
///         opposite or have no length, and a key that the table has besides
ConfigValue atFrame(const ConfigValue& root, double frame);

/// The same of one table.
ConfigValue atKeyframes(const ConfigValue& table, double frame);

/// The frame of the first keyframe of a table; `otherwise` where it has none.
double firstKeyframe(const ConfigValue& table, double otherwise);

}  // namespace photic
