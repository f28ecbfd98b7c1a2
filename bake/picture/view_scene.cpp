// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/view_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/field/density.h"

namespace photic {
namespace {

// The normal that the mesh's own tell, on the side that the ray comes from.
glm::dvec3 smoothNormal(const TriangleMesh& mesh, const RayHit& hit, const glm::dvec3& direction) {
    const auto& t = mesh.triangles[hit.triangle];
    if (mesh.normals.empty()) return hit.normal;
    const double b = hit.barycentric.x, c = hit.barycentric.y;
    glm::dvec3 normal = (1 - b - c) * mesh.normals[t[0]] + b * mesh.normals[t[1]] + c * mesh.normals[t[2]];
    const double length = glm::length(normal);
    if (!(length > 0)) return hit.normal;
    normal /= glm::dot(normal, hit.normal) < 0 ? -length : length;
    // Where a smooth normal faces away the flat one is what the eye sees.
    return glm::dot(normal, direction) < 0 ? normal : hit.normal;
}

}  // namespace

MeshView::MeshView(const Scene& scene) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        if (std::holds_alternative<Plane>(scene.objects[i].shape)) continue;
        scene_.objects.push_back(scene.objects[i]);
        scene_.objects.back().role = Role::Receiver;  // movables are seen too
        number_.push_back(static_cast<int>(i));
    }
    if (!number_.empty()) caster_.emplace(scene_);
    offset_ = 1e-5 * glm::length(scene.domain.max - scene.domain.min);
}

ViewHit MeshView::hit(const glm::dvec3& origin, const glm::dvec3& direction, double limit) const {
    if (!caster_) return {};
    const RayHit hit = caster_->firstHit(origin, direction, limit);
    if (!hit) return {};
    const auto index = static_cast<std::size_t>(hit.target.index);
    const TriangleMesh& mesh = *std::get<std::shared_ptr<const TriangleMesh>>(scene_.objects[index].shape);
    return {hit.distance, number_[index], smoothNormal(mesh, hit, direction)};
}

ViewScene::ViewScene(const Scene& scene) : scene_(scene), meshes_(std::make_unique<MeshView>(scene)) {
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
    const ViewHit mesh = meshes_->hit(origin, direction, std::min(limit, hit.distance));
    return mesh ? mesh : hit;
}

double ViewScene::heightAbove(const glm::dvec3& position) const {
    return position.z - surfaceAbove(*water_->height_field, position).position.z;
}

bool ViewScene::seesSun(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& direction) const {
    return !meshes_->hit(position + meshes_->offset() * normal, -direction, std::numeric_limits<double>::infinity());
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

}  // namespace photic
