// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "bake/paths/ray_casting.h"
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

/// The objects that are meshes, receivers, movables and blockers alike, as rays meet them.
class MeshView {
public:
    explicit MeshView(const Scene& scene);
    /// The nearest before `limit`; its normal is the smooth one where the mesh has one.
    ViewHit hit(const glm::dvec3& origin, const glm::dvec3& direction, double limit) const;
    /// A step that leaves a face behind [m].
    double offset() const { return offset_; }

private:
    Scene scene_;              // with these objects only
    std::vector<int> number_;  // of each in the scene that was given
    std::optional<RayCaster> caster_;
    double offset_ = 0;
};

/// What eye rays meet: the room's planes, movable planes in it, meshes, and the scene's first height field.
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

    /// Whether no mesh stands between a point and the sun. @param direction  of its travel
    bool seesSun(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& direction) const;

private:
    double heightAbove(const glm::dvec3& position) const;  ///< of the position over the surface [m]

    const Scene& scene_;
    std::unique_ptr<const MeshView> meshes_;
    const Surface* water_ = nullptr;
    double march_step_ = 0;
};

}  // namespace photic
