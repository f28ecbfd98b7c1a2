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
    StageTriangles room;           ///< walls and floors in a cutaway: seen from their fronts only
    StageTriangles solids;         ///< receivers that are seen from both sides
    std::vector<glm::vec4> walls;  ///< planes that end the room: xyz . p >= w inside; of blocking planes, at most 8
    StageTriangles sheets;         ///< surfaces that bend or reflect light, within the box
    float sheet_reflectance = 0;   ///< of metal mirrors; 0: by Fresnel's equations
    std::vector<float> heights;    ///< for a LiveWater; empty without water or without a scene
    runtime::WaterHeights water;   ///< points to `heights`
    runtime::WaterLight light;     ///< the strongest sun
    glm::vec3 scattering{0};       ///< of the medium [1/m]
    float anisotropy = 0;
    float reference = 1000;  ///< [W/m2]: unfocused light
    /// What light there is beside unfocused light, at most 1: reflected light is fainter, and shown brighter for that.
    float level = 1;
    bool has_sun = false;
    glm::vec3 eye{3}, target{0};  ///< a view of all of it
    float field_of_view_deg = 34;
};

/// The planes, meshes and water of a scene.
Stage stageOf(const Scene& scene);

/// Of a volume without its scene: its box, with a floor and two walls as far as light arrives at them.
Stage stageOf(const runtime::Volume& volume);

/// Stage::level of a volume: four times the mean of the voxels that hold light, over the reference irradiance.
float lightLevel(const runtime::Volume& volume);

/// A ball of radius 1 about the origin, the receiver that is dragged through the light.
StageTriangles ball();

}  // namespace photic::viewer
