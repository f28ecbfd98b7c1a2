// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/field/density.h"

namespace photic {

ViewScene::ViewScene(const Scene& scene) : scene_(scene) {
    for (const Surface& surface : scene.surfaces) {
        if (surface.height_field && surface.event != SurfaceEvent::Reflect && !water_) water_ = &surface;
    }
    if (!water_) return;
    // A third of a feature finds every crossing that is seen; the voxel bounds it for surfaces of finer detail.
    const HeightField& heights = *water_->height_field;
    const double relief = heights.maxZ() - heights.minZ();
    const double feature =
        std::isfinite(heights.featureSize()) ? heights.featureSize() : glm::length(scene.domain.max - scene.domain.min);
    march_step_ = std::max({feature / 3, scene.domain.voxel_size / 2, relief / 64, 1e-9});
}

ViewInterval ViewScene::clip(const glm::dvec3& origin, const glm::dvec3& direction) const {
    ViewInterval room{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), -1};
    const auto cut = [&](double height, double rate, int object) {
        // Inside where height + t * rate >= 0.
        if (rate == 0) {
            if (height < 0) room.exit = -std::numeric_limits<double>::infinity();
        } else if (rate > 0) {
            room.enter = std::max(room.enter, -height / rate);
        } else if (-height / rate < room.exit) {
            room.exit = -height / rate;
            room.exit_object = object;
        }
    };
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const auto* plane = std::get_if<Plane>(&scene_.objects[i].shape);
        if (!plane || !scene_.objects[i].blocks()) continue;
        cut(glm::dot(origin - plane->point, plane->normal), glm::dot(direction, plane->normal), static_cast<int>(i));
    }
    for (int axis = 0; axis < 3; ++axis) {
        cut(origin[axis] - scene_.domain.min[axis], direction[axis], -1);
        cut(scene_.domain.max[axis] - origin[axis], -direction[axis], -1);
    }
    return room;
}

ViewHit ViewScene::receiver(const glm::dvec3& origin, const glm::dvec3& direction, double limit,
                            const ViewInterval& room) const {
    ViewHit hit;
    // A tolerance: the exit is also where `limit` lies when nothing else is in the way.
    if (room.exit_object >= 0 && room.exit <= limit * (1 + 1e-12)) {
        hit.distance = room.exit;
        hit.object = room.exit_object;
        hit.normal = std::get<Plane>(scene_.objects[static_cast<std::size_t>(room.exit_object)].shape).normal;
    }
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const auto* plane = std::get_if<Plane>(&scene_.objects[i].shape);
        if (!plane || scene_.objects[i].role != Role::Movable) continue;
        const double rate = glm::dot(direction, plane->normal);
        const double t = rate == 0 ? -1 : glm::dot(plane->point - origin, plane->normal) / rate;
        if (t > 1e-9 && t < limit && t < hit.distance)
            hit = {t, static_cast<int>(i), rate < 0 ? plane->normal : -plane->normal};
    }
    return hit;
}

double ViewScene::heightAbove(const glm::dvec3& position) const {
    return position.z - surfaceAbove(*water_->height_field, position).position.z;
}

bool ViewScene::inWater(const glm::dvec3& position) const { return water_ && heightAbove(position) < 0; }

double ViewScene::surfaceDistance(const glm::dvec3& origin, const glm::dvec3& direction, double limit,
                                  bool from_below) const {
    if (!water_) return limit;
    // Only the stretch between the surface's lowest and highest point can cross it.
    double begin = 0, end = limit;
    const double low = water_->height_field->minZ() - 1e-9, high = water_->height_field->maxZ() + 1e-9;
    if (direction.z != 0) {
        const double a = (low - origin.z) / direction.z, b = (high - origin.z) / direction.z;
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    } else if (origin.z < low || origin.z > high) {
        return limit;
    }
    if (begin >= end) return limit;
    const double sign = from_below ? 1 : -1;  // positive once the ray is on the other side
    const int steps = std::clamp(static_cast<int>(std::ceil((end - begin) / march_step_)), 1, 4096);
    double inside = begin;
    for (int step = 1; step <= steps; ++step) {
        double outside = begin + (end - begin) * step / steps;
        if (sign * heightAbove(origin + outside * direction) <= 0) {
            inside = outside;
            continue;
        }
        for (int halving = 0; halving < 30; ++halving) {
            const double middle = 0.5 * (inside + outside);
            (sign * heightAbove(origin + middle * direction) <= 0 ? inside : outside) = middle;
        }
        return std::min(limit, outside);
    }
    return limit;
}

SurfaceView ViewScene::surfaceAt(const glm::dvec3& position) const {
    return {glm::normalize(surfaceAbove(*water_->height_field, position).normal), water_->ior_above, water_->ior_below};
}

glm::dvec3 ViewScene::albedo(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& base,
                             double tile_size) const {
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

}  // namespace photic
