// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace photic {

/// A height with its first and second derivatives.
struct HeightPoint {
    double h = 0, hx = 0, hy = 0, hxx = 0, hxy = 0, hyy = 0;
};

/// A smooth height z = h(x, y) on a rectangle: the uniform bicubic B-spline through given samples, with continuous
/// second derivatives. Coefficients by Unser's recursive prefilter (1999), mirrored at the edges: within kMargin
/// samples of an edge they bend to zero slope, so the rectangle is sampled with that much to spare.
class HeightTable {
public:
    static constexpr int kMargin = 16;  // 0.27^16 = 1e-9

    /// @param heights  [m] at corner + (i, j) * spacing, i fastest, i < count_x
    HeightTable(glm::dvec2 corner, double spacing, int count_x, int count_y, std::vector<double> heights);

    HeightPoint at(glm::dvec2 xy) const;

    glm::dvec2 corner() const { return corner_; }
    double spacing() const { return spacing_; }
    int countX() const { return count_x_; }
    int countY() const { return count_y_; }
    /// The part that may be asked: what lies outside is clamped to it.
    glm::dvec2 low() const { return corner_ + 1.0 * spacing_; }
    glm::dvec2 high() const { return corner_ + glm::dvec2(count_x_ - 3, count_y_ - 3) * spacing_; }
    /// B-spline coefficients, i fastest.
    const double* coefficients() const { return coefficients_.data(); }

private:
    glm::dvec2 corner_;
    double spacing_;
    int count_x_, count_y_;
    std::vector<double> coefficients_;
};

}  // namespace photic
