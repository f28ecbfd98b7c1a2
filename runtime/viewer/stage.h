// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "bake/scene/scene.h"
#include "photic/runtime.h"
#include "photic/runtime_water.h"

namespace photic::viewer {

struct StageVertex {
    glm::vec3 position{0}, normal{0, 0, 1};  ///< world [m]
};
using StageTriangles = std::vector<StageVertex>;  ///< three vertices a triangle

/// What the viewer shows besides the light: receivers, water and sun, as triangles and numbers.
struct Stage {
    glm::vec3 min{-1}, max{1};     ///< of the box that was baked [m]
    StageTriangles room;           ///< receivers that stand still, seen from their fronts
    std::vector<glm::vec4> walls;  ///< planes that end the room: xyz . p >= w inside; of blocking planes, at most 8
    StageTriangles water_surface;  ///< of the water within the box; empty without water
    std::vector<float> heights;    ///< for a LiveWater; empty without water or without a scene
    runtime::WaterHeights water;   ///< points to `heights`
    runtime::WaterLight light;     ///< the strongest sun
    glm::vec3 scattering{0};       ///< of the medium [1/m]
    float anisotropy = 0;
    float reference = 1000;  ///< [W/m2]: unfocused light
    bool has_sun = false;
    glm::vec3 eye{3}, target{0};  ///< a view of all of it
    float field_of_view_deg = 34;
};

/// The planes, meshes and water of a scene.
Stage stageOf(const Scene& scene);

/// Of a volume without its scene: its box, with a floor and two walls where light still arrives.
Stage stageOf(const runtime::Volume& volume);

/// A ball of radius 1 about the origin, the receiver that is dragged through the light.
StageTriangles ball();

}  // namespace photic::viewer
