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
#include "bake/scene/refractive_index.h"
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

enum class LightType { Sun, Point, Spot, Rectangle };

/// What shines. `type` says which of the fields hold; lights may stand in any medium.
///
/// `irradiance` holds for all: of a light that has a place it is that at the centre of what it shines on (of the first
/// surface), across its rays there. The reference irradiance is made from it.
struct Light {
    std::string name;
    std::string where{};  ///< file:line of its table, for messages
    LightType type = LightType::Sun;
    /// Unit, of travel: of a spot and a rectangle their axis, of a point that towards the centre of what it shines on.
    glm::dvec3 direction{0, 0, -1};
    glm::dvec3 irradiance{1000};  ///< across the beam [W/m2], per channel
    /// Of a point and a spot, and the rectangle's centre [m]; a sun has none.
    std::optional<glm::dvec3> position{};
    double angular_diameter_deg = 0;  ///< of a sun's disc; 0: a point sun

    /// Radiant power [W], per channel. A point sends power / (4 pi) per steradian everywhere, and a spot the same
    /// within its cone (its power is that of the point that it is cut from, as in Blender and glTF). A rectangle
    /// sends all of it to one side, power / (pi area) per m2 and steradian whatever the angle.
    glm::dvec3 power{0};
    double cone_angle_deg = 180;  ///< of a spot: the full angle of its cone, up to 180
    /// Of a spot: 0 is a sharp rim, 1 softens all of the cone; see spotFalloff().
    double blend = 0;
    glm::dvec2 size{0};           ///< of a rectangle [m]: along `tangent`, and along cross(direction, tangent)
    glm::dvec3 tangent{1, 0, 0};  ///< of a rectangle: unit, across `direction`
    int samples = 16;             ///< of a rectangle: points that stand for it

    bool coloured() const { return irradiance.x != irradiance.y || irradiance.y != irradiance.z; }
    /// Share of its on-axis intensity that a spot sends along a direction, given the cosine between the two; 1 for
    /// every other light. 0 outside the cone; within, smoothstep(c / blend) with c = (cosine - rim) / (1 - rim), where
    /// rim is the cosine at the cone's edge (as Blender's Cycles).
    double spotFalloff(double cos_to_axis) const;
};

/// What a surface does to light. `Mirror` is a metal's: it reflects `colour` of the power and absorbs the rest.
/// `Reflect`, `Refract` and `Both` share the power by Fresnel's equations.
enum class SurfaceEvent { Refract, Reflect, Both, Mirror };
enum class Outside { Flat, Periodic, None };

/// A sphere as it is, without facets.
struct Sphere {
    glm::dvec3 center{0};  ///< [m]
    double radius = 0;     ///< [m]
};

/// A specular interface: a height field, a triangle mesh, open or closed, or a sphere.
///
/// What lies on its two sides are media (Scene::media) where it names them, otherwise the numbers ior_above and
/// ior_below, with Scene::medium below; sideOf() answers for both.
struct Surface {
    std::string name;
    std::string where;                                ///< file:line of its table, for messages
    std::shared_ptr<const HeightField> height_field;  ///< one of height_field and mesh is set
    std::shared_ptr<const TriangleMesh> mesh;         ///< in the world; of a sphere: one that stands for it
    std::optional<Sphere> sphere{};                   ///< set beside `mesh`: the surface is exactly this
    glm::dvec2 size{0};                               ///< of the patch [m]; height fields only
    glm::dvec3 center{0};                             ///< of the patch, or of the mesh's bounds [m]
    Outside outside = Outside::Flat;                  ///< height fields only
    SurfaceEvent event = SurfaceEvent::Refract;
    double ior_above = 1.0;  ///< on the side of the normal
    double ior_below = 1.333;
    /// Media by their place in Scene::media, or -1: not named. "Above" is the normal's side, the outside of closed
    /// meshes and of spheres; "below" the other one, their inside.
    int medium_above = -1, medium_below = -1;
    glm::dvec3 colour{1};  ///< of a mirror: the share of power that it reflects, per channel, at any angle
    bool smooth = true;    ///< meshes: normals between vertices are interpolated; false: flat facets
    /// Meshes: every connected part has an inside (each edge belongs to two triangles, or more).
    bool closed = false;
    std::string closed_part{};  ///< of a mesh that is open, a part that is closed ("8 vertices around ..."), or empty
    /// A pane without thickness: light goes on in its direction, less what its two faces reflect and, of `Both`, with
    /// what they reflect. The medium below (inside) sets how much that is; on both sides lies the one above.
    bool thin = false;
};

