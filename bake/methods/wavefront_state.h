// SPDX-License-Identifier: Apache-2.0
// What a sweep holds while it runs; for the sources of FrontSweep alone.
#pragma once

#include <array>

#include "bake/methods/front_obstacles.h"
#include "bake/methods/wavefront_sweep.h"
#include "bake/paths/optical_scene.h"
#include "bake/tubes/bent_rows.h"

namespace photic {

/// What fronts that may be one have alike.
using FrontWay = std::array<int, 4 + MediumStack::kMost>;
inline FrontWay wayOf(int axis, int sense, const MediumStack& inside) {
    FrontWay way{axis, sense, inside.base, inside.count};
    for (std::size_t i = 0; i < static_cast<std::size_t>(inside.count); ++i) way[4 + i] = inside.media[i];
    return way;
}

/// The axis and sense along which three rays go on best.
/// @param but   axis that is none of them; -1: any may be
/// @return axis -1 where none is within 60 degrees of all three
std::pair<int, int> bestWay(int but, const std::array<Front::Ray, 3>& rays);

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

/// Where a ray meets an object or turns away, counted along the light.
struct FrontSweep::RayEnd {
    double hit = kFarLayers, turns = kFarLayers;  ///< [layers] times the front's sense
    double deposit = 0;                           ///< [layers] where its light ends, behind a receiver
    glm::dvec3 last{0}, face{0};  ///< in index space: where that is on a straight way; the face's normal
    bool done = false;            ///< deposit is found
    bool beside = false;          ///< the voxels that fronts cross
    double lit = 0;
    glm::dvec3 left{0};  ///< of its power, per channel, where it meets it
    Target target;
    // Where it meets a surface:
    Meeting meeting;
    MediumStack inside;
    glm::dvec3 direction{0};  ///< of travel, world
    double time = 0;          ///< optical path so far [m]
    bool meets() const { return hit < kFarLayers; }
};

/// Where a tube ends on objects.
struct FrontSweep::TubeEnd {
    bool ends = false;
    std::array<double, 3> deposit{};  ///< [layers], of its corners
    double last = -kFarLayers;        ///< of them, times the front's sense
    double lit = 0, beside = 0;       ///< shares
    glm::dvec3 left{0};               ///< of its power, per channel
    bool handed_on = false;           ///< by a surface, and counted
};

struct FrontSweep::State {
    FrontRays rays, before;  ///< before: at the chunk's entry
    Packed packed;
    IndexSlices slices;
    std::vector<char> alive;    ///< per tube
    std::vector<TubeEnd> ends;  ///< per tube; empty where nothing stands in the scene
    std::vector<Turned> turned;
    std::map<FrontWay, Front> next;
    /// Of rays in them, by the ray that they come from and where it turned away, or which branch of a surface's they
    /// are.
    std::map<FrontWay, std::map<std::pair<std::uint32_t, int>, std::uint32_t>> places;
    VoxeliseOptions options;               ///< of the chunk
    std::vector<std::int32_t> of_lattice;  ///< per ray of the launched lattice: the front's that continues it; -1: none
    bool attenuates = false, timed = false;
    double time_origin = 0;  ///< optical path that the rays' counts from [m]
    int channels = 1;
    float least_cosine = 0.5f;  ///< to the axis, of rays that are followed
};

/// A tube's ray where it leaves its front.
struct FrontSweep::Leaving {
    Front::Ray ray;
    glm::dvec3 left{0};  ///< of its power, per channel
};

}  // namespace photic
