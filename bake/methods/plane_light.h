// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/scene.h"

namespace photic {

/// Square texels on a rectangle of a plane: texel (i, j) is centred at origin + (i + 1/2) * right + (j + 1/2) * up.
struct PlaneTexels {
    glm::dvec3 origin{0};        ///< corner [m]
    glm::dvec3 right{0}, up{0};  ///< a texel's sides [m], at right angles; `right` is level
    glm::dvec3 normal{0, 0, 1};  ///< unit, of the side that is looked at: along cross(right, up)
    int columns = 1, rows = 1;
    double side() const;  ///< of a texel [m]
    glm::dvec3 centre(int i, int j) const { return origin + (i + 0.5) * right + (j + 0.5) * up; }
};

/// Why planeIrradiance cannot tell a scene's light; empty when it can.
std::string planeLightRefusal(const Scene& scene);

/// What each texel gets on the side of the normal [W/m2], mean over the texel and the channels, row by row: tubes of a
/// lattice, a refinement and shadow rays of their own, cut by the plane and shared out over the texels exactly in
/// power. What a volume's look-ups on a receiver are measured against (docs/accuracy.md).
///
/// Where one blur serves a sun's disc (blurServes) its image in the plane is laid over each row of texels; elsewhere up
/// to eight directions stand for it.
/// @param tolerance  [m] how far tubes may land beside where light does
/// @throws Error{Input}, Error{Cancelled}
std::vector<float> planeIrradiance(const Scene& scene, const PlaneTexels& texels, double tolerance,
                                   const Monitor& monitor);

/// Whether no sun's disc has to be sampled for it, which takes eight times as long.
bool planeLightIsQuick(const Scene& scene);

/// What planeIrradiance is expected to take [s of one thread].
double planeLightSeconds(const Scene& scene, const PlaneTexels& texels, double tolerance);

}  // namespace photic
