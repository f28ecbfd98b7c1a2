// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/optical_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/optics/beer_lambert.h"
#include "bake/paths/height_field_hit.h"

namespace photic {
namespace {

// Sides of the box around a mesh.
glm::dvec3 boxAround(const TriangleMesh* mesh) {
    if (!mesh || mesh->positions.empty()) return glm::dvec3(0);
    glm::dvec3 low = mesh->positions.front(), high = low;
    for (const glm::dvec3& p : mesh->positions) low = glm::min(low, p), high = glm::max(high, p);
    return high - low;
}

}  // namespace

glm::dvec3 countLeg(const OpticalMedium& medium, const glm::dvec3& power, double length, double PowerLedger::*end,
                    PowerLedger& ledger) {
    glm::dvec3 left = power;
    if (!medium.clear())
        for (int c = 0; c < 3; ++c) {
            const double extinction = medium.absorption[c] + medium.scattering[c];
            if (extinction <= 0) continue;
            const double depth = extinction * length;
            // 1 - exp(-depth), without cancellation; everything for a leg without end.
            const double lost = std::isfinite(depth) ? power[c] * depth * meanTransmittance(depth) : power[c];
            ledger.absorbed_medium += lost * medium.absorption[c] / extinction / 3;
            ledger.scattered += lost * medium.scattering[c] / extinction / 3;
            left[c] = power[c] - lost;
        }
    ledger.*end += channelMean(left);
    return left;
}

OpticalScene::OpticalScene(const Scene& scene, const GridFrame& frame, const std::vector<double>& wavelengths_nm,
                           double behind_walls, LoneWater lone_water)
    : scene_(scene), frame_(frame), shapes_(shapesOf(scene)), light_end_(scene, frame, shapes_->caster, behind_walls) {
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        const Surface& surface = scene.surfaces[i];
        MediumSides sides;
        sides.outside = mediumFor(sideOf(scene, surface, Side::Above), wavelengths_nm);
        sides.inside = mediumFor(sideOf(scene, surface, Side::Below), wavelengths_nm);
        sides.nested = surface.medium_below >= 0 && (surface.closed || surface.sphere.has_value()) && !surface.thin;
        sides_.push_back(sides);
        boxes_.push_back(boxAround(surface.mesh.get()));
        const bool is_met = lone_water == LoneWater::IsMet || scene.surfaces.size() > 1;
        if (surface.height_field && is_met) height_fields_.push_back(static_cast<int>(i));
        own_shadows_.push_back(OwnShadow::of(scene, surface, frame));
    }
    for (const Light& light : scene.lights) {
        const double radius = 0.5 * light.angular_diameter_deg * std::numbers::pi / 180;
        if (!light.position && radius > 0 && caster().planeParts(light.direction, radius))
            parted_suns_.push_back({light.direction, radius});
        int water = -1;
        for (std::size_t i = 0; i < scene.surfaces.size() && water < 0; ++i)
            if (standsBelow(light, scene.surfaces[i])) water = sides_[i].inside;
        waters_.push_back(water);
    }
}

// The water that a lamp stands in, or -1; a rectangle's points are nearest to its own centre.
int OpticalScene::waterAround(const glm::dvec3& source) const {
    int water = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
        if (!scene_.lights[i].position) continue;
        const double distance = glm::length(*scene_.lights[i].position - source);
        if (distance < nearest) nearest = distance, water = waters_[i];
    }
    return water;
}

