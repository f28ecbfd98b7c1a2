// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/spline_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bake/scene/vector_clones.h"

namespace photic {
namespace {

/// Weights of the four columns floor(x) - 1 .. floor(x) + 2 and their derivatives, t = x - floor(x).
struct Weights {
    double w[4], d[4];
};

inline Weights cubicWeights(double t) {
    const double t2 = t * t, t3 = t2 * t, u = 1 - t;
    return {{u * u * u * (1.0 / 6), 2.0 / 3 - t2 + 0.5 * t3, 1.0 / 6 + 0.5 * (t + t2 - t3), t3 * (1.0 / 6)},
            {-0.5 * u * u, 1.5 * t2 - 2 * t, 0.5 + t - 1.5 * t2, 0.5 * t2}};
}

inline Weights linearWeights(double t) { return {{0, 1 - t, t, 0}, {0, -1, 1, 0}}; }

/// A tridiagonal system whose factors are shared by many right-hand sides.
class Tridiagonal {
public:
    Tridiagonal(std::vector<double> lower, const std::vector<double>& diagonal, const std::vector<double>& upper)
        : lower_(std::move(lower)), upper_(diagonal.size()), inverse_(diagonal.size()) {
        for (std::size_t k = 0; k < diagonal.size(); ++k) {
            inverse_[k] = 1 / (diagonal[k] - (k > 0 ? lower_[k] * upper_[k - 1] : 0.0));
            upper_[k] = upper[k] * inverse_[k];
        }
    }

    /// Solves in place for `lanes` neighbouring right-hand sides, element k of lane l at data[k * stride + l].
    void solve(double* data, std::size_t stride, std::size_t lanes) const {
        const std::size_t n = inverse_.size();
        for (std::size_t k = 0; k < n; ++k) {
            double* here = data + k * stride;
            const double* before = here - stride;
            if (k == 0)
                for (std::size_t l = 0; l < lanes; ++l) here[l] *= inverse_[k];
            else
                for (std::size_t l = 0; l < lanes; ++l) here[l] = (here[l] - lower_[k] * before[l]) * inverse_[k];
        }
        for (std::size_t k = n - 1; k-- > 0;) {
            double* here = data + k * stride;
            const double* after = here + stride;
            for (std::size_t l = 0; l < lanes; ++l) here[l] -= upper_[k] * after[l];
        }
    }

private:
    std::vector<double> lower_, upper_, inverse_;
};

/// Turns samples into B-spline coefficients along one axis: (c[k-1] + 4 c[k] + c[k+1]) / 6 = f[k].
class Prefilter {
public:
    Prefilter(int count, GridBoundary boundary)
        : n_(static_cast<std::size_t>(count)), boundary_(boundary), system_(make(n_, boundary)) {
        if (boundary != GridBoundary::Periodic) return;
        // Sherman and Morrison: the corners of the cyclic matrix are a rank-one correction.
        correction_.assign(n_, 0.0);
        correction_.front() = kGamma, correction_.back() = 1;
        system_.solve(correction_.data(), 1, 1);
    }

    void apply(double* data, std::size_t stride, std::size_t lanes) const {
        double *front = data, *back = data + (n_ - 1) * stride;
        if (boundary_ == GridBoundary::Free) {
            // A quadratic continuation, c[-1] = 3 c[0] - 3 c[1] + c[2], turns the first equation into c[0] - c[1] =
            // f[0] - f[1].
            for (std::size_t l = 0; l < lanes; ++l) front[l] -= front[stride + l];
            const double* before_back = back - stride;
            for (std::size_t l = 0; l < lanes; ++l) back[l] -= before_back[l];
        }
        const std::size_t ends = boundary_ == GridBoundary::Free ? 1 : 0;
        for (std::size_t k = ends; k + ends < n_; ++k)
            for (std::size_t l = 0; l < lanes; ++l) data[k * stride + l] *= 6;
        system_.solve(data, stride, lanes);
        if (boundary_ != GridBoundary::Periodic) return;
        std::vector<double> factor(lanes);
        for (std::size_t l = 0; l < lanes; ++l)
            factor[l] = (front[l] + back[l] / kGamma) / (1 + correction_.front() + correction_.back() / kGamma);
        for (std::size_t k = 0; k < n_; ++k)
            for (std::size_t l = 0; l < lanes; ++l) data[k * stride + l] -= factor[l] * correction_[k];
    }

private:
    static constexpr double kGamma = -4;

