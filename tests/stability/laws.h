// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bake/field/light_field.h"
#include "tests/stability/scene_model.h"

namespace photic::stability {

/// A law that a bake broke.
struct Violation {
    std::string law;   ///< one word: "ledger", "moved" ...
    std::string what;  ///< with the figure
};

/// Bakes the scene as often as the laws need it: finite and not negative, |direction| <= 1, both ledgers closed, light
/// doubled, everything moved by whole voxels, other thread counts, all voxels instead of a band, a finer tolerance, and
/// photons of the same scene.
/// Each is judged on its own. Files go to `directory`, which must exist.
/// @return every law that was broken; nothing where all hold
/// @throws Error{Input} where the scene is refused
std::vector<Violation> brokenLaws(const SceneModel& scene, const std::string& directory);

/// The laws that one field can break by itself.
std::optional<Violation> brokenByField(const LightField& field);
/// What a band around receivers keeps is what a bake of everything has there.
std::optional<Violation> brokenByBand(const LightField& band, const LightField& whole);
bool sameBits(const LightField& a, const LightField& b);

/// What became of a scene that was tried in a process of its own.
struct Outcome {
    enum class Kind { Held, Refused, Broken };
    Kind kind = Kind::Held;
    std::vector<Violation> violations;  ///< Broken: a crash is the law "crash", an exceeded time limit "time"
    std::string refusal;
};
Outcome tryScene(const SceneModel& scene, unsigned limit_seconds);

}  // namespace photic::stability
