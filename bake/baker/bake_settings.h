// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bake/file/vdb.h"
#include "bake/methods/catalogue.h"
#include "bake/scene/scene.h"

namespace photic {

/// What a bake is told besides its scene, whose `bake` table says the rest.
struct BakeChoices {
    std::vector<std::string> post;      ///< steps on the caustic grid, in order (post_steps.h)
    VdbOptions file;                    ///< how the volume is going to be stored: part of its settings and estimate
    std::int64_t max_memory_bytes = 0;  ///< a bake that would take more is refused; 0: what the machine has
    /// Told the stages that Monitor::progress is going to name, one after the other, as soon as they are known. What
    /// counts is how long they take beside one another: a bar then moves evenly.
    std::function<void(const std::vector<Stage>&)> expect = {};
};

/// All settings that a bake's result depends on besides the scene's files, as JSON: the volume's `options`.
std::string settingsText(const Scene& scene, const Method& method, const BakeChoices& choices);

/// 16 hexadecimal digits that change with any input of a bake: its files, its settings and the program's version. The
/// volume's `scene_hash`.
std::string inputHash(const Scene& scene, const Method& method, const BakeChoices& choices);

}  // namespace photic
