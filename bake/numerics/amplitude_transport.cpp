// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/amplitude_transport.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// Van Leer's limited slope from the differences on either side.
inline double limited(double below, double above) {
    const double product = below * above, sum = below + above;
    return product > 0 ? 2 * product / sum : 0.0;
}

/// Flux through the face between b and c of a, b, c, d at speed v: from the side that it comes from.
inline double faceFlux(double a, double b, double c, double d, double v) {
    const double near = v > 0 ? b : c, step = c - b;
    const double slope = limited(v > 0 ? b - a : step, v > 0 ? step : d - c);
    return v * (near + (v > 0 ? 0.5 : -0.5) * slope);
}

/// Fluxes through `count` faces: a to d are the cells around each, the slopes those of b and c at either layer.
struct FaceSlopes {
    const double *from_b, *from_c, *to_b, *to_c;
};
void faceFluxes(int count, const double* __restrict a, const double* __restrict b, const double* __restrict c,
                const double* __restrict d, const FaceSlopes& s, double part, double* __restrict out) {
    const double *fb = s.from_b, *fc = s.from_c, *tb = s.to_b, *tc = s.to_c, rest = 1 - part;
    for (int i = 0; i < count; ++i)
        out[i] = faceFlux(a[i], b[i], c[i], d[i], 0.5 * (rest * (fb[i] + fc[i]) + part * (tb[i] + tc[i])));
}

}  // namespace

AmplitudeTransport::AmplitudeTransport(int count_x, int count_y) : nx_(count_x), ny_(count_y) {
    const auto count = static_cast<std::size_t>(count_x) * static_cast<std::size_t>(count_y);
    for (auto* v : {&first_, &second_, &middle_}) v->resize(count);
}

/// -div(Q b), b between the two layers at `part` of the way.
void AmplitudeTransport::rate(std::span<const double> q, double part, std::span<double> out) {
    const auto nx = static_cast<std::ptrdiff_t>(nx_), ny = static_cast<std::ptrdiff_t>(ny_);
    const auto row = [&](std::span<const double> of, std::ptrdiff_t y) {
        return of.data() + std::clamp<std::ptrdiff_t>(y, 0, ny - 1) * nx;
    };
    constexpr std::ptrdiff_t kTask = 16;
    parallelFor((ny + kTask - 1) / kTask, [&](std::int64_t task) {
        // A row with two cells more at either end, which go on as the last.
        std::vector<double> line(static_cast<std::size_t>(nx) + 4), along(static_cast<std::size_t>(nx) + 1);
        std::vector<double> slopes[2]{line, line}, below(static_cast<std::size_t>(nx)), above(below);
        const auto extended = [&](std::span<const double> of, std::ptrdiff_t y, std::vector<double>& to) {
            const double* from = row(of, y);
            std::copy_n(from, nx, to.begin() + 2);
            to[0] = to[1] = from[0],
            to[static_cast<std::size_t>(nx) + 2] = to[static_cast<std::size_t>(nx) + 3] = from[nx - 1];
        };
        const auto across = [&](std::ptrdiff_t y, std::vector<double>& to) {  // through the faces below row y
            faceFluxes(nx_, row(q, y - 2), row(q, y - 1), row(q, y), row(q, y + 1),
                       {row(from_y_, y - 1), row(from_y_, y), row(to_y_, y - 1), row(to_y_, y)}, part, to.data());
        };
        const std::ptrdiff_t first = task * kTask, end = std::min(ny, first + kTask);
        across(first, below);
        for (std::ptrdiff_t j = first; j < end; ++j) {
            across(j + 1, above);
            extended(q, j, line), extended(from_x_, j, slopes[0]), extended(to_x_, j, slopes[1]);
            faceFluxes(nx_ + 1, &line[0], &line[1], &line[2], &line[3],
                       {&slopes[0][1], &slopes[0][2], &slopes[1][1], &slopes[1][2]}, part, along.data());
            double* to = out.data() + j * nx;
            for (std::ptrdiff_t i = 0; i < nx; ++i) {
                const auto c = static_cast<std::size_t>(i);
                to[i] = along[c] - along[c + 1] + below[c] - above[c];
            }
            std::swap(below, above);
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
