// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace photic {

/// What an interface does to one ray.
struct Interface {
    glm::dvec3 refracted{0};   ///< unit direction; 0 at total internal reflection
    glm::dvec3 reflected{0};   ///< unit direction
    double transmittance = 0;  ///< unpolarised power transmittance, (Ts + Tp)/2; 0 at total reflection
};

/// Power transmittance of an interface for unpolarised light, (Ts + Tp)/2 (Born and Wolf, section 1.5).
/// @param cos_i, cos_t  of the angles of incidence and of refraction, > 0
inline double fresnelTransmittance(double cos_i, double cos_t, double ior_from, double ior_to) {
    const double r_s = (ior_from * cos_i - ior_to * cos_t) / (ior_from * cos_i + ior_to * cos_t);
    const double r_p = (ior_to * cos_i - ior_from * cos_t) / (ior_to * cos_i + ior_from * cos_t);
    return 1.0 - 0.5 * (r_s * r_s + r_p * r_p);
}

/// Snell's law and Fresnel's equations for unpolarised light (Born and Wolf, section 1.5).
///
/// @param direction  unit, of travel
/// @param normal     unit, on the side that the light comes from: dot(direction, normal) < 0
/// @param ior_from, ior_to  refractive indices, > 0
inline Interface interfaceAt(const glm::dvec3& direction, const glm::dvec3& normal, double ior_from, double ior_to) {
    Interface out;
    const double cos_i = std::clamp(-glm::dot(direction, normal), 0.0, 1.0);
    out.reflected = direction + 2.0 * cos_i * normal;
    const double eta = ior_from / ior_to;
    const double cos2_t = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
    if (cos2_t <= 0.0) return out;
    const double cos_t = std::sqrt(cos2_t);
    out.refracted = eta * direction + (eta * cos_i - cos_t) * normal;
    out.transmittance = fresnelTransmittance(cos_i, cos_t, ior_from, ior_to);
    return out;
}

}  // namespace photic
