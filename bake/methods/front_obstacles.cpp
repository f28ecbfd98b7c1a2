// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/front_obstacles.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/paths/convex_region.h"
#include "bake/threads/parallel_for.h"

namespace photic {

bool standsBefore(const RayCaster& caster, const LightSample& sample, const glm::dvec3& place) {
    if (caster.empty()) return false;
    constexpr double kEverywhere = std::numeric_limits<double>::infinity();
    if (!sample.source)
        return caster.planeStandsBefore(place, sample.light ? sample.light->direction : sample.direction) ||
               caster.firstHit(place, -sample.direction, kEverywhere, EndlessPlanes::LeftOut);
    const glm::dvec3 way = *sample.source - place;
    return bool(caster.firstHit(place, glm::normalize(way), glm::length(way)));
}

FrontObstacles::FrontObstacles(const Scene& scene, const GridFrame& frame, const glm::ivec3& low,
                               const glm::ivec3& high, const OpticalScene* optics)
    : frame_(frame),
      low_(low),
      high_(high),
      blocks_((high - low) / kCells + 1),
      optics_(optics),
      caster_(scene),
      light_end_(scene, frame_, caster_),
      tree_(scene) {
    if (!empty()) findBlocks(scene);
}

std::size_t FrontObstacles::blockOf(const glm::dvec3& voxel) const {
    const glm::ivec3 b = glm::clamp(glm::ivec3(glm::floor((voxel + 0.5 - glm::dvec3(low_)) / double(kCells))),
                                    glm::ivec3(0), blocks_ - 1);
    return (static_cast<std::size_t>(b.z) * static_cast<std::size_t>(blocks_.y) + static_cast<std::size_t>(b.y)) *
               static_cast<std::size_t>(blocks_.x) +
           static_cast<std::size_t>(b.x);
}

void FrontObstacles::findBlocks(const Scene& scene) {
    near_.assign(
        static_cast<std::size_t>(blocks_.x) * static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(blocks_.z),
        0);
    // Each block with half of those beside it: a ray's way within a layer is no longer than that.
    parallelFor(blocks_.z, [&](std::int64_t z) {
        for (int y = 0; y < blocks_.y; ++y)
            for (int x = 0; x < blocks_.x; ++x) {
                const glm::dvec3 first = glm::dvec3(low_ + kCells * glm::ivec3(x, y, static_cast<int>(z))) - 0.5;
                ConvexRegion region;
                for (int corner = 0; corner < 8; ++corner)
                    region.include(frame_.worldFromIndex(first + double(kCells) * glm::dvec3(corner & 1 ? 1.5 : -0.5,
                                                                                             corner & 2 ? 1.5 : -0.5,
                                                                                             corner & 4 ? 1.5 : -0.5)));
                const glm::dvec3 middle = 0.5 * (region.low + region.high), half = 0.5 * (region.high - region.low);
                bool any = !tree_.empty() && tree_.reaches(region);
                for (const Object& object : scene.objects)
                    if (const Plane* plane = std::get_if<Plane>(&object.shape); plane && object.blocks())
                        any = any || std::fabs(glm::dot(middle - plane->point, plane->normal)) <=
                                         glm::dot(half, glm::abs(plane->normal));
                for (const Surface& surface : scene.surfaces) {
                    if (!surface.height_field) continue;
                    const glm::dvec2 reach = 0.5 * surface.size + surface.height_field->maxDisplacement() +
                                             glm::dvec2(half),
                                     beside = glm::abs(glm::dvec2(middle - surface.center));
                    const bool above = surface.outside != Outside::None || (beside.x <= reach.x && beside.y <= reach.y);
                    any = any || (above && middle.z - half.z <= surface.height_field->maxZ() &&
                                  middle.z + half.z >= surface.height_field->minZ());
                }
                near_[blockOf(first + 0.5 * kCells)] = any ? 1 : 0;
            }
    });
}

RayHit FrontObstacles::firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double most,
                                Meeting& meeting) const {
    return optics_ ? optics_->firstHit(origin, direction, most, meeting) : caster_.firstHit(origin, direction, most);
}

/// @param length  [m] of the way
FrontObstacles::Hit FrontObstacles::describe(const glm::dvec3& start, const glm::dvec3& direction, const RayHit& hit,
                                             double length) const {
    return {hit.distance / length,
            light_end_.distance(start, direction, hit) / length,
            glm::normalize(frame_.indexNormal(hit.normal)),
            false,
            hit.target,
            {},
            {}};
}

