// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace photic::stability {

/// A scene in plain numbers, so that it can be moved, dimmed and made simpler. Lengths are in units
/// of about the box's size; `scale` turns them into metres.
struct SceneModel {
    enum class LampKind { Sun, Point, Spot, Rectangle };
    struct Lamp {
        LampKind kind = LampKind::Sun;
        glm::dvec3 direction{0, 0, -1}, irradiance{1};  ///< of lamps with a place: power [W], as in a scene of scale 1
        double disc = 0;                                ///< [degrees]
        glm::dvec3 position{0, 0, 2};
        double angle = 45, blend = 0.15, size = 0.1;
        int samples = 4;  ///< of a rectangle's places
    };
    struct Wave {
        double amplitude = 0, wavelength = 1, direction = 0, phase = 0;
    };
    enum class Water { Flat, Waves, Bump, Sea, Mesh, None };
    enum class Shape { Plane, Box, Ball, Mesh };
    struct Thing {
        Shape shape = Shape::Box;
        glm::dvec3 center{0}, size{0.1};  ///< a plane's `size` is its normal
        std::string role = "receiver";
        std::uint64_t seed = 0;  ///< of a mesh
    };

    /// A surface that is no water: closed glass, a pane or a mirror.
    enum class GlassShape { Sphere, Rock, Box, Pane };
    struct Glass {
        GlassShape shape = GlassShape::Sphere;
        glm::dvec3 center{0}, size{0.2}, rotation{0};
        std::string event = "both";
        double ior = 1.5;
        glm::dvec3 absorption{0};
        int priority = 0;
        bool thin = false, inverted = false, facets = false;
        std::uint64_t seed = 0;
    };
    /// A medium whose index varies, instead of water and glass.
    enum class Index { None, Luneburg, FishEye, Linear, Salt };

    std::uint64_t seed = 0;
    double scale = 1;       ///< metres per unit
    glm::ivec3 shift{0};    ///< of everything, in voxels
    double brightness = 1;  ///< of all lamps
    glm::dvec3 low{-0.5, -0.5, -0.6}, high{0.5, 0.5, 0.1};
    int voxels = 24;       ///< along one unit
    bool leaning = false;  ///< shear = "light", layers twice as high
    std::vector<Lamp> lamps;
    Water water = Water::Flat;
    std::vector<Wave> waves;
    double height = 0.05;  ///< of a bump or a mesh's lumps
    double patch = 2;      ///< side of the surface
    std::string event = "refract", outside;
    double ior_above = 1, ior_below = 1.333;
    glm::dvec3 absorption{0}, scattering{0};
    std::vector<Thing> things;
    std::vector<Glass> glasses;
    Index index = Index::None;
    double index_radius = 0.3, index_strength = 0.2;
    glm::dvec3 index_center{0, 0, -0.25};
    std::string method = "beams", where = "everywhere";
    int quadrature = 1;
    double tolerance = 0.25;
    bool caustic = false;
    std::string options;  ///< lines of [bake.METHOD]

    double voxelSize() const { return scale / voxels; }  ///< [m]
    /// The scene file; meshes are written beside it, into `directory`, which must exist.
    std::string toml(const std::string& directory) const;
};

}  // namespace photic::stability
