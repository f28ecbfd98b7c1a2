// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace photic {
namespace {

/// Symbols of the central differences: -d2/dx2 and d/dx of exp(i k x), without the i.
double secondSymbol(double k, double h, int order) {
    const double c = std::cos(k * h);
    if (order == 2) return (2 - 2 * c) / (h * h);
    return (5.0 / 2 - 8.0 / 3 * c + 1.0 / 6 * std::cos(2 * k * h)) / (h * h);
}
double firstSymbol(double k, double h, int order) {
    if (order == 2) return std::sin(k * h) / h;
    return (8 * std::sin(k * h) - std::sin(2 * k * h)) / (6 * h);
}

double laplaceSymbol(double k, const glm::dvec3& spacing, int order, const glm::dvec3& direction) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) sum += secondSymbol(k * direction[a], spacing[a], order);
    return sum;
}

}  // namespace

double schemeWavenumber(double w, double dt, const glm::dvec3& spacing, int order, const glm::dvec3& direction,
                        double slowness) {
    const double half = std::sin(0.5 * w * dt), wanted = slowness * slowness * 4 * half * half / (dt * dt);
    // The symbol grows up to the shortest wave that the grid holds along the direction.
    double low = 0, high = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
        if (direction[a] != 0) high = std::min(high, std::acos(-1.0) / (std::fabs(direction[a]) * spacing[a]));
    if (w * dt >= std::acos(-1.0) || laplaceSymbol(high, spacing, order, direction) < wanted) return 0;
    for (int i = 0; i < 60; ++i) {
        const double k = 0.5 * (low + high);
        (laplaceSymbol(k, spacing, order, direction) < wanted ? low : high) = k;
    }
    return 0.5 * (low + high);
}

WavePlaneSums planeSums(const WavePulse& pulse, double dt, const glm::dvec3& spacing, int order,
                        const glm::dvec3& direction, double slowness) {
    constexpr int kFrequencies = 2000;
    const double step = 6.0 / pulse.width() / kFrequencies;  // the spectrum ends at exp(-36)
    WavePlaneSums sums;
    for (int i = 0; i < kFrequencies; ++i) {
        const double w = (i + 0.5) * step, k = schemeWavenumber(w, dt, spacing, order, direction, slowness);
        if (k == 0) continue;
        const double rate = std::sin(w * dt) / dt, density = pulse.spectrum(w) * step;
        double slope = 0;
        for (int a = 0; a < 3; ++a) slope += direction[a] * firstSymbol(k * direction[a], spacing[a], order);
        sums.energy += density * rate * rate, sums.flux += density * rate * slope;
    }
    return sums;
}

}  // namespace photic
