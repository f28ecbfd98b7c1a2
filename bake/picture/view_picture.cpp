// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <memory>
#include <numbers>

#include "bake/optics/snell.h"
#include "bake/picture/glass_view.h"
#include "bake/picture/view_scene.h"
#include "bake/picture/view_shading.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

namespace {

constexpr double kPi = std::numbers::pi;
// Rays reflected more than this often carry nothing that is seen.
constexpr int kMaxEvents = 6;

/// Everything that one eye ray needs, shared by all pixels.
class ViewRenderer {
public:
    ViewRenderer(const Scene& scene, const ViewShading& shading, const ViewSettings& settings)
        : scene_(scene), shading_(shading), settings_(settings), view_(scene) {}

    Rgba trace(glm::dvec3 origin, glm::dvec3 direction, std::uint32_t seed) const {
        ViewInterval room = view_.clip(origin, direction);
        if (!room) return {};
        origin += std::max(0.0, room.enter) * direction;
        const bool straight = settings_.look == ViewLook::Cutaway;
        bool in_water = view_.inWater(origin);
        // The cut face of the water: a faint veil that gives the body of water an outline.
        const bool through_side = in_water && room.enter > 0;
        if (through_side && settings_.look == ViewLook::Natural) return {solidSide(origin), 1};
        Rgba result{through_side ? 0.03 * shading_.sky({0, 0, 1}) : glm::dvec3(0), 1};
        glm::dvec3 throughput(through_side ? 0.97 : 1.0);
        for (int event = 0; event < kMaxEvents; ++event) {
            room = view_.clip(origin, direction);
            const double end = room ? std::max(0.0, room.exit) : 0.0;
            const double surface =
                settings_.show_surface ? view_.surfaceDistance(origin, direction, end, in_water) : end;
            const ViewHit hit = view_.receiver(origin, direction, std::min(end, surface), room);
            const double length = std::min({end, surface, hit.distance});
            if (in_water) {
                result.colour += throughput * shading_.inScatter(origin, direction, length, shading_.water(),
                                                                 seed + static_cast<std::uint32_t>(event));
                throughput *= glm::exp(-shading_.water().extinction * length);
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
                    result.colour += throughput * shading_.deepWater();
                } else if (event == 0) {
                    return {};
                } else {
                    result.colour += throughput * shading_.sky(direction);
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
    glm::dvec3 receiverRadiance(const glm::dvec3& position, const ViewHit& hit, bool in_water) const {
        // Above the water the renderer, not the volume, adds direct light.
        glm::dvec3 direct(0);
        if (!in_water && !view_.inWater(position) && view_.seesSun(position, hit.normal, shading_.sunDirection()))
            direct = shading_.sunIrradiance() * std::max(0.0, -glm::dot(shading_.sunDirection(), hit.normal));
        return shading_.receiver(position, hit.normal, hit.object, direct);
    }

    /// The outside of the box in a natural look: a plain wall in skylight, a little darker away from the sun.
    glm::dvec3 solidSide(const glm::dvec3& position) const {
        const glm::dvec3 low = position - scene_.domain.min, high = scene_.domain.max - position;
        const double x = std::min(low.x, high.x), y = std::min(low.y, high.y);
        const glm::dvec3 normal =
            x < y ? glm::dvec3(low.x < high.x ? -1 : 1, 0, 0) : glm::dvec3(0, low.y < high.y ? -1 : 1, 0);
        const double lit = std::max(0.0, -glm::dot(shading_.sunDirection(), normal));
        return 0.25 / kPi * shading_.reference() * (0.10 + 0.25 * lit) * glm::dvec3(0.95, 0.98, 1.0);
    }

    /// Goes straight through the surface, which reflects some of the sky.
    void passSurface(const glm::dvec3& position, const glm::dvec3& direction, bool& in_water, glm::dvec3& throughput,
                     glm::dvec3& colour, glm::dvec3& origin) const {
        const SurfaceView surface = view_.surfaceAt(position);
        if (!in_water) {
            const Interface split = interfaceAt(direction, surface.normal, surface.ior_above, surface.ior_below);
            colour += throughput * (1 - split.transmittance) * shading_.sky(split.reflected);
            throughput *= split.transmittance;
        }
        // A bright line where the surface is cut, or nobody sees where the water ends.
        const glm::dvec2 size(scene_.domain.max - scene_.domain.min), to_low(position - scene_.domain.min),
            to_high(scene_.domain.max - position);
        const double to_side = std::min({to_low.x, to_low.y, to_high.x, to_high.y});
        if (to_side < 0.004 * std::max(size.x, size.y)) {
            colour += 0.5 * throughput * 0.4 * shading_.reference() / kPi * glm::dvec3(0.75, 0.92, 1.0);
            throughput *= 0.5;
        }
        in_water = !in_water;
        origin = position + surfaceOffset() * direction;
    }

    /// A step [m] that surely leaves the surface behind.
    double surfaceOffset() const { return 1e-6 * shading_.stepLength() * settings_.march_steps; }

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
            if (split.transmittance > 0) colour += throughput * scale * shading_.sky(split.refracted);
            throughput *= 1 - split.transmittance;
            direction = split.reflected;
        } else {
            colour += throughput * (1 - split.transmittance) * shading_.sky(split.reflected);
            throughput *= split.transmittance * (from / to) * (from / to);
            direction = split.refracted;
            in_water = true;
        }
        origin = position + surfaceOffset() * direction;
    }

    const Scene& scene_;
    const ViewShading& shading_;
    const ViewSettings& settings_;
    ViewScene view_;
};

using EyeRay = std::function<Rgba(const glm::dvec3& origin, const glm::dvec3& direction, std::uint32_t seed)>;

/// Water and planes are seen as the settings' look says; where glass or mirrors stand, eye rays follow them.
EyeRay eyeRays(const Scene& scene, const LightVolume& volume, const ViewShading& shading,
               const ViewSettings& settings) {
    // Water that is an open mesh is looked through as if it were not there.
    const bool glass = std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [](const Surface& surface) {
        return surface.mesh && (surface.closed || surface.sphere || surface.event == SurfaceEvent::Mirror);
    });
    if (glass) {
        const auto view = std::make_shared<GlassView>(scene, volume.field.frame(), shading);
        return [view](const glm::dvec3& o, const glm::dvec3& d, std::uint32_t seed) { return view->trace(o, d, seed); };
    }
    const auto view = std::make_shared<ViewRenderer>(scene, shading, settings);
    return [view](const glm::dvec3& o, const glm::dvec3& d, std::uint32_t seed) { return view->trace(o, d, seed); };
}

}  // namespace

ViewSettings defaultView(const Scene& scene) {
    ViewSettings view;
    if (!scene.cameras.empty()) {
        const Camera& camera = scene.cameras.front();
        view.eye = camera.position, view.target = camera.target, view.up = camera.up;
        view.field_of_view_deg = camera.field_of_view_deg;
        return view;
    }
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
    const ViewShading shading(scene, volume, settings);
    const EyeRay follow = eyeRays(scene, volume, shading, settings);
    const glm::dvec3 forward = glm::normalize(forward_line);
    const bool along = glm::length(glm::cross(forward, settings.up)) < 0.04;
    const glm::dvec3 sky = along ? glm::dvec3(0, 1, 0) : settings.up;
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
                const Rgba ray = follow(settings.eye, direction, seed);
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