    static Tridiagonal make(std::size_t n, GridBoundary boundary) {
        std::vector<double> lower(n, 1.0), diagonal(n, 4.0), upper(n, 1.0);
        switch (boundary) {
            case GridBoundary::Free:
                diagonal.front() = 1, upper.front() = -1;
                diagonal.back() = 1, lower.back() = -1;
                break;
            case GridBoundary::Mirror:
                diagonal.front() = diagonal.back() = 5;
                break;
            case GridBoundary::Periodic:
                diagonal.front() -= kGamma, diagonal.back() -= 1 / kGamma;
                break;
        }
        return {std::move(lower), diagonal, upper};
    }

    std::size_t n_;
    GridBoundary boundary_;
    Tridiagonal system_;
    std::vector<double> correction_;
};

/// Continues a line of coefficients by two on either side.
void pad(double* line, std::ptrdiff_t stride, std::ptrdiff_t n, GridBoundary boundary, Interpolation interpolation) {
    const auto c = [&](std::ptrdiff_t k) -> double& { return line[k * stride]; };
    for (const std::ptrdiff_t k : {1, 2}) {
        switch (boundary) {
            case GridBoundary::Periodic:
                c(-k) = c(n - k), c(n - 1 + k) = c(k - 1);
                break;
            case GridBoundary::Mirror:
                c(-k) = c(k - 1), c(n - 1 + k) = c(n - k);
                break;
            case GridBoundary::Free:
                if (interpolation == Interpolation::Bilinear) {
                    c(-k) = 2 * c(1 - k) - c(2 - k), c(n - 1 + k) = 2 * c(n - 2 + k) - c(n - 3 + k);
                } else {
                    c(-k) = 3 * c(1 - k) - 3 * c(2 - k) + c(3 - k);
                    c(n - 1 + k) = 3 * c(n - 2 + k) - 3 * c(n - 3 + k) + c(n - 4 + k);
                }
                break;
        }
    }
}

PHOTIC_VECTOR_CLONES
void combineRows(const double* r0, const double* r1, const double* r2, const double* r3, const double* w,
                 const double* d, std::size_t count, double* __restrict value, double* __restrict dy) {
    const double w0 = w[0], w1 = w[1], w2 = w[2], w3 = w[3], d0 = d[0], d1 = d[1], d2 = d[2], d3 = d[3];
    for (std::size_t i = 0; i < count; ++i) {
        value[i] = w0 * r0[i] + w1 * r1[i] + w2 * r2[i] + w3 * r3[i];
        dy[i] = d0 * r0[i] + d1 * r1[i] + d2 * r2[i] + d3 * r3[i];
    }
}

template <Weights (*weights)(double)>
inline __attribute__((always_inline)) void evaluateLoop(const double* line_value, const double* line_dy,
                                                        const double* x, std::size_t count, std::int32_t last_cell,
                                                        double offset, double scale_x, double scale_y,
                                                        double* __restrict value, double* __restrict dx,
                                                        double* __restrict dy) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto truncated = static_cast<std::int32_t>(x[i]);  // x >= 1: truncation is floor
        const std::int32_t cell = truncated < last_cell ? truncated : last_cell;
        const Weights k = weights(x[i] - cell);
        const double *v = line_value + cell - 1, *d = line_dy + cell - 1;
        value[i] = offset + (k.w[0] * v[0] + k.w[1] * v[1] + k.w[2] * v[2] + k.w[3] * v[3]);
        dx[i] = scale_x * (k.d[0] * v[0] + k.d[1] * v[1] + k.d[2] * v[2] + k.d[3] * v[3]);
        dy[i] = scale_y * (k.w[0] * d[0] + k.w[1] * d[1] + k.w[2] * d[2] + k.w[3] * d[3]);
    }
}

void evaluateCubic(const double* line_value, const double* line_dy, const double* x, std::size_t count,
                   std::int32_t last_cell, double offset, double scale_x, double scale_y, double* __restrict value,
                   double* __restrict dx, double* __restrict dy) {
    evaluateLoop<cubicWeights>(line_value, line_dy, x, count, last_cell, offset, scale_x, scale_y, value, dx, dy);
}

void evaluateLinear(const double* line_value, const double* line_dy, const double* x, std::size_t count,
                    std::int32_t last_cell, double offset, double scale_x, double scale_y, double* __restrict value,
                    double* __restrict dx, double* __restrict dy) {
    evaluateLoop<linearWeights>(line_value, line_dy, x, count, last_cell, offset, scale_x, scale_y, value, dx, dy);
}

std::int64_t wrap(std::int64_t i, std::int64_t n) {
    const std::int64_t r = i % n;
    return r < 0 ? r + n : r;
}

}  // namespace

