// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/amplitude_transport.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// Van Leer's limited slope from the differences on either side.
double limited(double below, double above) { return below * above > 0 ? 2 * below * above / (below + above) : 0.0; }

/// Flux through the face between b and c of a, b, c, d at speed v: from the side that it comes from.
double faceFlux(double a, double b, double c, double d, double v) {
    return v > 0 ? v * (b + 0.5 * limited(b - a, c - b)) : v * (c - 0.5 * limited(c - b, d - c));
}

}  // namespace

AmplitudeTransport::AmplitudeTransport(int count_x, int count_y) : nx_(count_x), ny_(count_y) {
    const auto count = static_cast<std::size_t>(count_x) * static_cast<std::size_t>(count_y);
    for (auto* v : {&first_, &second_, &middle_}) v->resize(count);
}

/// -div(Q b), b between the two layers at `part` of the way.
void AmplitudeTransport::rate(std::span<const double> q, double part, std::span<double> out) {
    const auto speed = [&](std::span<const double> from, std::span<const double> to, std::size_t i, std::size_t j) {
        return 0.5 * ((1 - part) * (from[i] + from[j]) + part * (to[i] + to[j]));
    };
    const auto nx = static_cast<std::int64_t>(nx_), ny = static_cast<std::int64_t>(ny_);
    parallelFor(ny, [&](std::int64_t j) {
        const auto at = [&](std::int64_t x, std::int64_t y) {
            return static_cast<std::size_t>(std::clamp<std::int64_t>(y, 0, ny - 1) * nx +
                                            std::clamp<std::int64_t>(x, 0, nx - 1));
        };
        const auto along = [&](std::int64_t i) {  // through the face below cell i
            return faceFlux(q[at(i - 2, j)], q[at(i - 1, j)], q[at(i, j)], q[at(i + 1, j)],
                            speed(from_x_, to_x_, at(i - 1, j), at(i, j)));
        };
        const auto across = [&](std::int64_t i, std::int64_t y) {
            return faceFlux(q[at(i, y - 2)], q[at(i, y - 1)], q[at(i, y)], q[at(i, y + 1)],
                            speed(from_y_, to_y_, at(i, y - 1), at(i, y)));
        };
        double low = along(0);
        for (std::int64_t i = 0; i < nx; ++i) {
            const double high = along(i + 1);
            out[at(i, j)] = low - high + across(i, j) - across(i, j + 1);
            low = high;
        }
    });
}

void AmplitudeTransport::advance(std::span<double> density, std::span<const double> slope_x_from,
                                 std::span<const double> slope_y_from, std::span<const double> slope_x_to,
                                 std::span<const double> slope_y_to) {
    from_x_ = slope_x_from, from_y_ = slope_y_from, to_x_ = slope_x_to, to_y_ = slope_y_to;
    double fastest = 0;
    for (const auto& slopes : {slope_x_from, slope_y_from, slope_x_to, slope_y_to})
        for (const double s : slopes) fastest = std::max(fastest, std::fabs(s));
    const int steps = std::max(1, static_cast<int>(std::ceil(2 * fastest)));
    const double step = 1.0 / steps;
    for (int s = 0; s < steps; ++s) {
        rate(density, s * step, first_);
        for (std::size_t i = 0; i < density.size(); ++i) middle_[i] = density[i] + step * first_[i];
        rate(middle_, (s + 1) * step, second_);
        for (std::size_t i = 0; i < density.size(); ++i) density[i] += 0.5 * step * (first_[i] + second_[i]);
    }
}

}  // namespace photic
