// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/wind_sea.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/scene/vector_clones.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kPi = std::numbers::pi;
using Complex = std::complex<double>;

/// A phase in [0, 2 pi) for harmonic (p, q): splitmix64 of the seed and the two numbers.
double phaseOf(std::uint64_t seed, int p, int q) {
    const auto mix = [](std::uint64_t z) {
        z += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    };
    const std::uint64_t bits = mix(mix(mix(seed) ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(p))) ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(q)));
    return 2 * kPi * static_cast<double>(bits >> 11) * 0x1p-53;
}

/// The energy spectrum over wave vectors [m4]: S(omega) D(angle) (d omega / dk) / k.
class VectorSpectrum {
public:
    explicit VectorSpectrum(const WindSea& sea) : sea_(sea), axis_(glm::normalize(sea.direction)), k_most_(2 * kPi / sea.shortest_wavelength) {
        // Integral of cos^2s(angle / 2) over the circle is 2 sqrt(pi) Gamma(s + 1/2) / Gamma(s + 1).
        normalisation_ = std::exp(std::lgamma(sea.spreading + 1) - std::lgamma(sea.spreading + 0.5)) / (2 * std::sqrt(kPi));
    }

    double at(glm::dvec2 k) const {
        const double length = glm::length(k);
        if (length == 0 || length > k_most_) return 0;
        const double omega = std::sqrt(sea_.gravity * length);
        const double half_cosine_squared = std::clamp(0.5 * (1 + glm::dot(k, axis_) / length), 0.0, 1.0);
        const double spread = normalisation_ * std::pow(half_cosine_squared, sea_.spreading);
        return jonswap(sea_, omega) * spread * (0.5 * sea_.gravity / omega) / length;
    }

    /// Integral over the cell of wave vectors around `k`.
    double energy(glm::dvec2 k, glm::dvec2 cell) const {
        // The spectrum bends on the scale of k itself: far out one point does, near the peak 8 x 8.
        const int n = glm::length(k) > 16 * std::max(cell.x, cell.y) ? 1 : 8;
        double sum = 0;
        for (int b = 0; b < n; ++b)
            for (int a = 0; a < n; ++a) sum += at(k + cell * ((glm::dvec2(a, b) + 0.5) / static_cast<double>(n) - 0.5));
        return sum * cell.x * cell.y / (n * n);
    }

private:
    WindSea sea_;
    glm::dvec2 axis_;
    double k_most_, normalisation_;
};

/// Complex amplitudes of exp(i (kx x + ky y)) for p >= 0 and |q| <= most_q: the real part of their sum is the surface.
struct Harmonics {
    int most_p = 0, most_q = 0;
    std::vector<Complex> amplitude;  // [p * (2 most_q + 1) + q + most_q]
    double variance = 0;
    std::size_t index(int p, int q) const { return static_cast<std::size_t>(p) * static_cast<std::size_t>(2 * most_q + 1) + static_cast<std::size_t>(q + most_q); }
};

Harmonics makeHarmonics(const WindSea& sea, glm::dvec2 size, double time) {
    const VectorSpectrum spectrum(sea);
    const glm::dvec2 cell = 2 * kPi / size;
    Harmonics out;
    out.most_p = static_cast<int>(size.x / sea.shortest_wavelength), out.most_q = static_cast<int>(size.y / sea.shortest_wavelength);
    out.amplitude.resize(static_cast<std::size_t>(out.most_p + 1) * static_cast<std::size_t>(2 * out.most_q + 1));
    for (int p = -out.most_p; p <= out.most_p; ++p)
        for (int q = -out.most_q; q <= out.most_q; ++q) {
            const glm::dvec2 k = cell * glm::dvec2(p, q);
            if (p == 0 && q == 0) continue;
            if (glm::length(k) > 2 * kPi / sea.shortest_wavelength) continue;
            const double energy = spectrum.energy(k, cell);
            if (energy <= 0) continue;
            double omega = std::sqrt(sea.gravity * glm::length(k));
            if (sea.period > 0) omega = std::round(omega * sea.period / (2 * kPi)) * 2 * kPi / sea.period;
            const double argument = phaseOf(sea.seed, p, q) - omega * time;
            const Complex a = std::sqrt(2 * energy) * Complex(std::cos(argument), std::sin(argument));
            out.variance += energy;
            // cos(k . x + f) = cos(-k . x - f): waves with p < 0 join their mirror's place.
            if (p >= 0)
                out.amplitude[out.index(p, q)] += a;
            else
                out.amplitude[out.index(-p, -q)] += std::conj(a);
        }
    return out;
}

