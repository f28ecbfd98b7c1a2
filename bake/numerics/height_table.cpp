// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/height_table.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

namespace photic {
namespace {

const double kPole = std::sqrt(3.0) - 2;

/// Samples to coefficients along one line, in place: a causal and an anticausal recursion (Unser, box 2).
void prefilter(double* c, std::size_t n, std::size_t stride) {
    double sum = 0, power = 1;
    for (std::size_t k = 0; k < std::min<std::size_t>(n, 40); ++k, power *= kPole) sum += power * c[k * stride];
    c[0] = sum;
    for (std::size_t k = 1; k < n; ++k) c[k * stride] += kPole * c[(k - 1) * stride];
    c[(n - 1) * stride] = kPole / (kPole * kPole - 1) * (c[(n - 1) * stride] + kPole * c[(n - 2) * stride]);
    for (std::size_t k = n - 1; k-- > 0;) c[k * stride] = kPole * (c[(k + 1) * stride] - c[k * stride]);
    for (std::size_t k = 0; k < n; ++k) c[k * stride] *= 6;
}

struct Weights {
    double w[4], d[4], s[4];
};
Weights weightsAt(double t) {
    const double u = 1 - t;
    return {{u * u * u / 6, 2.0 / 3 - t * t + t * t * t / 2, 2.0 / 3 - u * u + u * u * u / 2, t * t * t / 6},
            {-u * u / 2, 1.5 * t * t - 2 * t, 2 * u - 1.5 * u * u, t * t / 2},
            {u, 3 * t - 2, 1 - 3 * t, t}};
}

}  // namespace

HeightTable::HeightTable(glm::dvec2 corner, double spacing, int count_x, int count_y, std::vector<double> heights)
    : corner_(corner), spacing_(spacing), count_x_(count_x), count_y_(count_y), coefficients_(std::move(heights)) {
    const auto nx = static_cast<std::size_t>(count_x), ny = static_cast<std::size_t>(count_y);
    for (std::size_t j = 0; j < ny; ++j) prefilter(&coefficients_[j * nx], nx, 1);
    for (std::size_t i = 0; i < nx; ++i) prefilter(&coefficients_[i], ny, nx);
}

HeightPoint HeightTable::at(glm::dvec2 xy) const {
    const glm::dvec2 p = (glm::clamp(xy, low(), high()) - corner_) / spacing_;
    const auto i = static_cast<std::size_t>(p.x), j = static_cast<std::size_t>(p.y);
    const Weights kx = weightsAt(p.x - static_cast<double>(i)), ky = weightsAt(p.y - static_cast<double>(j));
    const double inverse = 1 / spacing_;
    HeightPoint out;
    for (std::size_t b = 0; b < 4; ++b) {
        const double* c = &coefficients_[(j + b - 1) * static_cast<std::size_t>(count_x_) + i - 1];
        double value = 0, first = 0, second = 0;
        for (std::size_t a = 0; a < 4; ++a) value += kx.w[a] * c[a], first += kx.d[a] * c[a], second += kx.s[a] * c[a];
        out.h += ky.w[b] * value;
        out.hx += ky.w[b] * first * inverse, out.hy += ky.d[b] * value * inverse;
        out.hxx += ky.w[b] * second * inverse * inverse, out.hyy += ky.s[b] * value * inverse * inverse;
        out.hxy += ky.d[b] * first * inverse * inverse;
    }
    return out;
}

}  // namespace photic
