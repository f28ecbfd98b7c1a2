// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/front_obstacles.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/paths/convex_region.h"
#include "bake/threads/parallel_for.h"

namespace photic {

bool standsBefore(const RayCaster& caster, const LightSample& sample, const glm::dvec3& place) {
    if (caster.empty()) return false;
    if (!sample.source) return bool(caster.firstHit(place, -sample.direction));
    const glm::dvec3 way = *sample.source - place;
    return bool(caster.firstHit(place, glm::normalize(way), glm::length(way)));
}

FrontObstacles::FrontObstacles(const Scene& scene, const GridFrame& frame, const glm::ivec3& low,
                               const glm::ivec3& high)
    : frame_(frame),
      low_(low),
      high_(high),
      blocks_((high - low) / kCells + 1),
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
                near_[blockOf(first + 0.5 * kCells)] = any ? 1 : 0;
            }
    });
}

std::optional<FrontObstacles::Hit> FrontObstacles::onWay(const glm::dvec3& from, const glm::dvec3& to) const {
    if (!near_[blockOf(from)] && !near_[blockOf(to)]) return {};
    // From a hair before the place, where the way before has ended: faces that a ray starts on are not met.
    constexpr double kBefore = 0.01;
    const glm::dvec3 place = frame_.worldFromIndex(from), way = frame_.worldFromIndex(to) - place,
                     start = place - kBefore * way;
    const double length = glm::length(way);
    if (!(length > 0)) return {};
    const RayHit hit = caster_.firstHit(start, way / length, (1 + kBefore) * length);
    if (!hit) return {};
    Hit out{hit.distance / length - kBefore, light_end_.distance(start, way / length, hit) / length - kBefore,
            glm::normalize(frame_.indexNormal(hit.normal)), false, hit.target};
    const glm::dvec3 at = glm::mix(from, to, out.at);
    constexpr double kHair = 1e-3;
    for (int a = 0; a < 3; ++a)
        out.beside = out.beside || at[a] < low_[a] - 0.5 - kHair || at[a] > high_[a] + 0.5 + kHair;
    return out;
}

bool FrontObstacles::standsBetween(const std::array<std::array<glm::dvec3, 3>, 3>& rays) const {
    if (tree_.empty()) return false;
    constexpr double kNarrow = 0.2;  // voxels: finer than that nothing is looked for
    double width = 0;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t i = 0; i < 3; ++i) width = std::max(width, glm::distance(rays[r][i], rays[(r + 1) % 3][i]));
    if (width < kNarrow) return false;
    bool near = false;
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
    return tree_.reaches(region);
}

}  // namespace photic
