// SPDX-License-Identifier: Apache-2.0
#include "tests/support/closed_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace photic::truth {

double fresnelTransmittance(double cos_in, double ior_from, double ior_to) {
    const double sin_out = ior_from / ior_to * std::sqrt(std::max(0.0, 1 - cos_in * cos_in));
    if (sin_out >= 1) return 0;
    const double cos_out = std::sqrt(1 - sin_out * sin_out);
    const double rs = (ior_from * cos_in - ior_to * cos_out) / (ior_from * cos_in + ior_to * cos_out);
    const double rp = (ior_to * cos_in - ior_from * cos_out) / (ior_to * cos_in + ior_from * cos_out);
    return 1 - (rs * rs + rp * rp) / 2;
}

double PlaneWater::cosBelow() const {
    return std::sqrt(1 - ior_above * ior_above / (ior_below * ior_below) * (1 - cos_in * cos_in));
}

double PlaneWater::horizontal(double depth) const {
    return irradiance * cos_in * fresnelTransmittance(cos_in, ior_above, ior_below) *
           std::exp(-extinction * depth / cosBelow());
}

double PlaneWater::meanHorizontal(double top, double bottom) const {
    if (extinction == 0) return horizontal(top);
    const double optical = extinction * (bottom - top) / cosBelow();
    return horizontal(top) * -std::expm1(-optical) / optical;
}

double PlaneWater::meanFluence(double top, double bottom) const { return meanHorizontal(top, bottom) / cosBelow(); }

double Fold::at(double x) const { return x > edge ? 2 * e0 / std::sqrt(2 * b * (x - edge)) : 0; }

double Fold::mean(double x_low, double x_high) const {
    const auto cumulative = [&](double x) { return 2 * e0 * std::sqrt(2 * std::max(0.0, x - edge) / b); };
    return (cumulative(x_high) - cumulative(x_low)) / (x_high - x_low);
}

namespace {

struct CubicRoots {
    std::array<double, 3> u{};  // ascending
    int count = 0;
};

/// Real roots of c u^3 + d u = x, c > 0; polished, since Cardano's form cancels.
CubicRoots cubicRoots(double c, double d, double x) {
    CubicRoots out;
    const double p = d / c, q = -x / c;
    const double discriminant = q * q / 4 + p * p * p / 27;
    if (discriminant < 0) {
        const double r = 2 * std::sqrt(-p / 3);
        const double angle = std::acos(std::clamp(3 * q / (p * r), -1.0, 1.0)) / 3;
        for (int k = 0; k < 3; ++k) out.u[k] = r * std::cos(angle - 2 * std::numbers::pi * k / 3);
        std::sort(out.u.begin(), out.u.end());
        out.count = 3;
    } else {
        const double s = std::cbrt(std::fabs(q) / 2 + std::sqrt(discriminant));
        out.u[0] = s > 0 ? std::copysign(s - p / (3 * s), x) : 0;
        out.count = 1;
    }
    for (int i = 0; i < out.count; ++i) {
        for (int step = 0; step < 2; ++step) {
            const double slope = 3 * c * out.u[i] * out.u[i] + d;
            const double change = (c * out.u[i] * out.u[i] * out.u[i] + d * out.u[i] - x) / slope;
            if (std::fabs(change) < 1e-6 * std::fabs(out.u[i])) out.u[i] -= change;
        }
    }
    return out;
}

}  // namespace

double Cusp::at(double x, double z) const {
    const CubicRoots roots = cubicRoots(c, 1 - z / f, x);
    double sum = 0;
    for (int i = 0; i < roots.count; ++i) sum += e0 / std::fabs(3 * c * roots.u[i] * roots.u[i] + 1 - z / f);
    return sum;
}

double Cusp::mean(double x_low, double x_high, double z) const {
    // {u : X(u) < x} is u < u1, and u2 < u < u3 where three rays arrive; its measure up to a constant is u1 - u2 + u3.
    const auto cumulative = [&](double x) {
        const CubicRoots r = cubicRoots(c, 1 - z / f, x);
        return r.count == 3 ? r.u[0] - r.u[1] + r.u[2] : r.u[0];
    };
    return e0 * (cumulative(x_high) - cumulative(x_low)) / (x_high - x_low);
}

double Cusp::halfWidth(double z) const {
    const double past = z / f - 1;
    return past > 0 ? 2 * past / 3 * std::sqrt(past / (3 * c)) : 0;
}

glm::dvec2 nephroid(double radius, double p) {
    return radius / 4 * glm::dvec2(3 * std::cos(p) - std::cos(3 * p), 3 * std::sin(p) - std::sin(3 * p));
}

glm::dvec2 cardioid(double radius, double p) {
    return radius / 3 * glm::dvec2(2 * std::cos(p) - std::cos(2 * p), 2 * std::sin(p) - std::sin(2 * p));
}

double mirrorFocus(double radius, double cos_in) { return radius / 2 * cos_in; }

double mirrorFocus(double radius, double cos_in, double source_distance) {
    return 1 / (2 / (radius * cos_in) - 1 / source_distance);
}

double ParabolicMirror::mirrorDistance(double psi) const { return 2 * f / (1 + std::cos(psi)); }

double ParabolicMirror::at(double rho, double psi) const {
    const double ratio = mirrorDistance(psi) / rho;
    return e0 * ratio * ratio;
}

}  // namespace photic::truth
