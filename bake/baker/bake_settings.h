// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake/baker/bake_tile.h"
#include "bake/file/vdb.h"
#include "bake/methods/catalogue.h"
#include "bake/methods/kept_light.h"
#include "bake/scene/scene.h"

namespace photic {

/// How much of the receivers is measured.
enum class Measure {
    Nothing,
    Quickly,  ///< what takes about a quarter of the bake's expected time, and a little of the largest at least
    Wholly    ///< all texels of the four largest
};
inline const std::vector<std::string> kMeasureNames{"no", "quick", "all"};  ///< in that order

/// What a bake is told besides its scene, whose `bake` table says the rest.
struct BakeChoices {
    std::vector<std::string> post;       ///< steps on the caustic grid, in order (post_steps.h)
    VdbOptions file;                     ///< how the volume is going to be stored: part of its settings and estimate
    Measure measure = Measure::Nothing;  ///< look-ups on receivers
    double detail = 0;  ///< [m] of the texels that they are measured on; 0: a 512th of each receiver's longer side
    double budget_bytes = 256e6;        ///< that a bake which chooses its voxels for an error may write
    double seconds = 10;                ///< that it may take
    std::int64_t max_memory_bytes = 0;  ///< a bake that would take more is refused; 0: what the machine has
    std::optional<Tile> tile = {};      ///< of the volume that is baked; none: all of it
    /// What the frames of a sequence hand on to one another; null: nothing.
    KeptLight* kept_light = nullptr;
    /// Told the stages that Monitor::progress is going to name, one after the other, as soon as they are known. What
    /// counts is how long they take beside one another: a bar then moves evenly.
    std::function<void(const std::vector<Stage>&)> expect = {};
};

inline constexpr double kDefaultError = 0.02;
/// The error of look-ups that a bake aims at by its voxels; 0: it has the domain's.
double errorGoal(const BakeSettings& bake);

/// All settings that a bake's result depends on besides the scene's files, as JSON: the volume's `options`.
std::string settingsText(const Scene& scene, const Method& method, const BakeChoices& choices);

/// 16 hexadecimal digits that change with any input of a bake: its files, its settings and the program's version. The
/// volume's `scene_hash`.
std::string inputHash(const Scene& scene, const Method& method, const BakeChoices& choices);

}  // namespace photic