SplineGrid::SplineGrid(const SampleGrid& samples, GridBoundary boundary, Interpolation interpolation)
    : width_(samples.width),
      height_(samples.height),
      pitch_(static_cast<std::size_t>(samples.width) + 2 * kPad),
      boundary_(boundary),
      interpolation_(interpolation),
      coefficients_(pitch_ * (static_cast<std::size_t>(samples.height) + 2 * kPad)) {
    double* origin = &coefficients_[kPad * pitch_ + kPad];
    const auto width = static_cast<std::size_t>(width_);
    for (int y = 0; y < height_; ++y)
        std::copy_n(&samples.values[static_cast<std::size_t>(y) * width], width,
                    origin + static_cast<std::size_t>(y) * pitch_);

    if (interpolation == Interpolation::Bicubic) {
        const Prefilter along_x(width_, boundary), along_y(height_, boundary);
        for (int y = 0; y < height_; ++y) along_x.apply(origin + static_cast<std::size_t>(y) * pitch_, 1, 1);
        along_y.apply(origin, pitch_, width);
    }
    for (int y = 0; y < height_; ++y)
        pad(origin + static_cast<std::size_t>(y) * pitch_, 1, width_, boundary, interpolation);
    for (std::size_t x = 0; x < pitch_; ++x)
        pad(origin - kPad + x, static_cast<std::ptrdiff_t>(pitch_), height_, boundary, interpolation);
    const auto [low, high] = std::minmax_element(coefficients_.begin(), coefficients_.end());
    min_ = *low, max_ = *high;
}

SplineGrid::Value SplineGrid::at(double x, double y) const {
    const double fx = std::floor(x), fy = std::floor(y);
    auto i = static_cast<std::int64_t>(fx), j = static_cast<std::int64_t>(fy);
    if (boundary_ == GridBoundary::Periodic) i = wrap(i, width_), j = wrap(j, height_);
    i = std::clamp<std::int64_t>(i, -1, width_ - 1), j = std::clamp<std::int64_t>(j, -1, height_ - 1);
    const bool cubic = interpolation_ == Interpolation::Bicubic;
    const Weights kx = cubic ? cubicWeights(x - fx) : linearWeights(x - fx);
    const Weights ky = cubic ? cubicWeights(y - fy) : linearWeights(y - fy);
    Value out;
    for (int b = 0; b < 4; ++b) {
        const double* c = row(j - 1 + b) + i - 1;
        const double value = kx.w[0] * c[0] + kx.w[1] * c[1] + kx.w[2] * c[2] + kx.w[3] * c[3];
        out.value += ky.w[b] * value;
        out.dy += ky.d[b] * value;
        out.dx += ky.w[b] * (kx.d[0] * c[0] + kx.d[1] * c[1] + kx.d[2] * c[2] + kx.d[3] * c[3]);
    }
    return out;
}

void SplineGrid::collapse(double y, std::int64_t first, std::size_t count, double* value, double* dy) const {
    const double fy = std::floor(y);
    auto j = static_cast<std::int64_t>(fy);
    if (boundary_ == GridBoundary::Periodic) j = wrap(j, height_);
    j = std::clamp<std::int64_t>(j, -1, height_ - 1);
    const Weights k = interpolation_ == Interpolation::Bicubic ? cubicWeights(y - fy) : linearWeights(y - fy);
    const double* rows[4] = {row(j - 1), row(j), row(j + 1), row(j + 2)};
    const auto combine = [&](std::int64_t column, std::size_t from, std::size_t length) {
        combineRows(rows[0] + column, rows[1] + column, rows[2] + column, rows[3] + column, k.w, k.d, length,
                    value + from, dy + from);
    };
    if (boundary_ != GridBoundary::Periodic) return combine(first, 0, count);
    for (std::size_t done = 0; done < count;) {
        const std::int64_t column = wrap(first + static_cast<std::int64_t>(done), width_);
        const std::size_t length = std::min(count - done, static_cast<std::size_t>(width_ - column));
        combine(column, done, length);
        done += length;
    }
}

void SplineGrid::evaluate(const double* line_value, const double* line_dy, std::size_t columns, const double* x,
                          std::size_t count, const RowTarget& out) const {
    const auto kernel = interpolation_ == Interpolation::Bicubic ? evaluateCubic : evaluateLinear;
    kernel(line_value, line_dy, x, count, static_cast<std::int32_t>(columns) - 3, out.offset, out.scale_x, out.scale_y,
           out.value, out.dx, out.dy);
}

}  // namespace photic
