// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/scene.h"

namespace photic {

/// n^2 / 2 of a medium that surfaces enclose, anywhere on their side: beyond what is known of it, it goes on as it is
/// at its rim.
double halfSquareEnclosed(const GradedIndex& index, const glm::dvec3& world);

/// A scene's media whose index varies, each as a body of its own, for eye rays: what surfaces enclose ends at them, and
/// comes first, since it is there where another one reaches into it. Of several closed surfaces around a place the one
/// of the highest priority says what is there, and among equals the smallest; beside all of them, what is below height
/// fields or outside of the first surface. Media behind meshes that are open are known nowhere else and stay as they
/// are.
/// The scene's surfaces must outlive the result.
std::vector<GradedObject> bodiesOf(const Scene& scene);

}  // namespace photic
