// SPDX-License-Identifier: Apache-2.0
#include "tests/support/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace photic::truth {
namespace {

/// Regularised incomplete beta function by Lentz's continued fraction (Abramowitz and Stegun 26.5.8).
double incompleteBeta(double a, double b, double x) {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    if (x > (a + 1) / (a + b + 2)) return 1 - incompleteBeta(b, a, 1 - x);
    const double front =
        std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
    const auto apart = [](double v) { return std::fabs(v) < 1e-300 ? 1e-300 : v; };
    double c = 1, d = 1 / apart(1 - (a + b) * x / (a + 1)), result = d;
    for (int m = 1; m < 500; ++m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / apart(1 + even * d), c = apart(1 + even / c), result *= d * c;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / apart(1 + odd * d), c = apart(1 + odd / c);
        result *= d * c;
        if (std::fabs(d * c - 1) < 1e-14) break;
    }
    return front * result;
}

}  // namespace

double studentTail(double t, int freedom) {
    return incompleteBeta(freedom / 2.0, 0.5, freedom / (freedom + t * t)) / 2;
}

double normalTail(double z) { return std::erfc(z / std::numbers::sqrt2) / 2; }

double normalFromStudent(double t, int freedom) {
    // The tail falls with z; bisection from 0 to 38, beyond which it underflows.
    const double tail = std::max(studentTail(std::fabs(t), freedom), 1e-300);
    double low = 0, high = std::min(38.0, std::fabs(t));
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (normalTail(middle) > tail ? low : high) = middle;
    }
    return std::copysign((low + high) / 2, t);
}

}  // namespace photic::truth
