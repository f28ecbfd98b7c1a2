// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/scene_shapes.h"

#include <array>
#include <mutex>
#include <utility>
#include <variant>
#include <vector>

namespace photic {
namespace {

/// All that shapes depend on. Meshes are told by where they are: whoever holds the shapes holds them too.
struct ShapeKey {
    const void* mesh = nullptr;
    std::array<double, 6> numbers{};  ///< of a plane or a sphere
    int index = 0;
    bool is_object = false;
    bool operator==(const ShapeKey&) const = default;
};

std::vector<ShapeKey> keysOf(const Scene& scene) {
    std::vector<ShapeKey> keys;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        const Surface& surface = scene.surfaces[i];
        if (!surface.mesh && !surface.sphere) continue;
        ShapeKey key{surface.mesh.get(), {}, static_cast<int>(i), false};
        if (surface.sphere) {
            const glm::dvec3& c = surface.sphere->center;
            key.numbers = {c.x, c.y, c.z, surface.sphere->radius, 1};
        }
        keys.push_back(key);
    }
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (!object.blocks()) continue;
        ShapeKey key{nullptr, {}, static_cast<int>(i), true};
        if (const auto* plane = std::get_if<Plane>(&object.shape)) {
            const glm::dvec3 &p = plane->point, &n = plane->normal;
            key.numbers = {p.x, p.y, p.z, n.x, n.y, n.z};
        } else {
            key.mesh = std::get<1>(object.shape).get();
        }
        keys.push_back(key);
    }
    return keys;
}

struct LastShapes {
    std::mutex mutex;
    std::vector<ShapeKey> keys;
    std::weak_ptr<const SceneShapes> shapes;
    std::shared_ptr<const SceneShapes> held;  ///< while there are holders
    int holders = 0;
};

LastShapes& lastShapes() {
    static LastShapes last;
    return last;
}

}  // namespace

std::shared_ptr<const SceneShapes> shapesOf(const Scene& scene) {
    std::vector<ShapeKey> keys = keysOf(scene);
    LastShapes& last = lastShapes();
    {
        const std::lock_guard lock(last.mutex);
        if (auto shapes = last.shapes.lock(); shapes && last.keys == keys) return shapes;
    }
    auto built = std::make_shared<const SceneShapes>(scene);
    const std::lock_guard lock(last.mutex);
    last.keys = std::move(keys), last.shapes = built;
    if (last.holders > 0) last.held = built;
    return built;
}

HeldShapes::HeldShapes() {
    LastShapes& last = lastShapes();
    const std::lock_guard lock(last.mutex);
    if (last.holders++ == 0) last.held = last.shapes.lock();
}

HeldShapes::~HeldShapes() {
    LastShapes& last = lastShapes();
    std::shared_ptr<const SceneShapes> released;  // after the lock
    const std::lock_guard lock(last.mutex);
    if (--last.holders == 0) released = std::move(last.held);
}

}  // namespace photic
