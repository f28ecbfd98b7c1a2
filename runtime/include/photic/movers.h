// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shadows of what moves through baked light.
//
//     photic::runtime::Movers movers = photic::runtime::moversIn(volume.metadata());
//     movers.shapes = {photic::runtime::sphere({0, 0, -0.5}, 0.2)};
//     receivers->draw(g_buffer, target, {{&*light}}, {.movers = &movers});        // photic/runtime_gl.h
//     const photic::runtime::Vec3 e = irradiance(volume, place, normal, movers);  // the same on the CPU
//
// A bake knows nothing of what moves later. Here the light at a place is followed back along its own direction, as a
// narrow cone, and what a mover covers of the cone is taken off. What that leaves out: light that a mover would have
// scattered or reflected; where several sheets of light cross, each with a direction of its own, the mean one stands
// for all (docs/runtime.md says how far that is off). Nothing here needs GL.

#include <array>
#include <limits>
#include <vector>

#include "photic/result.h"
#include "photic/runtime.h"

namespace photic::runtime {

enum class MoverShape { Sphere, Box };

/// Something opaque that moves.
struct Mover {
    MoverShape shape = MoverShape::Sphere;
    Vec3 centre;        ///< [m]
    double radius = 0;  ///< of a sphere [m]
    Vec3 half_axes[3];  ///< of a box: from its centre to the middles of three of its sides, at right angles [m]
};
Mover sphere(const Vec3& centre, double radius);
Mover box(const Vec3& centre, const Vec3& half_x, const Vec3& half_y, const Vec3& half_z);

/// Movers of any shape, drawn once as the light sees them: for each texel how far along the light they begin and end.
/// In GL: all of them drawn by an orthographic camera to an RG32F texture that was cleared to -1e9, with
/// glBlendEquation(GL_MAX) and the colour (-depth, depth), so that no order and no second pass is needed.
struct MoverMap {
    Vec3 corner;                ///< of the map's rectangle, at depth 0 [m]
    Vec3 across, up;            ///< its sides [m], at right angles
    Vec3 direction;             ///< unit, of the light's travel or near it: depth counts along it; across both sides
    int columns = 0, rows = 0;  ///< 0: there is no map
    double nearest = 0, farthest = 0;  ///< depths between which all movers are [m]
    /// For the CPU: -nearest and farthest depth of each texel [m], rows of `across`, the first along `across` itself;
    /// what covers nothing is -1e9 twice. Read during calls only; may be null where only the GPU looks.
    const float* depths = nullptr;
};

/// What darkens baked light, and what is known of that light's way.
struct Movers {
    static constexpr int kMostShapes = 32;

    std::vector<Mover> shapes;
    MoverMap map;
    int map_steps = 24;  ///< of the march of one ray through the map
    int map_rays = 12;   ///< of a cone
    /// Where light is bent, as Metadata::surface: followed back, it turns there. Infinite w: nowhere.
    double surface[4] = {0, 0, 1, std::numeric_limits<double>::infinity()};
    /// Of travel, of the one light above the surface, any length; 0: what floats above it darkens nothing.
    Vec3 sun;
    double angular_diameter_deg = 0.53;  ///< of the light: the least width of a shadow's edge
    double ior = 1;                      ///< below the surface, by which the light's angle is narrower there
    /// Where light comes from many sides, |flux| is less than the irradiance, and shadows are washed out so much. 0 to
    /// 1: what part of that is believed; 0 gives edges as sharp as the sun's disc everywhere, and farther from a
    /// bake's.
    double spread = 1;
    double reach = 1e4;  ///< [m] along the light up to which movers are looked for
    /// [m] within which nothing darkens. A shape's own skin, from 0.9 to 1.02 of its size, it leaves lit by itself;
    /// what is on a map needs a bias of about what depths on it are off by.
    double bias = 1e-3;
};

/// No movers yet, in the light of a volume: its surface and its index.
Movers moversIn(const Metadata& metadata);

/// Part, 0 to 1, of the light at a place that passes all movers.
/// @param flux  there, along the light's travel; @param mean  irradiance there, in the same unit
double passesMovers(const Movers& movers, const Vec3& world, const Vec3& flux, double mean);

/// Volume::sample and Volume::irradiance with shadows, lobe by lobe.
Light sample(const Volume& volume, const Vec3& world, const Movers& movers);
Vec3 irradiance(const Volume& volume, const Vec3& world, const Vec3& normal, const Movers& movers);

/// The uniform block of photic_movers.glsl, for games that bind it themselves (docs/volume_bytes.md).
using MoverBytes = std::array<unsigned char, 128 + 128 * 16>;
/// @return Error{Usage} for more than kMostShapes, or numbers that make no sense
Result<MoverBytes> packMovers(const Movers& movers);

}  // namespace photic::runtime