int OpticalScene::mediumFor(const Medium& medium, const std::vector<double>& wavelengths_nm) {
    const auto same = [&](const Medium& other) {
        return medium.name == other.name && medium.absorption == other.absorption &&
               medium.scattering == other.scattering && medium.anisotropy == other.anisotropy &&
               medium.priority == other.priority && medium.ior.mean() == other.ior.mean() &&
               medium.ior.atChannels() == other.ior.atChannels();
    };
    const auto known = std::find_if(given_media_.begin(), given_media_.end(), same);
    if (known != given_media_.end()) return static_cast<int>(known - given_media_.begin());
    OpticalMedium out;
    out.absorption = medium.absorption, out.scattering = medium.scattering;
    out.anisotropy = medium.anisotropy, out.priority = medium.priority;
    out.iors.push_back(medium.ior.mean());
    for (const double nm : wavelengths_nm) out.iors.push_back(medium.ior.at(nm));
    out.disperses = medium.ior.disperses() && !wavelengths_nm.empty();
    media_.push_back(std::move(out)), given_media_.push_back(medium);
    return static_cast<int>(media_.size()) - 1;
}

MediumStack OpticalScene::startingInside(int surface, const glm::dvec3& direction, const glm::dvec3& face,
                                         const std::optional<glm::dvec3>& source) const {
    const bool from_outside = glm::dot(direction, face) < 0;
    const MediumSides& sides = this->sides(surface);
    MediumStack stack;
    stack.base = static_cast<std::int16_t>(from_outside || sides.nested ? sides.outside : sides.inside);
    if (const int water = source ? waterAround(*source) : -1; water >= 0) stack.base = static_cast<std::int16_t>(water);
    // Light that stands inside of a closed body.
    return from_outside || !sides.nested ? stack : across(stack, surface, true);
}

int OpticalScene::mediumOf(const MediumStack& inside) const {
    int best = inside.base;
    for (int i = 0; i < inside.count; ++i)
        if (i == 0 || medium(inside.media[i]).priority >= medium(best).priority) best = inside.media[i];
    return best;
}

MediumStack OpticalScene::across(const MediumStack& inside, int surface, bool inwards) const {
    const MediumSides& sides = this->sides(surface);
    MediumStack out = inside;
    if (!sides.nested) {
        out.base = static_cast<std::int16_t>(inwards ? sides.inside : sides.outside);
        return out;
    }
    if (inwards) {
        if (out.count < MediumStack::kMost) out.media[out.count++] = static_cast<std::int16_t>(sides.inside);
        return out;
    }
    for (int i = out.count - 1; i >= 0; --i)
        if (out.media[i] == sides.inside) {
            for (int k = i; k + 1 < out.count; ++k) out.media[k] = out.media[k + 1];
            --out.count;
            break;
        }
    return out;
}

Meeting OpticalScene::meetingOnMesh(const Surface& surface, const RayHit& hit, const glm::dvec3& point) const {
    if (surface.sphere) {
        const glm::dvec3 normal = glm::normalize(point - surface.sphere->center);
        return {surface.sphere->center + surface.sphere->radius * normal, normal, normal};
    }
    const TriangleMesh& mesh = *surface.mesh;
    const auto& t = mesh.triangles[hit.triangle];
    const glm::dvec3 cross =
        glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    const glm::dvec3 face = glm::length(cross) > 0 ? glm::normalize(cross) : hit.normal;
    if (!surface.smooth) return {point, face, face};
    const double wb = hit.barycentric.x, wc = hit.barycentric.y;
    const glm::dvec3 normal = (1 - wb - wc) * mesh.normals[t[0]] + wb * mesh.normals[t[1]] + wc * mesh.normals[t[2]];
    const double length = glm::length(normal);
    return {point, length > 0 && glm::dot(normal, face) > 0 ? normal / length : face, face};
}

