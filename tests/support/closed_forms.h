// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>

/// Closed forms of focused light, in double, that the methods are measured against. They share no code with the baker.
namespace photic::truth {

/// Unpolarised power transmittance of a plane interface (Born and Wolf, section 1.5); 0 at total reflection.
/// @param cos_in  cosine of the angle of incidence, 0..1
double fresnelTransmittance(double cos_in, double ior_from, double ior_to);

/// Light under flat water.
struct PlaneWater {
    double irradiance = 1;  ///< across the beam, in air [W/m2]
    double cos_in = 1;      ///< of the sun's zenith angle
    double ior_above = 1, ior_below = 1.333;
    double extinction = 0;  ///< [1/m]

    double cosBelow() const;
    /// Irradiance on a horizontal plane `depth` [m] below the surface [W/m2].
    double horizontal(double depth) const;
    /// Fluence rate averaged over depths [top, bottom] [W/m2].
    double meanFluence(double top, double bottom) const;
    /// Irradiance on horizontal planes averaged over depths [top, bottom] [W/m2].
    double meanHorizontal(double top, double bottom) const;
};

/// Fold caustic X(xi) = edge + b xi^2 / 2, lit by E0 per unit xi from both sides.
struct Fold {
    double e0 = 1, b = 1, edge = 0;
    double at(double x) const;                       ///< 2 E0 / sqrt(2 b (x - edge)); 0 on the dark side
    double mean(double x_low, double x_high) const;  ///< over a cell: bounded
};

/// Cusp caustic X(u, z) = u (1 - z/f) + c u^3, c > 0, lit by E0 per unit u.
struct Cusp {
    double e0 = 1, f = 1, c = 1;
    double at(double x, double z) const;
    double mean(double x_low, double x_high, double z) const;
    /// Half width of the region with three arrivals at z > f; 0 before it.
    double halfWidth(double z) const;
};

/// Circular mirror of radius R about the origin. Parallel light that travels along +x is reflected at R (cos p, sin p)
/// and touches the caustic (nephroid) at this point.
glm::dvec2 nephroid(double radius, double p);
/// The same for a source on the circle at (-R, 0).
glm::dvec2 cardioid(double radius, double p);
/// Distance along the reflected ray from a circular mirror to the tangential focus of parallel light.
double mirrorFocus(double radius, double cos_in);
/// Distance to the tangential focus from a source at distance s: 1/s + 1/s' = 2/(R cos i).
double mirrorFocus(double radius, double cos_in, double source_distance);

/// Paraboloid mirror of focal length f in light along its axis.
struct ParabolicMirror {
    double e0 = 1, f = 1;
    /// Distance from the focus to the mirror along a ray that leaves the axis at angle psi (0 towards the vertex).
    double mirrorDistance(double psi) const;
    /// Irradiance across the ray at distance rho from the focus.
    double at(double rho, double psi) const;
};

}  // namespace photic::truth
