// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <utility>

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

/// A light's rays on the plane by which it enters the space: on the side that the light comes from.
class LaunchPlane {
public:
    /// Both must outlive it.
    LaunchPlane(const FrontLaunch& launch, const LightSample& sample);

    int axis() const { return axis_; }  ///< across the plane
    int sense() const { return sense_; }
    /// That the light goes along, and in which sense.
    std::pair<int, int> way() const { return way_; }
    /// A lamp does not stand before the plane.
    bool behindLamp() const { return sample_.source && !(sense_ * (plane_ - source_[axis_]) > 0); }
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

private:
    glm::dvec3 strengthTowards(const glm::dvec3& direction) const;
    glm::dvec3 lampPower(const std::array<glm::dvec3, 3>& corner, int halvings) const;
    enum class Cone { Even, Narrow, Beside };
    Cone coneOver(const std::array<glm::dvec3, 3>& corner) const;

    const FrontLaunch& launch_;
    const LightSample& sample_;
    int axis_ = 2, sense_ = -1;
    std::pair<int, int> way_{2, -1};
    std::array<int, 3> axes_{};
    double plane_ = 0;
    glm::dvec3 source_{0};
};

/// @throws Error{Input} where a lamp is not before the plane
void refuseLampWithin(const LaunchPlane& plane, const Light& light);

/// Where a light has to enter the space to reach the whole target: a flat box on the side that it comes from.
FrontBox entryOf(const FrontLaunch& launch, const LightSample& sample);

/// The front of a light, as it enters the space by the side that the light comes from: as wide as the target's shadow
/// there.
/// @throws Error{Input} for a lamp that is not outside of that side, and for more than 2^26 rays
Front launchFront(const FrontLaunch& launch, const Light& light, const LightSample& sample);

/// Some tubes of a launched front, each as four with rays of their own between its corners'.
Front splitTubes(const FrontLaunch& launch, const LightSample& sample, const Front& front,
                 const std::vector<std::uint32_t>& which);

}  // namespace photic
