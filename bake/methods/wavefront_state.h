// SPDX-License-Identifier: Apache-2.0
// What a sweep holds while it runs; for the sources of FrontSweep alone.
#pragma once

#include "bake/methods/wavefront_sweep.h"
#include "bake/paths/optical_scene.h"
#include "bake/tubes/bent_rows.h"

namespace photic {

inline constexpr double kFarLayers = 1e6;  // past any grid, and exact in single precision

/// Some consecutive layers: a slab, or layers that nobody needs.
struct FrontSweep::Chunk {
    int first = 0, layers = 0;
    const SlabGroup* group = nullptr;  ///< null: nobody needs them
    std::size_t slab = 0;
};

/// A front's tubes, in its order, as the deposit takes them.
struct FrontSweep::Packed {
    TubeSet set;
    BentRows bent;
    std::vector<glm::ivec2> cells;  ///< per tube, of the launched front
};

/// A tube that turned away in this chunk.
struct FrontSweep::Turned {
    std::uint32_t tube;
    int lane;  ///< that it does not pass any more
};

struct FrontSweep::State {
    FrontRays rays, before;  ///< before: at the chunk's entry
    Packed packed;
    IndexSlices slices;
    std::vector<char> alive;  ///< per tube
    std::vector<Turned> turned;
    std::map<std::pair<int, int>, Front> next;  ///< by axis and sense
    std::map<std::pair<int, int>, std::map<std::pair<std::uint32_t, int>, std::uint32_t>> places;  ///< of rays in them
    VoxeliseOptions options;                                                                       ///< of the chunk
    bool attenuates = false, timed = false;
    double time_origin = 0;  ///< optical path that the rays' counts from [m]
    int channels = 1;
};

/// A tube's ray where it leaves its front.
struct FrontSweep::Leaving {
    Front::Ray ray;
    glm::dvec3 left{0};  ///< of its power, per channel
};

}  // namespace photic
