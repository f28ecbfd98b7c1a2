// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/baker/bake_scene.h"

namespace photic {

/// Bakes a scene so that look-ups on its flat receivers are off by at most errorGoal() (measureReceivers): coarse
/// first, then with the voxels that the light found asks for, around receivers where nobody looks at the water. Warns
/// with the figure reached where the goal would take more than BakeChoices::budget_bytes or seconds. Where nothing can
/// be measured and nobody asked for an error, the domain's own voxels are baked, and a note says so.
/// @throws Error{Input} where an error is asked for and nothing can be measured; as bakeScene
BakedScene bakeToError(const Scene& scene, Monitor& monitor, const BakeChoices& choices = {});

}  // namespace photic
