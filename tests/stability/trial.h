// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/stability/laws.h"
#include "tests/stability/scene_model.h"

namespace photic::stability {

/// What became of a scene that was tried in a process of its own.
struct Outcome {
    enum class Kind { Held, Refused, Broken };
    Kind kind = Kind::Held;
    std::vector<Violation> violations;      ///< Broken: a crash is the law "crash", an exceeded time limit "time"
    std::map<std::string, double> seconds;  ///< of processor time, by the law that was judged with it
    std::string refusal;
};

/// @param limit_seconds  of processor time; a process that stands still is ended after ten times as long
Outcome tryScene(const SceneModel& scene, unsigned limit_seconds);

/// Tries scenes side by side, each in a process of its own with one thread.
/// @param next   the next scene to try; nothing where there are no more
/// @param ended  told what became of a scene, in the order in which they end
void tryScenes(int jobs, unsigned limit_seconds, const std::function<std::optional<SceneModel>()>& next,
               const std::function<void(const SceneModel&, const Outcome&)>& ended);

}  // namespace photic::stability