/// A homogeneous medium, per channel [1/m]: the one below the surface (Scene::medium), or a named one (Scene::media).
struct Medium {
    glm::dvec3 absorption{0};
    glm::dvec3 scattering{0};
    double anisotropy = 0;  ///< Henyey-Greenstein g, -1..1
    std::string name{};     ///< empty: the one below the surface
    std::string where{};    ///< file:line of its table, for messages
    RefractiveIndex ior{};  ///< of named media
    /// Where closed surfaces overlap, the medium of the highest priority is what is there, and interfaces of lower ones
    /// inside it do nothing. Among equals it is the one that was entered last.
    int priority = 0;
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
    /// Share of light that it sends back, per channel; absent: the picture's own. Pictures only: a bake counts what
    /// arrives.
    std::optional<glm::dvec3> albedo{};
    bool blocks() const { return role != Role::Movable; }
    bool receives() const { return role != Role::Blocker; }
};

/// A place to look from, for pictures; the first one is the default.
struct Camera {
    std::string name;
    std::string where;
    glm::dvec3 position{0}, target{0};  ///< [m]; they differ
    glm::dvec3 up{0, 0, 1};             ///< unit; not along the line of sight
    double field_of_view_deg = 34;      ///< of the picture's height
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

inline constexpr int kDefaultBounces = 12;
inline constexpr double kDefaultThreshold = 1e-4;

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
    /// Share by which look-ups on flat receivers may be off; absent: the voxel size is what the domain says.
    std::optional<double> error{};
    /// Neither an error nor voxels of a size are asked for: a program that writes files aims at an error of its own
    /// where look-ups can be measured (bakeToError). Otherwise the domain has its default voxels.
    bool sizes_itself = false;
    int lobes = 2;  ///< 1 | 2: directions that a voxel keeps where light opposes itself
    /// Unit: light that travels against it is the second lobe. Absent: bakeScene finds one that parts the light well,
    /// and methods that are called without it keep one lobe.
    std::optional<glm::dvec3> lobe_axis{};
    /// Most events (interfaces refracted or reflected at) of a path; absent: kDefaultBounces, or as many as the method
    /// follows. What goes on beyond is in the ledger.
    std::optional<int> bounces{};
    /// Share of a path's power below which a branch of it is not followed but counted; absent: kDefaultThreshold.
    std::optional<double> threshold{};
    std::map<std::string, GivenOptions> method_options;  ///< [bake.NAME] tables
};

/// Everything that a bake reads.
struct Scene {
    std::string file;  ///< as given; for messages
    Domain domain;
    std::vector<Light> lights;
    std::vector<Surface> surfaces;
    /// The water: below height fields, and below meshes that name no medium of their own; its index is their ior_below.
    Medium medium;
    /// Named media, "air" among them where a surface names it.
    std::vector<Medium> media;
    /// Of the medium below the surface, which has it instead of ior_below; null where the index is constant.
    std::shared_ptr<const IndexVolume> index;
    std::vector<Object> objects;
    std::vector<Camera> cameras;
    BakeSettings bake;
    std::uint64_t hash = 0;  ///< of the file and all that it refers to, for this frame
    int frame = 0;

    /// Three channels are needed.
    bool coloured() const;
    /// Largest channel of the summed unblocked irradiance across the beams, above the surface [W/m2]; 1 without light.
    double referenceIrradiance() const;
};

enum class Side { Above, Below };
/// What lies on a side of a surface, whether it is named or given by ior_above, ior_below and Scene::medium (which is
/// below open surfaces that let light in). Its `ior` is always set.
Medium sideOf(const Scene& scene, const Surface& surface, Side side);

}  // namespace photic
