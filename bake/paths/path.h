// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "bake/paths/ray_casting.h"

namespace photic {

/// Which of an interface's two ways light takes.
enum class Branch : std::uint8_t { Refracted, Reflected };

/// What happens to a path at one specular surface.
struct PathEvent {
    int surface = -1;  ///< in Scene::surfaces
    Branch branch = Branch::Refracted;
    bool operator==(const PathEvent&) const = default;
};

/// The events of a path, in order. All paths of a tube have one history.
using History = std::vector<PathEvent>;

/// A place on the surface through which an emission enters, between which tubes are divided. Height field: `position`
/// is (u, v, 0) and `normal` unused. Mesh: a point of a flat triangle and the interpolated normal, NOT normalised, so
/// that the middle of two is the interpolation of their own triangle.
struct EmissionParam {
    glm::dvec3 position{0}, normal{0};
    bool operator==(const EmissionParam&) const = default;
};

inline EmissionParam middle(const EmissionParam& a, const EmissionParam& b) {
    return {0.5 * (a.position + b.position), 0.5 * (a.normal + b.normal)};
}

/// The media that a path is inside of, of closed surfaces that may overlap: the one of the highest priority is what is
/// there, among equals the one entered last [Schmidt and Budge 2002]. Outside of all of them lies `base`.
struct MediumStack {
    static constexpr int kMost = 7;
    std::int16_t media[kMost] = {};  ///< in the order in which they were entered, in OpticalScene::media
    std::int8_t count = 0;
    std::int16_t base = 0;
    bool operator==(const MediumStack& other) const {
        return count == other.count && base == other.base && std::equal(media, media + count, other.media);
    }
};

enum class PathOutcome : std::uint8_t {
    Lit,      ///< light goes on along the last leg
    Blocked,  ///< an object stands between the light and the first surface; `direction` is where light would go
    Hidden,   ///< another specular surface stands before it, and has launched this light
    Missed,   ///< launched across the light itself, it meets something else first: other emissions launch that light
    Dark      ///< the history has no light here: total reflection, or the path meets something else on its way
};

/// What a history makes of one emitted ray. Only the last leg is kept: the legs before it belong to the shorter
/// histories that this one continues, and were laid by them.
struct Path {
    EmissionParam param;
    glm::dvec3 entry{0};      ///< where it meets the first surface [m]
    double facing = 1;        ///< cosine between where light comes from and the normal there
    glm::dvec3 position{0};   ///< where the last leg starts: on the surface of the last event [m]
    glm::dvec3 direction{0};  ///< of the last leg, unit, world; 0 where the last surface sends none
    glm::dvec3 arriving{1};   ///< share of the emitted power that reaches the last event, per channel
    glm::dvec3 fraction{0};   ///< of the arriving power that goes on along the last leg, per channel
    double untraced = 0;      ///< of it, in branches that the surface's `event` leaves out (ledger: reflected)
    double dropped = 0;       ///< of it, in branches that would meet the surface again (ledger: dropped)
    glm::dvec3 absorbed{0};   ///< of it, that a metal keeps, per channel (ledger: absorbed at surfaces)
    int medium = 0;           ///< of the last leg, in OpticalScene::media
    int first_medium = 0;     ///< from the light to the first surface
    MediumStack inside;       ///< of the last leg
    PathOutcome outcome = PathOutcome::Dark;
    Target end;  ///< what the last leg meets
    std::uint32_t end_triangle = 0;
    double hit_distance = std::numeric_limits<double>::infinity();  ///< [m] along the last leg; infinity without a hit
    double end_distance = std::numeric_limits<double>::infinity();  ///< where its deposit ends, overshoot included [m]

    bool dark() const { return fraction.x + fraction.y + fraction.z <= 0; }
};

}  // namespace photic
