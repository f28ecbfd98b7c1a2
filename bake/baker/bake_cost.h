// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/baker/bake_settings.h"
#include "bake/field/needed_voxels.h"

namespace photic {

/// What a bake and the write of its volume will take on this machine.
struct BakeCost {
    std::int64_t needed_voxels = 0, leaves = 0;
    std::int64_t memory_bytes = 0;  ///< peak of the method, the field, its table, and the grids while they are written
    std::int64_t file_bytes = 0;    ///< uncompressed
    std::vector<Stage> stages;      ///< from the scene that is loaded to the file that is written
    double bake_seconds = 0;        ///< of the method itself, on one thread: the same for any number of threads
    std::string dearest;  ///< the setting that costs most of the time, and what would be quicker; may be empty
    double seconds() const;
};

/// From the needed voxels, or when `needed` is null from the frame's box: an upper bound.
BakeCost bakeCost(const Scene& scene, const Method& method, const GridFrame& frame, const NeededVoxels* needed,
                  const BakeChoices& choices);

/// What of a frame is baked.
struct NeededCount {
    double voxels = 0, leaves = 0;
};
BakeCost bakeCost(const Scene& scene, const Method& method, const GridFrame& frame, const NeededCount& needed,
                  const BakeChoices& choices);

/// The most memory that a bake of the whole frame can take [bytes], without a look at its light.
std::int64_t mostMemory(const Scene& scene, const Method& method, const GridFrame& frame);

/// "about 41 MB and 0.6 s": of the file, and of the bake.
std::string wordsOf(const BakeCost& cost, double slower = 1);

/// The memory of the machine or of its container [bytes].
std::int64_t machineMemory();
/// What may be taken: `max_memory_bytes`, or when it is 0 what the machine has.
std::int64_t memoryLimit(const BakeChoices& choices);

/// @throws Error{Failed} when a bake does not fit its limit, with the figures and what would help
void checkMemory(const BakeCost& cost, const BakeChoices& choices);

}  // namespace photic
