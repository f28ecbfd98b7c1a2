// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "tests/conformance/bake_scene.h"
#include "tests/support/blocked_light.h"

namespace photic {

/// Something somewhere under some water, in a sun: every number from a seed.
struct ShadowPlace {
    enum class Shape { Pole, Box, Ball, Mesh };
    enum class Water { Flat, Ripples, Swell };
    /// What is baked: from the plane up to the object's top, a thin slab about the plane (the object outside), all the
    /// water, or a slab that is many times as wide as the shadow.
    enum class Extent { Object, Plane, Water, Wide };

    Shape shape = Shape::Box;
    Water kind = Water::Flat;
    Extent extent = Extent::Object;
    int voxels_across = 8;  ///< of the object's width
    std::uint64_t seed = 0;

    truth::SineWater water;
    truth::Solid solid;
    glm::dvec3 sun{0, 0, -1};     ///< of travel, unit
    double voxel = 0;             ///< [m]
    double plane_z = 0;           ///< where missing light is measured: the middle of a layer of voxels, [m]
    std::string role;             ///< of the object, in the scene file's words
    std::string mesh_file;        ///< empty where the object is no mesh
    truth::BlockedLight blocked;  ///< what should be missing, by counted rays

    /// The closed form of what should be missing, under flat water, of a pole, box or ball; otherwise the counted rays.
    double expected() const;
    double width() const { return voxel * voxels_across; }  ///< [m]
    std::string toml(bool with_object) const;
    std::string describe() const;
};

/// Place number `index`: shapes, waters and resolutions take turns, the rest is drawn.
ShadowPlace shadowPlace(int index);

/// The power that is missing on the place's plane: that of the same bake without the object less that with it [W].
struct MissingLight {
    double power = 0;
    double power_imbalance = 0, path_imbalance = 0;  ///< the worse of the two bakes
};
MissingLight missingLight(const ShadowPlace& place, const std::string& method, const GivenOptions& options = {});

/// Downward power through one layer of a field [W].
double powerThroughLayer(const LightField& field, int layer);

}  // namespace photic
