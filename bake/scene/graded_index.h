// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

namespace photic {

class IndexVolume;

/// A box in the world [m].
struct WorldBox {
    glm::dvec3 min{0}, max{0};
    bool contains(const glm::dvec3& p) const {
        return p.x >= min.x && p.y >= min.y && p.z >= min.z && p.x <= max.x && p.y <= max.y && p.z <= max.z;
    }
};

/// What the ray equation needs of a refractive index n at a place: with dx/ds = p, dp/ds = grad(n^2 / 2), where s is
/// the parameter that grows by length / n, light goes as a ball under gravity, and |p| stays n.
struct IndexSample {
    double half_square = 0.5;  ///< n^2 / 2
    glm::dvec3 gradient{0};    ///< of n^2 / 2 [1/m], world
};

/// A grid of samples in the world: sample (i, j, k) is at origin_world + world_from_sample * (i, j, k).
struct SamplePlaces {
    glm::dmat3 world_from_sample{1};
    glm::dvec3 origin_world{0};  ///< [m]
    glm::ivec3 size{0};
};

/// A refractive index that varies in space: an object of its own, placed in the world, with air (1) around it.
class GradedIndex {
public:
    virtual ~GradedIndex() = default;
    virtual IndexSample at(const glm::dvec3& world) const = 0;
    /// n^2 / 2 alone.
    virtual double halfSquareAt(const glm::dvec3& world) const { return at(world).half_square; }
    /// Whether the object fills this place; elsewhere at() is that of the air.
    virtual bool contains(const glm::dvec3& world) const = 0;
    /// What holds the object; nothing for one that fills the world.
    virtual std::optional<WorldBox> bounds() const = 0;
    /// Where it is known, of an index that was sampled; nothing for a formula.
    virtual std::optional<SamplePlaces> samples() const { return {}; }
    double indexAt(const glm::dvec3& world) const;
};

/// n^2 = 2 - r^2 / R^2 [Luneburg 1944]: parallel light meets in one point of the far side. No jump at its rim.
std::shared_ptr<const GradedIndex> makeLuneburgLens(const glm::dvec3& center, double radius);

/// n = n0 / (1 + r^2 / scale^2) [Maxwell 1854]: rays are circles, and those of a point meet again beyond the centre.
/// @param radius  of the ball that is cut out of it [m]; absent: it fills the world
std::shared_ptr<const GradedIndex> makeFishEye(const glm::dvec3& center, double n0, double scale,
                                               std::optional<double> radius);

/// n^2 = n0^2 (1 - g^2 r^2) around an axis: the rod lens of copiers and endoscopes.
struct SelfocRod {
    glm::dvec3 center{0}, axis{0, 0, 1};  ///< unit axis
    double n0 = 1.5, g = 1;               ///< at the axis; [1/m]
    std::optional<double> radius{};       ///< [m]; absent: it fills the world, with n = 1 where the square is less
    double length = 0;                    ///< along the axis [m], where a radius is given
};
std::shared_ptr<const GradedIndex> makeSelfocRod(const SelfocRod& rod);

/// n^2 = n0^2 + slope . (x - center): rays are parabolas.
/// @param box  absent: it fills the world
std::shared_ptr<const GradedIndex> makeLinearSquare(const glm::dvec3& center, double n0, const glm::dvec3& slope,
                                                    std::optional<WorldBox> box);

/// Air over a hot road: n = far - drop exp(-(z - ground) / height), and `far - drop` below the ground.
struct HotAir {
    double ground = 0, height = 0.1;  ///< [m]
    double far_index = 1.000277, drop = 2e-5;
};
std::shared_ptr<const GradedIndex> makeHotAir(const HotAir& air, std::optional<WorldBox> box);

/// Two waters, the salty one below: n goes from n_below to n_above as a hyperbolic tangent, over a boundary that an
/// internal wave may bend.
struct SaltLayers {
    double n_above = 1.333, n_below = 1.36;
    double level = 0, thickness = 0.05;    ///< of the boundary [m]
    double amplitude = 0, wavelength = 1;  ///< of the internal wave along x, and half of it along y [m]
};
std::shared_ptr<const GradedIndex> makeSaltLayers(const SaltLayers& layers, std::optional<WorldBox> box);

/// Where samples are: `volume`, moved by world = position + shape_axes * p; 1 outside of its
/// samples' box, and where none is given.
std::shared_ptr<const GradedIndex> makeSampledIndex(std::shared_ptr<const IndexVolume> volume,
                                                    const glm::dvec3& position, const glm::dmat3& shape_axes);

}  // namespace photic
