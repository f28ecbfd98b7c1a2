// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "bake/scene/height_field.h"
#include "bake/scene/patch.h"
#include "bake/scene/spline_grid.h"

namespace photic {

/// Where samples lie in their rectangle.
enum class SampleSite {
    Centers,  ///< sample (i, j) at the corner + (i + 1/2, j + 1/2) * size / count, as the texels of a picture
    Corners   ///< sample (i, j) at the corner + (i, j) * size / (count - 1), as the vertices of a mesh
};

/// Where a sampled surface lies and how it goes on.
struct SplineFieldShape {
    glm::dvec2 size{1};  ///< [m] of the samples' rectangle
    SampleSite site = SampleSite::Centers;
    glm::dvec3 center{0};  ///< [m] of that rectangle; heights count from center.z
    GridBoundary boundary = GridBoundary::Free;
    Interpolation interpolation = Interpolation::Bicubic;
    bool bounded = true;  ///< false (periodic samples only): the surface goes on; true: a plane at center.z beyond
};

/// z = center.z + the spline through `heights` [m]; with `displacement`, the point also moves along x and y [m].
/// row() costs about 5 ns per point, three times that with displacement.
std::shared_ptr<const HeightField> makeSplineField(
    const SplineFieldShape& shape, const SampleGrid& heights,
    const std::optional<std::array<SampleGrid, 2>>& displacement = std::nullopt);

/// Whether a surface is one of makeSplineField's that ends somewhere: a map that a file gives.
bool isBoundedSpline(const HeightField& field);

/// Least z of the normal over the samples of a displaced surface: (1 + dx/du)(1 + dy/dv) - (dx/dv)(dy/du).
/// Below 0 the surface folds over itself.
double leastNormalZ(const HeightField& field, const SplineFieldShape& shape, int width, int height);

}  // namespace photic
