// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/numerics/height_table.h"

namespace photic {

/// A front that starts on a height field and goes on below it through constant slowness.
struct FrontOnSurface {
    const HeightTable* surface = nullptr;
    /// Arrival at a point of the surface: gradient . point [m of optical path]. 0: the surface itself is the front.
    glm::dvec3 gradient{0};
    double slowness = 1;  ///< below, > 0; at least |gradient| along the surface
    /// Where `outside` > 0 the light comes from a point instead: the arrival is outside |point - source|.
    glm::dvec3 source{0};
    double outside = 0;

    /// Gradient of the arrival in space, at a place of the surface.
    glm::dvec3 gradientAt(const glm::dvec3& place) const {
        return outside > 0 ? outside * glm::normalize(place - source) : gradient;
    }
};

/// Layers of points: origin + i * step_x + j * step_y + k * step_z, the layers of constant z, k = 0 the highest.
struct PointLayers {
    glm::dvec3 origin{0};
    double step_x = 1, step_y = 1;
    glm::dvec3 step_z{0, 0, -1};
    int count_x = 0, count_y = 0, count_z = 0;
};

/// First arrivals in one layer, in rows with space between them; point (i, j) lies at index at(i, j). Points above the
/// surface, and those on it to rounding, have arrival = foot_arrival = kAboveSurface.
struct FootPointLayer {
    static constexpr double kAboveSurface = 1e60;
    static constexpr std::size_t kBetween = 8;  ///< a register

    FootPointLayer(int count_x, int count_y);
    std::size_t at(std::size_t i, std::size_t j) const { return (j + 1) * pitch + kBetween + i; }

    std::size_t pitch;
    std::vector<double> foot_x, foot_y;        ///< where the first ray leaves the surface [m]
    std::vector<double> foot_z, foot_arrival;  ///< height and arrival there [m]
    std::vector<double> slope_x, slope_y;      ///< of the surface there
    std::vector<double> arrival;               ///< [m of optical path]
    std::vector<double> distance;              ///< from the foot [m]
    std::vector<double> curvature;             ///< of the front, div of its direction [1/m]
    std::vector<double> spread;                ///< area of a bundle of rays over that at the foot
};

/// First arrival at every point of the layers, from the top down: T(x) = min over y of gradient . y + slowness |x - y|
/// (Hopf and Lax), by Newton's method from the foot of the point above, so that Snell's law holds at every foot.
///
/// A minimum may be local: the feet of the neighbours in the layer above and then in the layer itself are tried, and
/// the best taken. Curvature and spread follow from the second derivatives at the foot: with A the Hessian of the
/// arrival that leaves out the growth of |x - y|, P the surface's metric across the ray and K = P^-1 A / slowness,
/// curvature = tr(K (1 + s K)^-1) and spread = det(1 + s K) at distance s.
///
/// @param visit  called for each layer in turn; returning false ends the sweep
/// Cost: 30 to 60 ns a point on one core; memory for three layers. Arrivals are right to 1e-7 of step_x and better.
void sweepFootPoints(const FrontOnSurface& front, const PointLayers& points,
                     const std::function<bool(int layer, const FootPointLayer&)>& visit);

}  // namespace photic
