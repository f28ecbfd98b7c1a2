// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bake/paths/ray_casting.h"
#include "bake/paths/triangle_tree.h"

namespace photic {

/// What stands in a scene, as rays and as tubes ask for it. Nothing of the grid, of lights or of media is in it.
struct SceneShapes {
    RayCaster caster;
    TriangleTree tree;
    explicit SceneShapes(const Scene& scene) : caster(scene), tree(scene) {}
};

/// The shapes of a scene. Those that were built last are handed out again where a scene has the very same ones, as long
/// as somebody holds them. Thread-safe.
/// @throws as RayCaster
std::shared_ptr<const SceneShapes> shapesOf(const Scene& scene);

/// Holds the shapes that were built last while it lives, for what asks for them again and again: estimates, pilots and
/// bakes each want those of a million triangles.
class HeldShapes {
public:
    HeldShapes();
    ~HeldShapes();
    HeldShapes(const HeldShapes&) = delete;
    HeldShapes& operator=(const HeldShapes&) = delete;
};

}  // namespace photic
