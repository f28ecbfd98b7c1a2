// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/ernst_fans.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <unordered_map>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

// A ray that is steeper against a plane than this has no place in it: sine of the angle between them.
constexpr double kAlongThePlane = 0.02;

bool comesThrough(const FanRay& ray, const glm::dvec3& normal) {
    return glm::dot(normal, ray.along) > kAlongThePlane * glm::length(normal) * glm::length(ray.along);
}

// The ray with its start in the plane alpha = 0, along which alpha grows by 1 [figure 5; section 3.2: r_y = 1].
FanRay projected(const FanRay& ray, const glm::dvec3& origin, const glm::dvec3& normal) {
    const glm::dvec3 along = ray.along / glm::dot(normal, ray.along);
    return {ray.start - glm::dot(normal, ray.start - origin) * along, along};
}

// Corners are one vertex where they are as near as this [voxels], and go the same way.
constexpr double kOnePlace = 1.0 / 1024, kOneWay = 1e-4;

struct PlaceHash {
    std::size_t operator()(const std::array<std::int64_t, 3>& place) const {
        std::uint64_t hash = 0;
        for (const std::int64_t value : place) {
            hash = (hash ^ static_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15ull;
            hash ^= hash >> 31;
        }
        return static_cast<std::size_t>(hash);
    }
};

class Vertices {
public:
    std::uint32_t of(const FanRay& ray) {
        std::array<std::int64_t, 3> place;
        for (int a = 0; a < 3; ++a) place[static_cast<std::size_t>(a)] = std::llround(ray.start[a] / kOnePlace);
        std::vector<std::uint32_t>& here = known_[place];
        const glm::dvec3 way = glm::normalize(ray.along);
        for (const std::uint32_t vertex : here)
            if (glm::length(ways_[vertex] - way) < kOneWay) return vertex;
        here.push_back(static_cast<std::uint32_t>(ways_.size()));
        ways_.push_back(way);
        return here.back();
    }
    std::size_t count() const { return ways_.size(); }

private:
    std::unordered_map<std::array<std::int64_t, 3>, std::vector<std::uint32_t>, PlaceHash> known_;
    std::vector<glm::dvec3> ways_;
};

FanRay indexRay(const TubeSet& set, std::uint32_t corner) {
    const CornerRay& c = set.corners[corner];
    const auto axes = axesFor(set.axis);
    FanRay ray{};
    ray.start[axes[0]] = c.u, ray.start[axes[1]] = c.v, ray.start[axes[2]] = c.w;
    ray.along[axes[0]] = set.sense * c.du_dw, ray.along[axes[1]] = set.sense * c.dv_dw, ray.along[axes[2]] = set.sense;
    return ray;
}

// A tube's plane and rays, without its fans.
ErnstTube inOwnPlane(const FanTube& tube, int axis, int sense) {
    ErnstTube out;
    out.origin = tube.ray[0].start;
    out.normal = glm::cross(tube.ray[1].start - out.origin, tube.ray[2].start - out.origin);
    if (glm::dot(out.normal, tube.ray[0].along) < 0) out.normal = -out.normal;
    if (out.normal == glm::dvec3(0)) return out;
    for (const FanRay& ray : tube.ray)
        if (!comesThrough(ray, out.normal)) {
            out.normal = glm::dvec3(0);
            out.normal[axis] = sense;
            break;
        }
    for (int i = 0; i < 3; ++i) {
        out.ray[i] = projected(tube.ray[i], out.origin, out.normal);
        out.opens[i] = glm::dot(out.normal, tube.ray[i].start - out.origin);
    }
    return out;
}

}  // namespace

FanArea flattenedFan(std::span<const FanTube> fan, const glm::dvec3& origin, const glm::dvec3& normal) {
    FanArea sum;
    const double per_square = 1 / glm::dot(normal, normal);
    for (const FanTube& tube : fan) {
        if (!comesThrough(tube.ray[0], normal) || !comesThrough(tube.ray[1], normal) ||
            !comesThrough(tube.ray[2], normal))
            continue;
        FanRay ray[3];
        for (int i = 0; i < 3; ++i) ray[i] = projected(tube.ray[i], origin, normal);
        // [section 3.4] k and l lie in the plane; both products are along its normal.
        const glm::dvec3 k1 = ray[1].start - ray[0].start, k2 = ray[2].start - ray[0].start,
                         l1 = ray[1].along - ray[0].along, l2 = ray[2].along - ray[0].along;
        const auto area = [&](const glm::dvec3& p, const glm::dvec3& q) {
            return 0.5 * glm::dot(normal, glm::cross(p, q)) * per_square;
        };
        sum.power += tube.power;
        sum.a += area(k1, k2), sum.b += area(k1, l2) + area(l1, k2), sum.c += area(l1, l2);
    }
    return sum;
}

ErnstFans::ErnstFans(std::span<const TubeSet> sets) {
    struct Place {
        std::uint32_t vertex[3];
        int axis, sense;
    };
    std::vector<FanTube> all;
    std::vector<Place> places;
    Vertices vertices;
    for (const TubeSet& set : sets) {
        first_.push_back(all.size());
        all.resize(all.size() + set.tubes.size()), places.resize(all.size());
        for (const TubeBlock& block : set.blocks)
            for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
                const std::size_t at = first_.back() + block.first_tube + t;
                all[at].power = set.tubes[block.first_tube + t].power[0];
                places[at].axis = set.axis, places[at].sense = set.sense;
                for (int i = 0; i < 3; ++i) {
                    all[at].ray[i] = indexRay(set, block.first_corner + block.topology->triangles[t].corner[i]);
                    places[at].vertex[i] = vertices.of(all[at].ray[i]);
                }
            }
    }
    std::vector<std::vector<FanTube>> fans(vertices.count());
    for (std::size_t t = 0; t < all.size(); ++t) {
        // A tube whose rays end on different things is laid once for each of them: one triangle all the same.
        const bool again = t > 0 && std::equal(places[t].vertex, places[t].vertex + 3, places[t - 1].vertex);
        for (const std::uint32_t vertex : places[t].vertex) {
            if (again)
                fans[vertex].back().power += all[t].power;
            else
                fans[vertex].push_back(all[t]);
        }
    }
    tubes_.resize(all.size());
    parallelFor(static_cast<std::int64_t>(all.size()), [&](std::int64_t index) {
        const auto t = static_cast<std::size_t>(index);
        ErnstTube& tube = tubes_[t] = inOwnPlane(all[t], places[t].axis, places[t].sense);
        if (tube.normal == glm::dvec3(0)) return;
        for (int i = 0; i < 3; ++i) tube.fan[i] = flattenedFan(fans[places[t].vertex[i]], tube.origin, tube.normal);
    });
}

}  // namespace photic
