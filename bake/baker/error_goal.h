// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/baker/bake_scene.h"

namespace photic {

/// Bakes a scene so that look-ups on its flat receivers are off by at most BakeSettings::error (measureReceivers):
/// coarse first, then with the voxels that the light found asks for, around receivers where nobody looks at the water.
/// Warns with the figure reached where the goal would take more than 256 MB or ten seconds.
/// @throws Error{Input} where nothing can be measured; as bakeScene
BakedScene bakeToError(const Scene& scene, Monitor& monitor, const BakeChoices& choices = {});

}  // namespace photic
