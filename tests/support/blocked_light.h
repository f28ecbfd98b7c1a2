// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>
#include <vector>

namespace photic::truth {

/// Numbers that are the same on every machine (SplitMix64; Steele, Lea and Flood 2014).
class Dice {
public:
    explicit Dice(std::uint64_t seed) : state_(seed) {}
    double uniform();  ///< [0, 1)
    double between(double low, double high) { return low + (high - low) * uniform(); }
    /// Even in the logarithm.
    double logBetween(double low, double high);
    int below(int count) { return static_cast<int>(uniform() * count); }

private:
    std::uint64_t state_;
};

/// z = sum of A sin(k . p + phase) about z = 0; flat without harmonics.
struct SineWater {
    struct Harmonic {
        double amplitude = 0, wavelength = 1, direction_deg = 0, phase = 0;
    };
    std::vector<Harmonic> harmonics;
    double ior_below = 1.333;

    struct Point {
        double height = 0;
        glm::dvec2 slope{0};
    };
    Point at(const glm::dvec2& p) const;
    double steepest() const;  ///< a bound on the slope
};

struct Ball {
    glm::dvec3 center{0};
    double radius = 1;
};
struct Box {
    glm::dvec3 min{0}, max{1};
};
/// Closed or not: light ends at the first triangle that it meets.
struct Triangles {
    std::vector<glm::dvec3> positions;
    std::vector<std::array<int, 3>> triangles;
    glm::dvec3 center{0};  ///< of a ball that holds them all
    double radius = 0;
};
using Solid = std::variant<Ball, Box, Triangles>;

/// A ball that holds the solid.
Ball hull(const Solid& solid);
/// Whether the ray meets the solid, ahead of its origin.
bool meets(const Solid& solid, const glm::dvec3& origin, const glm::dvec3& direction);
/// Area of the shadow on a horizontal plane behind a box or a ball in parallel light [m2]; `direction` is of travel.
double shadowArea(const Box& box, const glm::dvec3& direction);
double shadowArea(const Ball& ball, const glm::dvec3& direction);

/// A lumpy rock of 20 x 4^subdivisions triangles, `width` [m] across at most, about `center`; the same for the same
/// seed.
Triangles rock(const glm::dvec3& center, double width, int subdivisions, std::uint64_t seed);

/// What a solid under water takes out of a sun's light.
struct BlockedLight {
    double power = 0;                     ///< [W], after the surface
    glm::dvec2 low{1e300}, high{-1e300};  ///< where it would have landed on the plane z
};

/// Counts refracted rays on a square raster of `side` x `side` over the part of the water from which light may reach
/// the solid: accurate to 1e-3 or so at 600. The light falls from above along `direction` (unit) with 1 W/m2 across it;
/// waves do not shade one another.
BlockedLight blockedLight(const SineWater& water, const glm::dvec3& direction, const Solid& solid, double plane_z,
                          int side = 600);

/// Refracts a ray that travels along unit `in` at a surface of slope `slope`, from above.
/// @return unit direction below and transmittance; none where the light comes from behind the surface
struct Refracted {
    glm::dvec3 direction{0};
    double transmittance = 0;
};
std::optional<Refracted> refractDown(const glm::dvec3& in, const glm::dvec2& slope, double ior_below);

}  // namespace photic::truth