std::optional<FrontObstacles::Hit> FrontObstacles::onWay(const glm::dvec3& from, const glm::dvec3& to,
                                                         const Start& start, const MediumStack& inside) const {
    // A first way may be long, to the layer by which light comes in.
    constexpr double kShort = 4;
    const double voxels = glm::distance(from, to);
    if (voxels < kShort && !near_[blockOf(from)] && !near_[blockOf(to)]) return {};
    if (!(voxels > 0)) return {};
    // From a hair before the place, where the way before has ended: faces that a ray starts on are not met. A ray that
    // leaves a surface has nothing before it.
    constexpr double kBefore = 0.01, kHair = 2e-3;  // of the way; voxels
    const double before = start.surface < 0 ? kBefore : std::min(kBefore, glm::distance(from, start.voxel) / voxels);
    const glm::dvec3 place = frame_.worldFromIndex(from), way = frame_.worldFromIndex(to) - place,
                     origin = place - before * way;
    const double length = glm::length(way);
    const glm::dvec3 direction = way / length;
    double passed = 0;
    for (int i = 0; i < 2; ++i) {
        Meeting meeting;
        RayHit hit = firstHit(origin + passed * direction, direction, (1 + before) * length - passed, meeting);
        if (!hit) return {};
        hit.distance += passed;
        const glm::dvec3 at = from + (hit.distance / length - before) * (to - from);
        // What it leaves, met again by rounding.
        if (hit.target == Target{Target::Kind::Surface, start.surface} && glm::distance(at, start.voxel) < kHair) {
            passed = hit.distance + kHair * length / voxels;
            if (passed >= (1 + before) * length) return {};
            continue;
        }
        Hit out = describe(origin, direction, hit, length);
        out.at -= before, out.deposit -= before;
        out.meeting = meeting, out.inside = inside;
        constexpr double kTouches = 1e-3;
        for (int a = 0; a < 3; ++a)
            out.beside = out.beside || at[a] < low_[a] - 0.5 - kTouches || at[a] > high_[a] + 0.5 + kTouches;
        return out;
    }
    return {};
}

glm::dvec3 FrontObstacles::exitOf(const glm::dvec3& voxel, const glm::dvec3& direction) const {
    double end = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) continue;
        const double side = direction[a] > 0 ? high_[a] + 0.5 : low_[a] - 0.5;
        end = std::min(end, std::max(0.0, (side - voxel[a]) / direction[a]));
    }
    return std::isfinite(end) ? voxel + end * direction : voxel;
}

std::optional<FrontObstacles::Hit> FrontObstacles::straightOn(const Start& start, const glm::dvec3& to,
                                                              const MediumStack& inside) const {
    const glm::dvec3 place = frame_.worldFromIndex(start.voxel), way = frame_.worldFromIndex(to) - place;
    const double length = glm::length(way), voxels = glm::distance(start.voxel, to);
    if (!(length > 0)) return {};
    const glm::dvec3 direction = way / length;
    constexpr int kMostVoidSurfaces = 64;
    constexpr double kHair = 2e-3;  // voxels
    MediumStack here = inside;
    double passed = 0;
    for (int i = 0; i < kMostVoidSurfaces && passed < length; ++i) {
        Meeting meeting;
        RayHit hit = firstHit(place + passed * direction, direction, length - passed, meeting);
        if (!hit) return {};
        hit.distance += passed;
        const double hair = kHair * length / voxels;
        if (hit.target.kind == Target::Kind::Surface) {
            if (hit.target.index == start.surface && hit.distance < hair) {
                passed = hit.distance + hair;
                continue;
            }
            const OpticalScene::Event event = optics_->eventAt(hit.target.index, 0, here, direction, meeting);
            if (event.void_surface) {
                passed = hit.distance + 1e-3 * hair, here = event.beyond;
                continue;
            }
        }
        Hit out = describe(place, direction, hit, length);
        out.meeting = meeting, out.inside = here;
        return out;
    }
    return {};
}

bool FrontObstacles::standsBetween(const std::array<std::array<glm::dvec3, 3>, 3>& rays, int surface,
                                   bool anywhere) const {
    if (tree_.empty()) return false;
    constexpr double kNarrow = 0.2;  // voxels: finer than that nothing is looked for
    double width = 0;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t i = 0; i < 3; ++i) width = std::max(width, glm::distance(rays[r][i], rays[(r + 1) % 3][i]));
    if (width < kNarrow) return false;
    bool near = anywhere;
    for (const auto& ray : rays)
        for (const glm::dvec3& place : ray) near = near || near_[blockOf(place)] != 0;
    if (!near) return false;
    ConvexRegion region;
    std::array<glm::dvec3, 9> points;
    for (std::size_t i = 0; i < 9; ++i)
        points[i] = frame_.worldFromIndex(rays[i / 3][i % 3]), region.include(points[i]);
    for (std::size_t r = 0; r < 3; ++r) {
        const glm::dvec3 &from = points[3 * r], &beside = points[3 * ((r + 1) % 3)],
                         &opposite = points[3 * ((r + 2) % 3)];
        const glm::dvec3 normal = glm::cross(beside - from, points[3 * r + 2] - from);
        region.addSide(glm::dot(normal, opposite - from) > 0 ? -normal : normal, points);
    }
    return tree_.reaches(region, surface < 0 ? Target{} : Target{Target::Kind::Surface, surface});
}

}  // namespace photic
