// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "bake/field/grid_frame.h"
#include "bake/scene/scene.h"

namespace photic {

/// The shadow that the waves of a height field cast on itself: of crests so steep, under light so low, that a part of
/// the surface turns away from it. Bounds of the surface's height, cell by cell, tell most rays that they are free;
/// near a crest the surface itself is asked. Thread-safe.
/// Memory: at most 18 MB. Build: one sample of the surface a cell.
class OwnShadow {
public:
    /// The shadow of a surface under the scene's lights, for light that can reach the box of `frame`; nothing when no
    /// part of the surface there turns away from any of them, or for what is not a height field.
    static std::optional<OwnShadow> of(const Scene& scene, const Surface& surface, const GridFrame& frame);

    /// Whether the surface itself stands between a point on it and the light.
    /// @param direction     of travel, unit, downwards
    /// @param max_distance  [m] back to the light; infinity for a sun
    bool covers(const glm::dvec3& point, const glm::dvec3& direction,
                double max_distance = std::numeric_limits<double>::infinity()) const;

private:
    /// A rectangle of the world's plane.
    struct Part {
        glm::dvec2 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
        void add(const glm::dvec2& p);
    };

    OwnShadow(const Surface& surface, const Part& part);
    static bool turnsAway(const Surface& surface, const Part& part, const Light& light);
    void boundHeights();

    const Surface* surface_;
    Part part_;  // that the bounds are known in
    glm::ivec2 cells_{1};
    glm::dvec2 cell_{1};            // [m]
    std::vector<float> bounds_;     // of each cell, upwards
    std::vector<float> of_blocks_;  // of kBlock x kBlock cells
};

}  // namespace photic
