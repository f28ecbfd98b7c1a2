// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <numbers>

#include "bake/optics/phase_function.h"
#include "bake/optics/snell.h"
#include "bake/picture/view_scene.h"
#include "bake/picture/volume_lookup.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

namespace {

constexpr double kPi = std::numbers::pi;
// Absorption of clean water at red, green and blue [1/m], rounded; tints pictures of scenes that set no medium.
constexpr glm::dvec3 kCleanWater{0.35, 0.07, 0.02};
// Rays reflected more than this often carry nothing that is seen.
constexpr int kMaxEvents = 6;

struct Rgba {
    glm::dvec3 colour{0};
    double alpha = 0;
};

/// A cheap integer hash (T. Wang) as a number in 0..1: the jitter must not depend on the threads.
double hashed(std::uint32_t seed) {
    seed = (seed ^ 61U) ^ (seed >> 16U);
    seed *= 9U;
    seed ^= seed >> 4U;
    seed *= 0x27d4eb2dU;
    seed ^= seed >> 15U;
    return seed / 4294967296.0;
}

/// Everything that one eye ray needs, shared by all pixels.
class ViewRenderer {
public:
    ViewRenderer(const Scene& scene, const LightVolume& volume, const ViewSettings& settings)
        : scene_(scene), settings_(settings), view_(scene), lookup_(volume), reference_(scene.referenceIrradiance()) {
        extinction_ = scene.medium.extinction();
        scattering_ = scene.medium.scattering;
        anisotropy_ = scene.medium.anisotropy;
        if (!scene.medium.present()) extinction_ = kCleanWater;
        if (settings.shaft_scattering) {
            extinction_ += *settings.shaft_scattering - scattering_;
            scattering_ = glm::dvec3(*settings.shaft_scattering);
        }
        // Straight on would be a mirror image of the sun, not a picture.
        anisotropy_ = std::clamp(settings.shaft_anisotropy.value_or(anisotropy_), -0.99, 0.99);
        for (const Light& light : scene.lights) {
            if (glm::length(light.irradiance) > glm::length(sun_irradiance_)) {
                sun_irradiance_ = light.irradiance;
                sun_direction_ = light.direction;
            }
        }
        sky_scale_ = 0.25 * reference_ / kPi;
        step_length_ = glm::length(scene.domain.max - scene.domain.min) / std::max(1, settings.march_steps);
    }

    Rgba trace(glm::dvec3 origin, glm::dvec3 direction, std::uint32_t seed) const {
        ViewInterval room = view_.clip(origin, direction);
        if (!room) return {};
        origin += std::max(0.0, room.enter) * direction;
        const bool straight = settings_.look == ViewLook::Cutaway;
        bool in_water = view_.inWater(origin);
        // The cut face of the water: a faint veil that gives the body of water an outline.
        const bool through_side = in_water && room.enter > 0;
        if (through_side && settings_.look == ViewLook::Natural) return {solidSide(origin), 1};
        Rgba result{through_side ? 0.03 * sky({0, 0, 1}) : glm::dvec3(0), 1};
        glm::dvec3 throughput(through_side ? 0.97 : 1.0);
        for (int event = 0; event < kMaxEvents; ++event) {
            room = view_.clip(origin, direction);
            const double end = room ? std::max(0.0, room.exit) : 0.0;
            const double surface =
                settings_.show_surface ? view_.surfaceDistance(origin, direction, end, in_water) : end;
            const ViewHit hit = view_.receiver(origin, direction, std::min(end, surface), room);
            const double length = std::min({end, surface, hit.distance});
            if (in_water) {
                result.colour +=
                    throughput * inScatter(origin, direction, length, seed + static_cast<std::uint32_t>(event));
                throughput *= glm::exp(-extinction_ * length);
            }
            const glm::dvec3 position = origin + length * direction;
            if (hit) {
                result.colour += throughput * receiverRadiance(position, hit, in_water);
                return result;
            }
            if (length >= end || !(surface < end)) {
                // Out of the room: open water below, the sky above; a ray that meets nothing at all shows the
                // background.
                if (in_water) {
                    result.colour += throughput * deepWater();
                } else if (event == 0) {
                    return {};
                } else {
                    result.colour += throughput * sky(direction);
                }
                return result;
            }
            straight ? passSurface(position, direction, in_water, throughput, result.colour, origin)
                     : crossSurface(position, direction, in_water, throughput, result.colour, origin);
            if (std::max({throughput.x, throughput.y, throughput.z}) < 2e-3) return result;
        }
        return result;
    }

private:
    /// A clear sky seen from the water's surface, with the sun's glitter. Linear radiance.
    glm::dvec3 sky(const glm::dvec3& direction) const {
        const double up = std::clamp(direction.z, 0.0, 1.0);
        glm::dvec3 colour =
            sky_scale_ * glm::mix(glm::dvec3(0.85, 0.92, 1.0), glm::dvec3(0.30, 0.52, 0.92), std::sqrt(up));
        // The sun as a lobe of about two degrees: its true disc would alias into specks.
        const double cosine = glm::dot(direction, -sun_direction_);
        const double width = glm::radians(2.0);
        if (cosine > 0) colour += 40.0 * sky_scale_ * std::exp(-(1 - cosine) / (0.5 * width * width));
        return colour;
    }