RayHit OpticalScene::firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double max_distance,
                              Meeting& meeting, EndlessPlanes planes) const {
    RayHit hit = caster().firstHit(origin, direction, max_distance, planes);
    bool on_water = false;
    for (const int i : height_fields_) {
        const Surface& surface = scene_.surfaces[static_cast<std::size_t>(i)];
        const double feature = std::min(1.0, surface.height_field->featureSize());
        const HeightFieldHit at =
            hitHeightField(surface, origin, direction, 1e-12 * glm::length(origin) + 1e-6 * feature,
                           std::min(hit.distance, max_distance));
        if (!(at.distance < std::min(hit.distance, max_distance))) continue;
        hit = {at.distance,
               {Target::Kind::Surface, i},
               0,
               glm::dvec2(0),
               glm::dot(at.normal, direction) < 0 ? at.normal : -at.normal};
        meeting = {at.position, at.normal, at.normal}, on_water = true;
    }
    if (hit.target.kind == Target::Kind::Surface && !on_water)
        meeting = meetingOnMesh(scene_.surfaces[static_cast<std::size_t>(hit.target.index)], hit,
                                origin + hit.distance * direction);
    return hit;
}

const glm::dvec3* OpticalScene::partedSun(const glm::dvec3& direction) const {
    for (const PartedSun& sun : parted_suns_)
        if (glm::length(direction - sun.middle) <= sun.radius) return &sun.middle;
    return nullptr;
}

PathOutcome OpticalScene::arrival(const glm::dvec3& point, const glm::dvec3& direction,
                                  const std::optional<glm::dvec3>& source) const {
    if (caster().empty() && height_fields_.empty()) return PathOutcome::Lit;
    Meeting unused;
    const double reach = source ? glm::length(point - *source) : std::numeric_limits<double>::infinity();
    const glm::dvec3* sun = source ? nullptr : partedSun(direction);
    if (sun && caster().planeStandsBefore(point, *sun)) return PathOutcome::Blocked;
    const EndlessPlanes planes = sun ? EndlessPlanes::LeftOut : EndlessPlanes::Met;
    const RayHit back = firstHit(point, -direction, reach, unused, planes);
    if (!back) return PathOutcome::Lit;
    // Something stands between. What light meets first decides: an object keeps it, a surface has launched it.
    const double far = source ? reach : caster().reachFrom(point) + back.distance + 1;
    const RayHit first = firstHit(point - far * direction, direction, far * (1 - 1e-12), unused, planes);
    const Target::Kind kind = first ? first.target.kind : back.target.kind;
    return kind == Target::Kind::Surface ? PathOutcome::Hidden : PathOutcome::Blocked;
}

PathOutcome OpticalScene::arrivalOn(int surface, const glm::dvec3& point, const glm::dvec3& direction,
                                    const std::optional<glm::dvec3>& source) const {
    const PathOutcome outcome = arrival(point, direction, source);
    const OwnShadow* shadow = ownShadow(surface);
    // Waves are looked for between a point and the sky: what comes from below does not pass them.
    if (outcome != PathOutcome::Lit || !shadow || direction.z > 0) return outcome;
    const double reach = source ? glm::length(point - *source) : std::numeric_limits<double>::infinity();
    return shadow->covers(point, direction, reach) ? PathOutcome::Hidden : outcome;
}

OpticalScene::LegEnd OpticalScene::legEnd(const glm::dvec3& origin, const glm::dvec3& direction,
                                          const MediumStack& inside) const {
    LegEnd end{{}, std::numeric_limits<double>::infinity(), {}, inside};
    if (caster().empty() && height_fields_.empty()) return end;
    constexpr int kMostVoidSurfaces = 64;
    glm::dvec3 from = origin;
    double passed = 0;
    for (int i = 0; i < kMostVoidSurfaces; ++i) {
        end.hit = firstHit(from, direction, std::numeric_limits<double>::infinity(), end.meeting);
        if (end.hit.target.kind != Target::Kind::Surface) break;
        const int surface = end.hit.target.index;
        if (!sides(surface).nested && end.inside.count == 0) break;
        const Event event = eventAt(surface, 0, end.inside, direction, end.meeting);
        if (!event.void_surface) break;
        passed += end.hit.distance, from = end.meeting.position, end.inside = event.beyond;
    }
    if (end.hit) end.hit.distance += passed;
    end.deposit_end = light_end_.distance(origin, direction, end.hit);
    return end;
}

}  // namespace photic
