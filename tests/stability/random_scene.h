// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tests/stability/scene_model.h"

namespace photic::stability {

/// A scene from a seed; the same on every machine.
SceneModel randomScene(std::uint64_t seed);

/// The scene in every way in which it can be made simpler by one step, boldest steps first.
std::vector<SceneModel> simpler(const SceneModel& scene);

/// Takes simplifying steps as long as `fails` holds, `most_tries` of them at most.
SceneModel shrink(SceneModel scene, const std::function<bool(const SceneModel&)>& fails, int most_tries);

}  // namespace photic::stability