    glm::dvec3 deepWater() const { return sky_scale_ * glm::dvec3(0.02, 0.14, 0.22); }

    /// Light that single scattering in the water sends towards the eye along a stretch of the ray.
    glm::dvec3 inScatter(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                         std::uint32_t seed) const {
        if (scattering_ == glm::dvec3(0) || length <= 0) return glm::dvec3(0);
        const int steps = std::max(1, static_cast<int>(std::ceil(length / step_length_)));
        const double step = length / steps, jitter = hashed(seed);
        glm::dvec3 sum{0};
        for (int i = 0; i < steps; ++i) {
            const double distance = (i + jitter) * step;
            const LightSample light = lookup_.at(origin + distance * direction);
            const double mean = light.meanIrradiance(), flux = glm::length(light.flux);
            if (mean <= 0) continue;
            // Mixed directions act like a wider phase function: g x |direction|.
            const double concentration = std::min(1.0, flux / mean);
            const double cosine = flux > 0 ? glm::dot(light.flux, -direction) / flux : 0.0;
            sum += light.irradiance * henyeyGreenstein(cosine, anisotropy_ * concentration) *
                   glm::exp(-extinction_ * distance);
        }
        // A little of the skylight is scattered too: shadows in the water are not black.
        const glm::dvec3 skylight = settings_.ambient * reference_ / (4 * kPi) * glm::dvec3(0.5, 0.8, 1.0);
        return scattering_ * step * (sum + static_cast<double>(steps) * skylight);
    }

    glm::dvec3 receiverRadiance(const glm::dvec3& position, const ViewHit& hit, bool in_water) const {
        glm::dvec3 irradiance = lookup_.receiverIrradiance(position, hit.normal);
        const double facing = 0.5 + 0.5 * hit.normal.z;
        irradiance += settings_.ambient * reference_ * (0.4 + 0.6 * facing) * glm::dvec3(0.85, 0.95, 1.0);
        // Above the water the renderer, not the volume, adds direct light.
        if (!in_water && !view_.inWater(position))
            irradiance += sun_irradiance_ * std::max(0.0, -glm::dot(sun_direction_, hit.normal));
        return view_.albedo(position, hit.normal, settings_.albedo, settings_.tile_size) / kPi * irradiance;
    }

    /// The outside of the box in a natural look: a plain wall in skylight, a little darker away from the sun.
    glm::dvec3 solidSide(const glm::dvec3& position) const {
        const glm::dvec3 low = position - scene_.domain.min, high = scene_.domain.max - position;
        const double x = std::min(low.x, high.x), y = std::min(low.y, high.y);
        const glm::dvec3 normal =
            x < y ? glm::dvec3(low.x < high.x ? -1 : 1, 0, 0) : glm::dvec3(0, low.y < high.y ? -1 : 1, 0);
        const double lit = std::max(0.0, -glm::dot(sun_direction_, normal));
        return 0.25 / kPi * reference_ * (0.10 + 0.25 * lit) * glm::dvec3(0.95, 0.98, 1.0);
    }

    /// Goes straight through the surface, which reflects some of the sky.
    void passSurface(const glm::dvec3& position, const glm::dvec3& direction, bool& in_water, glm::dvec3& throughput,
                     glm::dvec3& colour, glm::dvec3& origin) const {
        const SurfaceView surface = view_.surfaceAt(position);
        if (!in_water) {
            const Interface split = interfaceAt(direction, surface.normal, surface.ior_above, surface.ior_below);
            colour += throughput * (1 - split.transmittance) * sky(split.reflected);
            throughput *= split.transmittance;
        }
        // A bright line where the surface is cut, or nobody sees where the water ends.
        const glm::dvec2 size(scene_.domain.max - scene_.domain.min), to_low(position - scene_.domain.min),
            to_high(scene_.domain.max - position);
        const double to_side = std::min({to_low.x, to_low.y, to_high.x, to_high.y});
        if (to_side < 0.004 * std::max(size.x, size.y)) {
            colour += 0.5 * throughput * 0.4 * reference_ / kPi * glm::dvec3(0.75, 0.92, 1.0);
            throughput *= 0.5;
        }
        in_water = !in_water;
        origin = position + surfaceOffset() * direction;
    }

    /// A step [m] that surely leaves the surface behind.
    double surfaceOffset() const { return 1e-6 * step_length_ * settings_.march_steps; }

