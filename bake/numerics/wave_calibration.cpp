// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
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

/// What a central difference gives for each unit of a wavenumber `k` times a cosine; its limit where that is 0.
double firstSymbolAUnit(double k, double cosine, double h, int order) {
    return std::fabs(cosine) > 1e-6 ? firstSymbol(k * cosine, h, order) / cosine : k;
}

constexpr int kFrequencies = 2000;
double frequencyStep(const WavePulse& pulse) { return 6.0 / pulse.width() / kFrequencies; }  // it ends at exp(-36)

double laplaceSymbol(double k, const WaveDifferencing& grid, const glm::dvec3& direction) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) sum += secondSymbol(k * direction[a], grid.spacing[a], grid.order);
    return sum;
}

}  // namespace

double schemeWavenumber(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double slowness) {
    const double half = std::sin(0.5 * w * grid.dt),
                 wanted = slowness * slowness * 4 * half * half / (grid.dt * grid.dt);
    // The symbol grows up to the shortest wave that the grid holds along the direction.
    double low = 0, high = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
        if (direction[a] != 0) high = std::min(high, std::acos(-1.0) / (std::fabs(direction[a]) * grid.spacing[a]));
    if (w * grid.dt >= std::acos(-1.0) || laplaceSymbol(high, grid, direction) < wanted) return 0;
    for (int i = 0; i < 60; ++i) {
        const double k = 0.5 * (low + high);
        (laplaceSymbol(k, grid, direction) < wanted ? low : high) = k;
    }
    return 0.5 * (low + high);
}

WavePlaneSums planeSums(const WavePulse& pulse, const WaveDifferencing& grid, const glm::dvec3& direction,
                        double slowness) {
    const double step = frequencyStep(pulse);
    WavePlaneSums sums;
    for (int i = 0; i < kFrequencies; ++i) {
        const double w = (i + 0.5) * step, k = schemeWavenumber(w, grid, direction, slowness);
        if (k == 0) continue;
        const double rate = std::sin(w * grid.dt) / grid.dt, density = pulse.spectrum(w) * step;
        double slope = 0;
        for (int a = 0; a < 3; ++a) slope += direction[a] * firstSymbol(k * direction[a], grid.spacing[a], grid.order);
        sums.energy += density * rate * rate, sums.flux += density * rate * slope;
    }
    return sums;
}

double tunedSpeed(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double most) {
    const double half = std::sin(0.5 * w * grid.dt), wanted = 4 * half * half / (grid.dt * grid.dt);
    return std::min(most, std::sqrt(wanted / laplaceSymbol(w, grid, direction)));
}

double schemeGroupVelocity(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double speed) {
    const double step = 1e-3 * w;
    const auto wavenumber = [&](double at) { return schemeWavenumber(at, grid, direction, 1 / speed); };
    return 2 * step / (wavenumber(w + step) - wavenumber(w - step));
}

WaveFluxScale::WaveFluxScale(const WavePulse& pulse, const WaveDifferencing& grid, const glm::dvec3& direction,
                             double speed)
    : direction_(direction) {
    const double step = frequencyStep(pulse);
    // Waves that keep w times the light's components along the surface; the scheme finds the one across it.
    glm::dvec3 kept(0);
    for (int i = 0; i < kFrequencies; ++i) {
        const double w = (i + 0.5) * step, rate = std::sin(w * grid.dt) / grid.dt, density = pulse.spectrum(w) * step;
        const double half = std::sin(0.5 * w * grid.dt) / (0.5 * grid.dt * speed);
        double across = half * half;
        for (int a = 0; a < 2; ++a) across -= secondSymbol(w * direction[a], grid.spacing[a], grid.order);
        const double shortest = std::acos(-1.0) / grid.spacing.z;
        if (w * grid.dt >= std::acos(-1.0) || across < 0 || secondSymbol(shortest, grid.spacing.z, grid.order) < across)
            continue;
        double low = 0, high = shortest;
        for (int n = 0; n < 60; ++n) {
            const double k = 0.5 * (low + high);
            (secondSymbol(k, grid.spacing.z, grid.order) < across ? low : high) = k;
        }
        for (int a = 0; a < 2; ++a)
            kept[a] += density * rate * firstSymbolAUnit(w, direction[a], grid.spacing[a], grid.order);
        kept.z += density * rate * firstSymbol(low, grid.spacing.z, grid.order) / std::fabs(direction.z);
        for (std::size_t a = 0; a < 3; ++a)
            for (int n = 0; n <= kSteps; ++n)
                units_[a][static_cast<std::size_t>(n)] +=
                    density * rate *
                    firstSymbolAUnit(w, double(n) / kSteps, grid.spacing[static_cast<int>(a)], grid.order);
    }
    const glm::dvec3 plain = unitsAt(direction);
    for (std::size_t a = 0; a < 3; ++a)
        for (double& unit : units_[a]) unit *= kept[static_cast<int>(a)] / plain[static_cast<int>(a)];
}

glm::dvec3 WaveFluxScale::unitsAt(const glm::dvec3& direction) const {
    glm::dvec3 units;
    for (int a = 0; a < 3; ++a) {
        const double place = std::min(std::fabs(direction[a]), 1.0) * kSteps;
        const auto n = std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(kSteps - 1));
        const auto& row = units_[static_cast<std::size_t>(a)];
        units[a] = row[n] + (place - static_cast<double>(n)) * (row[n + 1] - row[n]);
    }
    return units;
}

glm::dvec3 WaveFluxScale::operator()(const glm::dvec3& sums) const {
    glm::dvec3 flux = sums / unitsAt(direction_);
    // The factors vary by some per cent over all directions: two rounds are right to a hundredth of that.
    for (int i = 0; i < 2; ++i) {
        const double length = glm::length(flux);
        if (!(length > 0)) return flux;
        flux = sums / unitsAt(flux / length);
    }
    return flux;
}

}  // namespace photic
