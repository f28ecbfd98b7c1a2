// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bake/scene/height_field.h"
#include "bake/scene/triangle_mesh.h"

namespace photic {

class IndexVolume;

/// How the grid's z columns lean: x += shear.x * z, y += shear.y * z (index to world).
enum class ShearMode { None, Light, Explicit };

/// The box that is baked [m].
struct Domain {
    glm::dvec3 min{0}, max{0};
    double voxel_size = 0;  ///< [m]; cubic before shear
    ShearMode shear_mode = ShearMode::None;
    glm::dvec2 shear{0};  ///< dx/dz, dy/dz when Explicit
    /// Voxel height [m] along z; 0: voxel_size. A sheared grid needs fewer layers (`layer_height` in the file).
    double layer_height = 0;
};

/// A directional light, or one in a point: then direction and irradiance are those at the surface's centre.
struct Light {
    std::string name;
    glm::dvec3 direction{0, 0, -1};      ///< unit, of travel
    glm::dvec3 irradiance{1000};         ///< across the beam [W/m2], per channel
    std::optional<glm::dvec3> position;  ///< of a point light [m]
    double angular_diameter_deg = 0;     ///< 0: a point sun
    bool coloured() const { return irradiance.x != irradiance.y || irradiance.y != irradiance.z; }
};

enum class SurfaceEvent { Refract, Reflect, Both };
enum class Outside { Flat, Periodic, None };

/// A specular interface: a height field, or an open triangle mesh.
struct Surface {
    std::string name;
    std::string where;                                ///< file:line of its table, for messages
    std::shared_ptr<const HeightField> height_field;  ///< one of the two is set
    std::shared_ptr<const TriangleMesh> mesh;
    glm::dvec2 size{0};  ///< of the patch [m]; height fields only
    glm::dvec3 center{0};
    Outside outside = Outside::Flat;
    SurfaceEvent event = SurfaceEvent::Refract;
    double ior_above = 1.0;  ///< on the side of the normal
    double ior_below = 1.333;
};

/// A homogeneous medium below the surface, per channel [1/m].
struct Medium {
    glm::dvec3 absorption{0};
    glm::dvec3 scattering{0};
    double anisotropy = 0;  ///< Henyey-Greenstein g, -1..1
    glm::dvec3 extinction() const { return absorption + scattering; }
    bool present() const { return extinction() != glm::dvec3(0); }
    bool coloured() const {
        const glm::dvec3 t = extinction();
        return t.x != t.y || t.y != t.z;
    }
};

enum class Role { Receiver, Movable, Blocker };
struct Plane {
    glm::dvec3 point{0}, normal{0, 0, 1};  ///< unit normal
};
/// Something that receives or blocks light.
struct Object {
    std::string name;
    std::string where;
    std::variant<Plane, std::shared_ptr<const TriangleMesh>> shape;
    Role role = Role::Receiver;
    bool blocks() const { return role != Role::Movable; }
    bool receives() const { return role != Role::Blocker; }
};

enum class Where { Everywhere, Receivers, Media };
enum class Paths { Caustic, All };
struct GridSet {
    bool irradiance = true, direction = true, caustic = false, arrival_time = false, density = false;
};

/// One value of a method's option as read from the file or the command line.
using OptionValue = std::variant<bool, std::int64_t, double, std::string>;
struct GivenOption {
    OptionValue value;
    std::string where;  ///< file:line, or "--set"
};
using GivenOptions = std::map<std::string, GivenOption>;

/// The [bake] table.
struct BakeSettings {
    std::string method = "auto";
    GridSet grids;
    Where where = Where::Everywhere;
    int band = 2;  ///< voxels around receivers
    Paths paths = Paths::Caustic;
    int quadrature = 1;       ///< 1 | 2 | 4 Gauss points across a layer
    double tolerance = 0.25;  ///< [voxels] refinement
    bool prefilter = false;
    std::map<std::string, GivenOptions> method_options;  ///< [bake.NAME] tables
};

/// Everything that a bake reads.
struct Scene {
    std::string file;  ///< as given; for messages
    Domain domain;
    std::vector<Light> lights;
    std::vector<Surface> surfaces;
    Medium medium;
    /// Of the medium below the surface, which has it instead of ior_below; null where the index is constant.
    std::shared_ptr<const IndexVolume> index;
    std::vector<Object> objects;
    BakeSettings bake;
    std::uint64_t hash = 0;  ///< of the file and all that it refers to, for this frame
    int frame = 0;

    /// Three channels are needed.
    bool coloured() const;
    /// Largest channel of the summed unblocked irradiance across the beams, above the surface [W/m2]; 1 without light.
    double referenceIrradiance() const;
};

}  // namespace photic
