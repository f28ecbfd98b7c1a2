// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bake/scene/scene.h"

namespace photic {

/// The closed meshes of a scene that stop light: what lies within one of them nobody sees, a floor below a step that
/// stands on it, say. Thread-safe.
class ClosedBodies {
public:
    /// The scene may be gone before the bodies are. A mesh is looked into when a point in its bounds is asked for.
    explicit ClosedBodies(const Scene& scene);
    ~ClosedBodies();
    /// Whether a point [m, world] lies within one of them.
    /// @throws Error as RayCaster does
    bool hold(const glm::dvec3& point) const;

private:
    struct Body;
    std::vector<std::unique_ptr<Body>> bodies_;
};

}  // namespace photic