    /// Refracts the ray through the surface, adding what the reflected branch sees; or reflects it when that is all.
    void crossSurface(const glm::dvec3& position, glm::dvec3& direction, bool& in_water, glm::dvec3& throughput,
                      glm::dvec3& colour, glm::dvec3& origin) const {
        const SurfaceView surface = view_.surfaceAt(position);
        const glm::dvec3 normal = glm::dot(direction, surface.normal) < 0 ? surface.normal : -surface.normal;
        const double from = in_water ? surface.ior_below : surface.ior_above;
        const double to = in_water ? surface.ior_above : surface.ior_below;
        const Interface split = interfaceAt(direction, normal, from, to);
        if (in_water) {
            // From below: Snell's window shows the sky; outside of it the ray goes on in the water.
            const double scale = split.transmittance * (from / to) * (from / to);
            if (split.transmittance > 0) colour += throughput * scale * sky(split.refracted);
            throughput *= 1 - split.transmittance;
            direction = split.reflected;
        } else {
            colour += throughput * (1 - split.transmittance) * sky(split.reflected);
            throughput *= split.transmittance * (from / to) * (from / to);
            direction = split.refracted;
            in_water = true;
        }
        origin = position + surfaceOffset() * direction;
    }

    const Scene& scene_;
    const ViewSettings& settings_;
    ViewScene view_;
    VolumeLookup lookup_;
    double reference_;
    glm::dvec3 extinction_{0}, scattering_{0};
    double anisotropy_ = 0;
    glm::dvec3 sun_direction_{0, 0, -1}, sun_irradiance_{0};
    double sky_scale_ = 0, step_length_ = 1;
};

}  // namespace

ViewSettings defaultView(const Scene& scene) {
    ViewSettings view;
    const glm::dvec3 size = scene.domain.max - scene.domain.min;
    const glm::dvec3 centre = 0.5 * (scene.domain.min + scene.domain.max);
    const double radius = 0.5 * glm::length(size);
    // Look into the open side, away from the walls; without walls a quarter turn off the sun shows shafts and floor.
    glm::dvec2 open_side(0);
    for (const Object& object : scene.objects) {
        const auto* plane = std::get_if<Plane>(&object.shape);
        if (plane && object.blocks()) open_side += glm::dvec2(plane->normal);
    }
    for (const Light& light : scene.lights) {
        const glm::dvec2 level(-light.direction.x, -light.direction.y);
        if (glm::length(open_side) < 0.05) open_side = {level.x * 0.5 - level.y * 0.87, level.y * 0.5 + level.x * 0.87};
    }
    if (glm::length(open_side) < 0.05) open_side = {-0.55, -0.85};
    // A little off the diagonal: corners don't line up.
    const glm::dvec2 side = glm::normalize(open_side);
    const glm::dvec2 turned(0.97 * side.x + 0.24 * side.y, 0.97 * side.y - 0.24 * side.x);
    view.target = centre - glm::dvec3(0, 0, 0.06 * size.z);
    const glm::dvec3 from = glm::normalize(glm::dvec3(turned, 0.8));
    view.eye = view.target + 0.96 * radius / std::sin(glm::radians(view.field_of_view_deg) / 2) * from;
    return view;
}

Image viewPicture(const Scene& scene, const LightVolume& volume, const ViewSettings& settings) {
    const glm::dvec3 forward_line = settings.target - settings.eye;
    if (!(glm::length(forward_line) > 0))
        throw Error(ErrorCode::Usage, "the camera's eye and target coincide; move one of them");
    if (settings.width < 1 || settings.height < 1 || settings.samples < 1) {
        throw Error(ErrorCode::Usage, "a view needs at least one pixel and one sample");
    }
    const ViewRenderer renderer(scene, volume, settings);
    const glm::dvec3 forward = glm::normalize(forward_line);
    const glm::dvec3 sky = std::fabs(forward.z) > 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, sky)), up = glm::cross(right, forward);
    const double half_height = std::tan(glm::radians(settings.field_of_view_deg) / 2);

    Image image{settings.width, settings.height, 4, {}};
    image.pixels.resize(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height) * 4);
    const int samples = settings.samples;
    parallelFor(settings.height, [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < settings.width; ++x) {
            Rgba sum;
            for (int s = 0; s < samples * samples; ++s) {
                const int across = s % samples, down = s / samples;
                const double dx = (x + (across + 0.5) / samples) * 2 - settings.width;
                const double dy = settings.height - (y + (down + 0.5) / samples) * 2;
                const glm::dvec3 direction =
                    glm::normalize(forward + half_height / settings.height * (dx * right + dy * up));
                const auto seed = static_cast<std::uint32_t>((y * settings.width + x) * samples * samples + s) * 8U;
                const Rgba ray = renderer.trace(settings.eye, direction, seed);
                sum.colour += ray.colour;
                sum.alpha += ray.alpha;
            }
            const double weight = 1.0 / (samples * samples);
            for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(sum.colour[c] * weight);
            image.at(x, y, 3) = static_cast<float>(sum.alpha * weight);
        }
    });
    return image;
}

}  // namespace photic
