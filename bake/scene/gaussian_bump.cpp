// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gaussian_bump.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kPi = std::numbers::pi;

/// Coefficients of cos(m pi x / L), x from the low wall, of a Gaussian of height 1 with all its mirror images: the
/// Gaussian's Fourier transform at k = m pi / L.
std::vector<double> gaussianSeries(double radius, double from_wall, double length, int modes) {
    std::vector<double> a(static_cast<std::size_t>(modes));
    for (int m = 0; m < modes; ++m) {
        const double k = m * kPi / length;
        a[static_cast<std::size_t>(m)] = (m == 0 ? 1.0 : 2.0) / length * std::sqrt(2 * kPi) * radius *
                                         std::exp(-0.5 * k * k * radius * radius) * std::cos(k * from_wall);
    }
    return a;
}

/// cosines[m * count + i] = cos(m pi (i + 1/2) / count): a mode at the centre of cell i.
std::vector<double> cosineTable(int modes, int count) {
    std::vector<double> table(static_cast<std::size_t>(modes) * static_cast<std::size_t>(count));
    std::vector<double> quarter(static_cast<std::size_t>(4 * count));
    for (int q = 0; q < 4 * count; ++q) quarter[static_cast<std::size_t>(q)] = std::cos(q * kPi / (2.0 * count));
    for (int m = 0; m < modes; ++m)
        for (int i = 0; i < count; ++i)
            table[static_cast<std::size_t>(m) * static_cast<std::size_t>(count) + static_cast<std::size_t>(i)] =
                quarter[static_cast<std::size_t>((std::int64_t(m) * (2 * i + 1)) % (4 * count))];
    return table;
}

/// A mode's amplitude at time t over that at 0: an oscillator let go at rest.
double oscillation(double omega, double damping, double time) {
    if (omega == 0) return 1;  // the mean level: water is kept
    const double squared = omega * omega - damping * damping, fall = std::exp(-damping * time);
    if (squared > 0) {
        const double w = std::sqrt(squared);
        return fall * (std::cos(w * time) + damping / w * std::sin(w * time));
    }
    // Overdamped, written so that no exponential overflows.
    const double w = std::sqrt(-squared);
    if (w * time < 1e-6) return fall * (1 + damping * time);
    const double slow = std::exp(-(damping - w) * time), fast = std::exp(-(damping + w) * time);
    return 0.5 * ((slow + fast) + damping / w * (slow - fast));
}

}  // namespace

int bumpModes(const GaussianBump& bump, double size) {
    const double modes = 7.5 / bump.radius * size / kPi;  // exp(-7.5^2 / 2) = 6e-13
    return static_cast<int>(std::min(std::ceil(modes) + 1, 1e9));
}

SampleGrid bumpHeights(const GaussianBump& bump, glm::dvec2 size, int width, int height, double time) {
    const int modes_x = bumpModes(bump, size.x), modes_y = bumpModes(bump, size.y);
    const std::vector<double> a = gaussianSeries(bump.radius, bump.center.x + 0.5 * size.x, size.x, modes_x);
    const std::vector<double> b = gaussianSeries(bump.radius, bump.center.y + 0.5 * size.y, size.y, modes_y);
    const std::vector<double> cos_x = cosineTable(modes_x, width), cos_y = cosineTable(modes_y, height);

    // The coefficients at `time`; modes that both series make negligible are left out.
    std::vector<double> coefficients(a.size() * b.size());
    for (std::size_t n = 0; n < b.size(); ++n)
        for (std::size_t m = 0; m < a.size(); ++m) {
            const double k = std::hypot(static_cast<double>(m) / size.x, static_cast<double>(n) / size.y) * kPi;
            coefficients[n * a.size() + m] =
                bump.height * a[m] * b[n] * oscillation(bump.speed * k, bump.damping, time);
        }

    SampleGrid grid{width, height,
                    std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
    parallelFor(height, [&](std::int64_t j) {
        // Sum over the modes along y first, for this row; then the row is a sum over the modes along x.
        std::vector<double> along_x(a.size(), 0.0);
        for (std::size_t n = 0; n < b.size(); ++n) {
            const double c = cos_y[n * rows + static_cast<std::size_t>(j)];
            for (std::size_t m = 0; m < a.size(); ++m) along_x[m] += c * coefficients[n * a.size() + m];
        }
        double* out = &grid.values[static_cast<std::size_t>(j) * columns];
        for (std::size_t m = 0; m < a.size(); ++m) {
            const double c = along_x[m];
            const double* cosine = &cos_x[m * columns];
            for (std::size_t i = 0; i < columns; ++i) out[i] += c * cosine[i];
        }
    });
    return grid;
}

}  // namespace photic
