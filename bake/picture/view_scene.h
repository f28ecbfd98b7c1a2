// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// The stretch of a ray inside the room: the domain's box cut by the front sides of all blocking planes.
struct ViewInterval {
    double enter = 0, exit = -1;  ///< distances along the ray [m]; `enter` may be negative
    int exit_object = -1;         ///< index in Scene::objects of the plane at the exit; -1: the box's side
    explicit operator bool() const { return exit > std::max(0.0, enter); }
};

struct ViewHit {
    double distance = std::numeric_limits<double>::infinity();
    int object = -1;
    glm::dvec3 normal{0, 0, 1};  ///< unit, towards the eye
    explicit operator bool() const { return object >= 0; }
};

struct SurfaceView {
    glm::dvec3 normal{0, 0, 1};  ///< unit, upwards
    double ior_above = 1, ior_below = 1.333;
};

/// What eye rays meet: the room's planes, movable planes in it, and the scene's first height field.
class ViewScene {
public:
    explicit ViewScene(const Scene& scene);

    ViewInterval clip(const glm::dvec3& origin, const glm::dvec3& direction) const;
    /// The nearest receiver before `limit`: the plane at the room's exit, or a movable plane inside.
    ViewHit receiver(const glm::dvec3& origin, const glm::dvec3& direction, double limit,
                     const ViewInterval& room) const;

    /// Below the water surface; false without one.
    bool inWater(const glm::dvec3& position) const;
    /// Distance to where the ray leaves the water (from_below) or enters it, or `limit` when it does not.
    double surfaceDistance(const glm::dvec3& origin, const glm::dvec3& direction, double limit, bool from_below) const;
    SurfaceView surfaceAt(const glm::dvec3& position) const;

    /// Albedo of a receiver: plain, or tiles with darker joints and a slight variation from tile to tile.
    glm::dvec3 albedo(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& base,
                      double tile_size) const;

private:
    double heightAbove(const glm::dvec3& position) const;  ///< of the position over the surface [m]

    const Scene& scene_;
    const Surface* water_ = nullptr;
    double march_step_ = 0;
};

}  // namespace photic
