// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "bake/methods/wavefront_sweep.h"
#include "bake/paths/emission.h"
#include "bake/paths/ray_casting.h"

namespace photic {

/// A box in index space.
struct FrontBox {
    glm::dvec3 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
    void add(const glm::dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
};

struct FrontLaunch {
    const GridFrame& frame;
    const FrontSpace& space;
    const FrontBox& target;  ///< voxels that a front has to cover
    double spacing = 1;      ///< [voxels] between rays
    bool lit = false;        ///< its light counts before it has been in a medium
    /// Whether a place in the world is in a medium: light that enters there has been in one.
    std::function<bool(const glm::dvec3&)> in_medium{};
    const RayCaster* caster = nullptr;  ///< what throws shadows; null: nothing does
    MediumStack inside{};               ///< where light comes in
    std::optional<int> across{};        ///< axis across which it comes in; absent: that along which it goes
    bool straight = false;  ///< light goes straight on its way to the target: it comes in by the target's own side
};

/// A side of a cube of two voxels around a lamp: an axis, and the sense in which the side looks.
using LampSide = std::pair<int, int>;

/// Whether a lamp stands among what light goes through: its light starts there, and not on the space's side.
bool standsAmong(const FrontLaunch& launch, const LightSample& sample);

/// A light's rays on the plane by which it enters the space: on the side that the light comes from, or, of a lamp that
/// is beside that one, on a side that the lamp is before. Of a lamp that stands in the space: on a side of a cube
/// around it, and the rays start in the lamp.
class LaunchPlane {
public:
    /// Both must outlive it.
    /// @param side  of a lamp that stands among the media
    LaunchPlane(const FrontLaunch& launch, const LightSample& sample, std::optional<LampSide> side = {});

    int axis() const { return axis_; }  ///< across the plane
    int sense() const { return sense_; }
    /// That the light goes along, and in which sense.
    std::pair<int, int> way() const { return way_; }
    /// A lamp does not stand before the plane.
    bool behindLamp() const { return sample_.source && !(sense_ * (plane_ - source_[axis_]) > 0); }
    /// Where a ray that rayAt() made crosses the plane, along u and v.
    glm::dvec2 placeOf(const Front::Ray& ray) const;
    /// Where the ray that meets a place of index space crosses the plane, along u and v.
    glm::dvec2 shadowOf(const glm::dvec3& voxel) const;
    /// In index space.
    glm::dvec3 voxelAt(const glm::dvec2& uv) const;
    /// As light goes on from the plane. Where a medium reaches it, light comes into it as through a flat face, without
    /// loss.
    Front::Ray rayAt(const glm::dvec2& uv) const;
    /// Unit, of travel, of the light that comes to a place, before it is refracted.
    glm::dvec3 directionAt(const glm::dvec3& world) const;
    /// Per channel [W], through a triangle of the plane.
    glm::dvec3 power(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) const;
    /// Per channel [W/m2], on the plane.
    glm::dvec3 irradianceAt(const glm::dvec2& uv) const;
    /// Whether light is as strong in all directions.
    bool even() const { return !sample_.source || sample_.light->type == LightType::Point; }
    /// Of a lamp through a place of the plane, per channel [W/sr].
    glm::dvec3 strengthAt(const glm::dvec2& uv) const {
        return strengthTowards(directionAt(launch_.frame.worldFromIndex(voxelAt(uv))));
    }
    /// Of a lamp towards a direction, per channel [W/sr].
    glm::dvec3 strengthTowards(const glm::dvec3& direction) const;

private:
    glm::dvec3 lampPower(const std::array<glm::dvec3, 3>& corner, int halvings) const;
    enum class Cone { Even, Narrow, Beside };
    Cone coneOver(const std::array<glm::dvec3, 3>& corner) const;

    double sideAlong(int axis, int sense) const;

    const FrontLaunch& launch_;
    const LightSample& sample_;
    bool from_lamp_ = false;
    int axis_ = 2, sense_ = -1;
    std::pair<int, int> way_{2, -1};
    std::array<int, 3> axes_{};
    double plane_ = 0;
    glm::dvec3 source_{0};
};

/// @throws Error{Input} where a lamp neither stands among the media nor before a side by which its light may come in
void requireWay(const FrontLaunch& launch, const LightSample& sample, const Light& light);

/// Where a light has to enter the space to reach the whole target: a flat box on the side that it comes from.
FrontBox entryOf(const FrontLaunch& launch, const LightSample& sample);

/// The front of a light, as it enters the space by the side that the light comes from: as wide as the target's shadow
/// there. Of a lamp that stands among the media six, one to each side of a cube around it: all its rays start in the
/// lamp, `spacing` apart where they leave the space straight on.
/// @throws Error{Input} as requireWay(), and for more than 2^26 rays
std::vector<Front> launchFronts(const FrontLaunch& launch, const Light& light, const LightSample& sample);

}  // namespace photic
