// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/glass_view.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "bake/field/density.h"
#include "bake/paths/emission.h"

namespace photic {
namespace {

// Rays that carry less than this are not seen.
constexpr double kLeast = 0.001;
constexpr int kMostEvents = 12;

Scene asEyesMeetIt(const Scene& scene) {
    Scene out = scene;
    for (Surface& surface : out.surfaces)
        if (surface.event != SurfaceEvent::Mirror) surface.event = SurfaceEvent::Both;
    for (Object& object : out.objects) object.role = Role::Receiver;
    return out;
}

double strongest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

}  // namespace

GlassView::GlassView(const Scene& scene, const GridFrame& frame, const ViewShading& shading)
    : scene_(asEyesMeetIt(scene)),
      optics_(scene_, frame),
      shading_(shading),
      size_(glm::length(scene.domain.max - scene.domain.min)) {}

Rgba GlassView::trace(const glm::dvec3& origin, const glm::dvec3& direction, std::uint32_t seed) const {
    EyeRay ray{origin, direction};
    ray.inside = insideAt(origin), ray.seed = seed;
    Rgba out{glm::dvec3(0), 1};
    follow(ray, out);
    return out;
}

// The media that the eye stands in. Closed bodies are counted along a ray to the outside.
MediumStack GlassView::insideAt(const glm::dvec3& eye) const {
    MediumStack inside;
    for (std::size_t i = 0; i < scene_.surfaces.size(); ++i) {
        const Surface& surface = scene_.surfaces[i];
        const MediumSides& sides = optics_.sides(static_cast<int>(i));
        if (i == 0) inside.base = static_cast<std::int16_t>(sides.outside);
        if (surface.height_field && eye.z < surfaceAbove(*surface.height_field, eye).position.z)
            inside.base = static_cast<std::int16_t>(sides.inside);
        if (surface.sphere && glm::length(eye - surface.sphere->center) < surface.sphere->radius)
            inside = optics_.across(inside, static_cast<int>(i), true);
    }
    return inside;
}

bool GlassView::isSeen(const RayHit& hit, const glm::dvec3& position, const glm::dvec3& direction) const {
    if (hit.target.kind != Target::Kind::Object) return true;
    const auto* plane = std::get_if<Plane>(&scene_.objects[static_cast<std::size_t>(hit.target.index)].shape);
    if (!plane) return true;
    if (glm::dot(plane->normal, direction) > 0) return false;
    const glm::dvec3 margin(1e-6 * size_);
    return glm::all(glm::greaterThanEqual(position, scene_.domain.min - margin)) &&
           glm::all(glm::lessThanEqual(position, scene_.domain.max + margin));
}

GlassView::Leg GlassView::nextMeeting(const EyeRay& ray) const {
    constexpr int kMostUnseen = 64;
    Leg leg;
    leg.inside = ray.inside;
    glm::dvec3 from = ray.origin;
    double passed = 0;
    for (int i = 0; i < kMostUnseen; ++i) {
        leg.end = optics_.legEnd(from, ray.direction, leg.inside);
        leg.length = passed + leg.end.hit.distance;
        if (!leg.end.hit) return leg;
        if (isSeen(leg.end.hit, ray.origin + leg.length * ray.direction, ray.direction)) return leg;
        leg.inside = leg.end.inside;
        passed = leg.length + 1e-9 * size_;
        from = ray.origin + passed * ray.direction;
    }
    leg.end.hit = {};
    return leg;
}

// What the leg's medium takes and scatters, inside the domain.
void GlassView::addHaze(const EyeRay& ray, const Leg& leg, glm::dvec3& throughput, Rgba& out) const {
    const OpticalMedium& medium = optics_.medium(optics_.mediumOf(ray.inside));
    const Haze haze = shading_.hazeOf(medium.extinction(), medium.scattering, medium.anisotropy);
    if (haze.extinction == glm::dvec3(0)) return;
    double begin = 0, end = leg.length;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = ray.direction[axis];
        if (d == 0) continue;
        const double a = (scene_.domain.min[axis] - ray.origin[axis]) / d;
        const double b = (scene_.domain.max[axis] - ray.origin[axis]) / d;
        begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
    }
    if (!(end > begin)) return;
    out.colour += throughput * shading_.inScatter(ray.origin + begin * ray.direction, ray.direction, end - begin, haze,
                                                  ray.seed + static_cast<std::uint32_t>(ray.events));
    throughput *= glm::exp(-haze.extinction * (end - begin));
}

glm::dvec3 GlassView::direct(const glm::dvec3& position, const glm::dvec3& normal) const {
    glm::dvec3 sum(0);
    const glm::dvec3 from = position + 1e-6 * size_ * normal;
    for (const Light& light : scene_.lights) {
        const LightSample sample = lightSamples(light, 1).front();
        const Emission emission(scene_, 0, sample);
        const glm::dvec3 travel = emission.directionAt(from);
        const double facing = -glm::dot(travel, normal);
        if (facing <= 0 || optics_.arrival(from, travel, sample.source) != PathOutcome::Lit) continue;
        sum += facing * emission.irradianceAt(from);
    }
    return sum;
}

void GlassView::follow(const EyeRay& given, Rgba& out) const {
    EyeRay ray = given;
    const Leg leg = nextMeeting(ray);
    addHaze(ray, leg, ray.throughput, out);
    if (!leg.end.hit) {
        if (ray.mirrored)
            out.colour += ray.throughput * shading_.sky(ray.direction);
        else
            out.alpha -= std::min(1.0, (ray.throughput.x + ray.throughput.y + ray.throughput.z) / 3);
        return;
    }
    if (leg.end.hit.target.kind == Target::Kind::Surface) return meetSurface(ray, leg, out);
    const glm::dvec3 position = ray.origin + leg.length * ray.direction, normal = leg.end.hit.normal;
    out.colour +=
        ray.throughput * shading_.receiver(position, normal, leg.end.hit.target.index, direct(position, normal));
}

void GlassView::meetSurface(const EyeRay& ray, const Leg& leg, Rgba& out) const {
    if (ray.events >= kMostEvents) return;
    const OpticalScene::Event event =
        optics_.eventAt(leg.end.hit.target.index, 0, leg.end.inside, ray.direction, leg.end.meeting);
    EyeRay next = ray;
    next.origin = leg.end.meeting.position, next.inside = leg.end.inside, ++next.events;
    if (event.void_surface) {
        next.inside = event.beyond;
        return follow(next, out);
    }
    const double here = optics_.medium(optics_.mediumOf(leg.end.inside)).iors[0];
    for (int b = 0; b < event.light.count; ++b) {
        const SpecularBranch& branch = event.light.branches[static_cast<std::size_t>(b)];
        EyeRay on = next;
        on.direction = branch.direction, on.throughput = ray.throughput * branch.fraction;
        if (branch.crosses) {
            on.inside = event.beyond;
            const double there = optics_.medium(optics_.mediumOf(event.beyond)).iors[0];
            on.throughput *= (here / there) * (here / there);
        } else {
            on.mirrored = true;
        }
        if (strongest(on.throughput) >= kLeast) follow(on, out);
    }
}

}  // namespace photic
