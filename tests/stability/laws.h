// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "bake/field/light_field.h"
#include "tests/stability/scene_model.h"

namespace photic::stability {

/// A law that a bake broke.
struct Violation {
    std::string law;   ///< one word: "ledger", "moved" ...
    std::string what;  ///< with the figure
};

/// What became of a law, or of a few that one bake tells.
struct Judgement {
    std::string law;     ///< one word: "field", "ledger", "photons", "linear and threads" ...
    double seconds = 0;  ///< of processor time
    std::optional<Violation> broken;
};
using Tell = std::function<void(const Judgement&)>;

/// Bakes the scene as often as the laws need it: finite and not negative, |direction| <= 1, both ledgers closed, light
/// doubled, everything moved by whole voxels, three threads instead of one, all voxels instead of a band, a finer
/// tolerance, and photons of the same scene.
/// Each is judged on its own, and told as soon as it is. Leaves the process with one thread. Files go to `directory`,
/// which must exist.
/// @throws Error{Input} where the scene is refused
void judgeLaws(const SceneModel& scene, const std::string& directory, const Tell& tell);

/// The laws that one field can break by itself.
std::optional<Violation> brokenByField(const LightField& field);
/// What a band around receivers keeps is what a bake of everything has there.
/// @param blur  voxels of a layer nearer than this to ones that the band leaves out are not judged
std::optional<Violation> brokenByBand(const LightField& band, const LightField& whole, int blur = 0);
/// Whether each value of `b` is `times` that of `a`, to the bit.
bool sameBits(const LightField& a, const LightField& b, float times = 1);

}  // namespace photic::stability
