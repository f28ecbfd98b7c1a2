// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_shading.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>

#include "bake/optics/phase_function.h"

namespace photic {

namespace {

constexpr double kPi = std::numbers::pi;
// Absorption of clean water at red, green and blue [1/m], rounded; tints pictures of scenes that set no medium.
constexpr glm::dvec3 kCleanWater{0.35, 0.07, 0.02};

/// A cheap integer hash (T. Wang) as a number in 0..1: the jitter must not depend on the threads.
double hashed(std::uint32_t seed) {
    seed = (seed ^ 61U) ^ (seed >> 16U);
    seed *= 9U;
    seed ^= seed >> 4U;
    seed *= 0x27d4eb2dU;
    seed ^= seed >> 15U;
    return seed / 4294967296.0;
}

/// Tiles with darker joints and a slight variation from tile to tile; plain without a size.
glm::dvec3 tiled(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& base, double tile_size) {
    if (!(tile_size > 0)) return base;
    const int axis = std::fabs(normal.x) > 0.7 ? 0 : std::fabs(normal.y) > 0.7 ? 1 : 2;
    const glm::dvec2 place = glm::dvec2(position[(axis + 1) % 3], position[(axis + 2) % 3]) / tile_size;
    const glm::dvec2 tile = glm::floor(place), within = place - tile;
    const double joint = 0.035;
    if (std::min({within.x, within.y, 1 - within.x, 1 - within.y}) < joint / 2) return 0.62 * base;
    // The usual shader hash: any fixed pattern will do.
    const double hash = std::sin(tile.x * 12.9898 + tile.y * 78.233 + axis * 37.7) * 43758.5453;
    return base * (0.93 + 0.07 * (hash - std::floor(hash)));
}

}  // namespace

ViewShading::ViewShading(const Scene& scene, const LightVolume& volume, const ViewSettings& settings)
    : scene_(scene), settings_(settings), lookup_(volume), reference_(scene.referenceIrradiance()) {
    water_ = hazeOf(scene.medium.extinction(), scene.medium.scattering, scene.medium.anisotropy);
    if (!scene.medium.present()) water_.extinction += kCleanWater;
    for (const Light& light : scene.lights) {
        if (glm::length(light.irradiance) > glm::length(sun_irradiance_)) {
            sun_irradiance_ = light.irradiance;
            sun_direction_ = light.direction;
        }
    }
    sky_scale_ = 0.25 * reference_ / kPi;
    step_length_ = glm::length(scene.domain.max - scene.domain.min) / std::max(1, settings.march_steps);
}

Haze ViewShading::hazeOf(const glm::dvec3& extinction, const glm::dvec3& scattering, double anisotropy) const {
    Haze haze{extinction, scattering, anisotropy};
    if (settings_.shaft_scattering) {
        haze.extinction += *settings_.shaft_scattering - haze.scattering;
        haze.scattering = glm::dvec3(*settings_.shaft_scattering);
    }
    // Straight on would be a mirror image of the sun, not a picture.
    haze.anisotropy = std::clamp(settings_.shaft_anisotropy.value_or(haze.anisotropy), -0.99, 0.99);
    return haze;
}

glm::dvec3 ViewShading::sky(const glm::dvec3& direction) const {
    const double up = std::clamp(direction.z, 0.0, 1.0);
    glm::dvec3 colour = sky_scale_ * glm::mix(glm::dvec3(0.85, 0.92, 1.0), glm::dvec3(0.30, 0.52, 0.92), std::sqrt(up));
    // The sun as a lobe of about two degrees: its true disc would alias into specks.
    const double cosine = glm::dot(direction, -sun_direction_);
    const double width = glm::radians(2.0);
    if (cosine > 0) colour += 40.0 * sky_scale_ * std::exp(-(1 - cosine) / (0.5 * width * width));
    return colour;
}

glm::dvec3 ViewShading::deepWater() const { return sky_scale_ * glm::dvec3(0.02, 0.14, 0.22); }

glm::dvec3 ViewShading::inScatter(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                                  const Haze& haze, std::uint32_t seed) const {
    if (haze.scattering == glm::dvec3(0) || length <= 0) return glm::dvec3(0);
    const int steps = std::max(1, static_cast<int>(std::ceil(length / step_length_)));
    const double step = length / steps, jitter = hashed(seed);
    glm::dvec3 sum{0};
    for (int i = 0; i < steps; ++i) {
        const double distance = (i + jitter) * step;
        for (int lobe = 0; lobe < lookup_.lobes(); ++lobe) {
            const LookedUpLight light = lookup_.at(origin + distance * direction, lobe);
            const double mean = light.meanIrradiance(), flux = glm::length(light.flux);
            if (mean <= 0) continue;
            // Mixed directions act like a wider phase function: g x |direction|.
            const double concentration = std::min(1.0, flux / mean);
            const double cosine = flux > 0 ? glm::dot(light.flux, -direction) / flux : 0.0;
            sum += light.irradiance * henyeyGreenstein(cosine, haze.anisotropy * concentration) *
                   glm::exp(-haze.extinction * distance);
        }
    }
    // A little of the skylight is scattered too: shadows in the water are not black.
    const glm::dvec3 skylight = settings_.ambient * reference_ / (4 * kPi) * glm::dvec3(0.5, 0.8, 1.0);
    return haze.scattering * step * (sum + static_cast<double>(steps) * skylight);
}

glm::dvec3 ViewShading::receiver(const glm::dvec3& position, const glm::dvec3& normal, int object,
                                 const glm::dvec3& direct) const {
    glm::dvec3 irradiance = lookup_.receiverIrradiance(position, normal) + direct;
    const double facing = 0.5 + 0.5 * normal.z;
    irradiance += settings_.ambient * reference_ * (0.4 + 0.6 * facing) * glm::dvec3(0.85, 0.95, 1.0);
    const glm::dvec3 own = scene_.objects[static_cast<std::size_t>(object)].albedo.value_or(settings_.albedo);
    return tiled(position, normal, own, settings_.tile_size) / kPi * irradiance;
}

}  // namespace photic
