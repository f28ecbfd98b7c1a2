// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace photic {

/// Samples on a regular grid, x fastest, row 0 at the lowest y.
struct SampleGrid {
    int width = 0, height = 0;
    std::vector<double> values;
    double& at(int x, int y) {
        return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
    double at(int x, int y) const {
        return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

enum class Interpolation {
    Bicubic,  ///< uniform cubic B-spline through the samples: continuous curvature
    Bilinear  ///< facets
};

/// How the samples go on past the edge of the grid, which lies half a sample beyond the outermost ones.
enum class GridBoundary {
    Free,      ///< quadratics are continued exactly (linear functions when bilinear)
    Periodic,  ///< the grid repeats
    Mirror     ///< reflected at the edge: zero slope there, as at a wall
};

/// A tensor-product B-spline that interpolates a grid; coordinates in samples, sample (i, j) at (i, j).
/// Valid on [-1/2, width - 1/2] x [-1/2, height - 1/2]; everywhere when periodic.
///
/// Prefiltered coefficients (M. Unser, "Splines: a perfect fit for signal and image processing", 1999), found by
/// tridiagonal solves so that every boundary is exact.
class SplineGrid {
public:
    /// @param samples  finite, at least 4 a side
    SplineGrid(const SampleGrid& samples, GridBoundary boundary, Interpolation interpolation);

    int width() const { return width_; }
    int height() const { return height_; }

    struct Value {
        double value = 0, dx = 0, dy = 0;  ///< derivatives per sample
    };
    Value at(double x, double y) const;

    /// The spline along y = const as one-dimensional coefficients for columns [first, first + count): of its value and
    /// of its derivative along y. Column c weighs on x in (c - 2, c + 2).
    void collapse(double y, std::int64_t first, std::size_t count, double* value, double* dy) const;

    /// Values and derivatives from `columns` collapsed columns at x[i] in [1, columns - 2), counted from the first
    /// column: out_value = offset + value, out_dx = dx * scale_x, out_dy = dy * scale_y.
    struct RowTarget {
        double offset, scale_x, scale_y;
        double *value, *dx, *dy;
    };
    void evaluate(const double* line_value, const double* line_dy, std::size_t columns, const double* x,
                  std::size_t count, const RowTarget& out) const;

    /// Bounds of the spline (of its coefficients, which enclose it).
    double min() const { return min_; }
    double max() const { return max_; }

private:
    static constexpr int kPad = 2;
    const double* row(std::int64_t y) const {
        return &coefficients_[static_cast<std::size_t>(y + kPad) * pitch_ + kPad];
    }

    int width_, height_;
    std::size_t pitch_;
    GridBoundary boundary_;
    Interpolation interpolation_;
    std::vector<double> coefficients_;  // with kPad more on every side
    double min_ = 0, max_ = 0;
};

}  // namespace photic
