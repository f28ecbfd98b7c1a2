// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/scene/height_field.h"

namespace photic::test {

/// Normal by central differences of the position, d(position)/du x d(position)/dv.
inline glm::dvec3 differenceNormal(const HeightField& field, glm::dvec2 uv, double h) {
    const glm::dvec3 du = (field.at({uv.x + h, uv.y}).position - field.at({uv.x - h, uv.y}).position) / (2 * h);
    const glm::dvec3 dv = (field.at({uv.x, uv.y + h}).position - field.at({uv.x, uv.y - h}).position) / (2 * h);
    return glm::cross(du, dv);
}

/// Largest distance between row() and at(), positions and normals together.
inline double rowDifference(const HeightField& field, glm::dvec2 start, double step, std::size_t count) {
    SurfaceRow row;
    field.row(start, step, count, row);
    double worst = row.px.size() == count ? 0 : INFINITY;
    for (std::size_t i = 0; i < count && worst < INFINITY; ++i) {
        const SurfacePoint p = field.at({start.x + step * static_cast<double>(i), start.y});
        worst = std::max(worst, glm::length(p.position - glm::dvec3(row.px[i], row.py[i], row.pz[i])));
        worst = std::max(worst, glm::length(p.normal - glm::dvec3(row.nx[i], row.ny[i], row.nz[i])));
    }
    return worst;
}

}  // namespace photic::test