/// Cosine and sine of 2 pi p (i + 1/2 - count / 2) / count at p * count + i.
struct PhaseTable {
    std::vector<double> cosine, sine;
    PhaseTable(int most, int count) {
        std::vector<Complex> turn(static_cast<std::size_t>(2 * count));
        for (int t = 0; t < 2 * count; ++t) turn[static_cast<std::size_t>(t)] = {std::cos(kPi * t / count), std::sin(kPi * t / count)};
        for (int p = 0; p <= most; ++p)
            for (int i = 0; i < count; ++i) {
                std::int64_t t = std::int64_t(p) * (2 * i + 1 - count) % (2 * count);
                if (t < 0) t += 2 * count;
                cosine.push_back(turn[static_cast<std::size_t>(t)].real()), sine.push_back(turn[static_cast<std::size_t>(t)].imag());
            }
    }
};

PHOTIC_VECTOR_CLONES
void addWave(const double* cosine, const double* sine, double re, double im, std::size_t count, double* __restrict out) {
    for (std::size_t i = 0; i < count; ++i) out[i] += re * cosine[i] - im * sine[i];
}

/// The real part of the sum of factor(p, q) * amplitude * exp(i k . x) on the grid. Sums over q, then over p: the waves
/// are a few per sample, so that two products of matrices cost little more than a Fourier transform, and need none.
template <typename Factor>
SampleGrid synthesise(const Harmonics& harmonics, int width, int height, const PhaseTable& table_x, const PhaseTable& table_y, const Factor& factor) {
    std::vector<Complex> scaled(harmonics.amplitude.size());
    for (int p = 0; p <= harmonics.most_p; ++p)
        for (int q = -harmonics.most_q; q <= harmonics.most_q; ++q)
            scaled[harmonics.index(p, q)] = harmonics.amplitude[harmonics.index(p, q)] * factor(p, q);

    SampleGrid grid{width, height, std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    parallelFor(height, [&](std::int64_t j) {
        double* out = &grid.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(width)];
        std::vector<Complex> turn(static_cast<std::size_t>(2 * harmonics.most_q + 1));
        for (int q = -harmonics.most_q; q <= harmonics.most_q; ++q) {
            const std::size_t at = static_cast<std::size_t>(std::abs(q)) * static_cast<std::size_t>(height) + static_cast<std::size_t>(j);
            turn[static_cast<std::size_t>(q + harmonics.most_q)] = {table_y.cosine[at], q < 0 ? -table_y.sine[at] : table_y.sine[at]};
        }
        for (int p = 0; p <= harmonics.most_p; ++p) {
            double re = 0, im = 0;
            const Complex* a = &scaled[harmonics.index(p, -harmonics.most_q)];
            for (std::size_t q = 0; q < turn.size(); ++q) {
                re += a[q].real() * turn[q].real() - a[q].imag() * turn[q].imag();
                im += a[q].real() * turn[q].imag() + a[q].imag() * turn[q].real();
            }
            if (re == 0 && im == 0) continue;
            const std::size_t row = static_cast<std::size_t>(p) * static_cast<std::size_t>(width);
            addWave(&table_x.cosine[row], &table_x.sine[row], re, im, static_cast<std::size_t>(width), out);
        }
    });
    return grid;
}

}  // namespace

double peakFrequency(const WindSea& sea) { return 22 * std::cbrt(sea.gravity * sea.gravity / (sea.wind_speed * sea.fetch)); }

double jonswap(const WindSea& sea, double omega) {
    if (omega <= 0) return 0;
    const double peak = peakFrequency(sea), g = sea.gravity;
    const double alpha = 0.076 * std::pow(sea.wind_speed * sea.wind_speed / (sea.fetch * g), 0.22);
    const double width = omega <= peak ? 0.07 : 0.09, offset = (omega - peak) / (width * peak);
    const double ratio = peak / omega, ratio2 = ratio * ratio;
    return alpha * g * g / std::pow(omega, 5) * std::exp(-1.25 * ratio2 * ratio2) * std::pow(sea.peak_enhancement, std::exp(-0.5 * offset * offset));
}

double significantHeight(const WindSea& sea) {
    const double last = std::sqrt(sea.gravity * 2 * kPi / sea.shortest_wavelength);
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += jonswap(sea, last * (i + 0.5) / kSteps);
    return 4 * std::sqrt(sum * last / kSteps);
}

SeaSamples seaSamples(const WindSea& sea, glm::dvec2 size, int width, int height, double time) {
    const Harmonics harmonics = makeHarmonics(sea, size, time);
    const PhaseTable table_x(harmonics.most_p, width), table_y(harmonics.most_q, height);
    SeaSamples out;
    out.variance = harmonics.variance;
    out.heights = synthesise(harmonics, width, height, table_x, table_y, [](int, int) { return 1.0; });
    if (sea.choppiness == 0) return out;
    // Water under a crest moves towards it: -choppiness k/|k| a sin(...) beside a cos(...) (Tessendorf, "Simulating Ocean Water").
    for (int axis = 0; axis < 2; ++axis)
        out.displacement.push_back(synthesise(harmonics, width, height, table_x, table_y, [&](int p, int q) {
            const glm::dvec2 k = glm::dvec2(p, q) / size;
            const double length = glm::length(k);
            return length == 0 ? Complex(0) : Complex(0, sea.choppiness * k[axis] / length);
        }));
    return out;
}

}  // namespace photic
