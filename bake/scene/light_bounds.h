// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <limits>

#include "bake/scene/scene.h"

namespace photic {

/// A box that grows [m].
struct Bounds3 {
    glm::dvec3 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
    void add(const glm::dvec3& p);
    bool empty() const { return !(min.x <= max.x); }
};

/// Everything that has bounds: patches of height fields, meshes that bend or receive light, media whose index varies.
/// Planes that receive light stretch the box along the axis nearest to their normal, to where they meet its sides.
Bounds3 sceneBounds(const Scene& scene);

/// What bends light, and where its light goes down to what receives it ([domain] fit = "light"): over the footprint of
/// open water, and of glass where the lights throw its shadow. Around mirrors, and around water with a lamp
/// in it, what receives light counts up to two of their sizes away. Wide open water without a medium is cropped to the
/// fixed receivers' footprint.
Bounds3 lightBounds(const Scene& scene);

}  // namespace photic
