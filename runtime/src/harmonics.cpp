// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/harmonics.h"

#include <cmath>
#include <numbers>

#include "photic/bent_rays.h"

namespace photic::runtime {
namespace {

constexpr double kPi = std::numbers::pi;

/// Y_lm over its polynomial.
std::array<double, 9> normalisations() {
    const double one = std::sqrt(3 / (4 * kPi)), two = std::sqrt(15 / (4 * kPi));
    return {std::sqrt(1 / (4 * kPi)), one, one, one, two, two, std::sqrt(5 / (16 * kPi)), two, two / 2};
}

}  // namespace

std::array<double, 9> ambientFactors() {
    // What a cosine leaves of each degree, over pi.
    constexpr double kLeft[9] = {1, 2.0 / 3, 2.0 / 3, 2.0 / 3, 0.25, 0.25, 0.25, 0.25, 0.25};
    std::array<double, 9> out = normalisations();
    for (std::size_t i = 0; i < 9; ++i) out[i] *= kLeft[i];
    return out;
}

Harmonics environmentHarmonics(const float* rgba, int width, int height) {
    std::array<std::array<double, 3>, 9> sum{};
    for (int row = 0; row < height; ++row) {
        const double up = ((row + 0.5) / height - 0.5) * kPi, area = std::cos(up) * kPi / height * 2 * kPi / width;
        for (int column = 0; column < width; ++column) {
            const double turn = (0.5 - (column + 0.5) / width) * 2 * kPi;
            const double x = std::cos(up) * std::cos(turn), y = std::cos(up) * std::sin(turn), z = std::sin(up);
            const double polynomials[9] = {1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y};
            const float* texel = rgba + 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                             static_cast<std::size_t>(column));
            for (std::size_t i = 0; i < 9; ++i)
                for (std::size_t c = 0; c < 3; ++c) sum[i][c] += area * polynomials[i] * double(texel[c]);
        }
    }
    const std::array<double, 9> factors = normalisations();
    Harmonics out;
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t c = 0; c < 3; ++c) out[i][c] = static_cast<float>(factors[i] * sum[i][c]);
    return out;
}

}  // namespace photic::runtime
