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
    const std::uint64_t bits = mix(mix(mix(seed) ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(p))) ^
                                   static_cast<std::uint64_t>(static_cast<std::int64_t>(q)));
    return 2 * kPi * static_cast<double>(bits >> 11) * 0x1p-53;
}

/// The energy spectrum over wave vectors [m4]: S(omega) D(angle) (d omega / dk) / k.
class VectorSpectrum {
public:
    explicit VectorSpectrum(const WindSea& sea)
        : sea_(sea), axis_(glm::normalize(sea.direction)), k_most_(2 * kPi / sea.shortest_wavelength) {
        // Integral of cos^2s(angle / 2) over the circle is 2 sqrt(pi) Gamma(s + 1/2) / Gamma(s + 1).
        normalisation_ =
            std::exp(std::lgamma(sea.spreading + 1) - std::lgamma(sea.spreading + 0.5)) / (2 * std::sqrt(kPi));
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
    std::vector<double> re, im;  // [(q + most_q) * (most_p + 1) + p]
    double variance = 0;
    std::size_t columns() const { return static_cast<std::size_t>(most_p + 1); }
    std::size_t index(int p, int q) const {
        return static_cast<std::size_t>(q + most_q) * columns() + static_cast<std::size_t>(p);
    }
    void resize() { re.assign(index(0, most_q + 1), 0.0), im = re; }
};

Harmonics makeHarmonics(const WindSea& sea, glm::dvec2 size, double time) {
    const VectorSpectrum spectrum(sea);
    const glm::dvec2 cell = 2 * kPi / size;
    Harmonics out;
    out.most_p = static_cast<int>(size.x / sea.shortest_wavelength),
    out.most_q = static_cast<int>(size.y / sea.shortest_wavelength);
    out.resize();
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
            const double amplitude = std::sqrt(2 * energy);
            out.variance += energy;
            // cos(k . x + f) = cos(-k . x - f): waves with p < 0 join their mirror's place.
            const std::size_t at = p >= 0 ? out.index(p, q) : out.index(-p, -q);
            out.re[at] += amplitude * std::cos(argument);
            out.im[at] += (p >= 0 ? amplitude : -amplitude) * std::sin(argument);
        }
    return out;
}

/// Cosine and sine of 2 pi p (i + 1/2 - count / 2) / count at p * count + i.
struct PhaseTable {
    std::vector<double> cosine, sine;
    PhaseTable(int most, int count) {
        std::vector<Complex> turn(static_cast<std::size_t>(2 * count));
        for (int t = 0; t < 2 * count; ++t)
            turn[static_cast<std::size_t>(t)] = {std::cos(kPi * t / count), std::sin(kPi * t / count)};
        for (int p = 0; p <= most; ++p)
            for (int i = 0; i < count; ++i) {
                std::int64_t t = std::int64_t(p) * (2 * i + 1 - count) % (2 * count);
                if (t < 0) t += 2 * count;
                cosine.push_back(turn[static_cast<std::size_t>(t)].real()),
                    sine.push_back(turn[static_cast<std::size_t>(t)].imag());
            }
    }
};

PHOTIC_VECTOR_CLONES
void addWave(const double* cosine, const double* sine, double re, double im, std::size_t count,
             double* __restrict out) {
    for (std::size_t i = 0; i < count; ++i) out[i] += re * cosine[i] - im * sine[i];
}

/// (sum_re, sum_im) += (re, im) * (c + i s)
PHOTIC_VECTOR_CLONES
void addTurned(const double* re, const double* im, double c, double s, std::size_t count, double* __restrict sum_re,
               double* __restrict sum_im) {
    for (std::size_t i = 0; i < count; ++i) {
        sum_re[i] += re[i] * c - im[i] * s;
        sum_im[i] += re[i] * s + im[i] * c;
    }
}

/// The real part of the sum of amplitude * exp(i k . x) on the grid. Sums over q, then over p: the waves are a few per
/// sample, so that two products of matrices cost little more than a Fourier transform, and need none.
SampleGrid synthesise(const Harmonics& harmonics, int width, int height, const PhaseTable& table_x,
                      const PhaseTable& table_y) {
    SampleGrid grid{width, height,
                    std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    const auto samples = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
    parallelFor(height, [&](std::int64_t j) {
        const auto row = static_cast<std::size_t>(j);
        std::vector<double> re(harmonics.columns(), 0.0), im = re;
        for (int q = -harmonics.most_q; q <= harmonics.most_q; ++q) {
            const std::size_t turn = static_cast<std::size_t>(std::abs(q)) * rows + row, from = harmonics.index(0, q);
            const double s = q < 0 ? -table_y.sine[turn] : table_y.sine[turn];
            addTurned(&harmonics.re[from], &harmonics.im[from], table_y.cosine[turn], s, re.size(), re.data(),
                      im.data());
        }
        double* out = &grid.values[row * samples];
        for (std::size_t p = 0; p < re.size(); ++p)
            addWave(&table_x.cosine[p * samples], &table_x.sine[p * samples], re[p], im[p], samples, out);
    });
    return grid;
}

/// The harmonics of the displacement along an axis, where water under a crest moves towards it: -choppiness k/|k| a
/// sin(...) beside a cos(...) (J. Tessendorf, "Simulating Ocean Water", 2001), a turn by i.
Harmonics displaced(const Harmonics& heights, glm::dvec2 size, double choppiness, int axis) {
    Harmonics out = heights;
    for (int p = 0; p <= heights.most_p; ++p)
        for (int q = -heights.most_q; q <= heights.most_q; ++q) {
            const glm::dvec2 k = glm::dvec2(p, q) / size;
            const double length = glm::length(k), factor = length == 0 ? 0 : choppiness * k[axis] / length;
            const std::size_t at = heights.index(p, q);
            out.re[at] = -factor * heights.im[at], out.im[at] = factor * heights.re[at];
        }
    return out;
}

}  // namespace

double peakFrequency(const WindSea& sea) {
    return 22 * std::cbrt(sea.gravity * sea.gravity / (sea.wind_speed * sea.fetch));
}

double jonswap(const WindSea& sea, double omega) {
    if (omega <= 0) return 0;
    const double peak = peakFrequency(sea), g = sea.gravity;
    const double alpha = 0.076 * std::pow(sea.wind_speed * sea.wind_speed / (sea.fetch * g), 0.22);
    const double width = omega <= peak ? 0.07 : 0.09, offset = (omega - peak) / (width * peak);
    const double ratio = peak / omega, ratio2 = ratio * ratio;
    return alpha * g * g / std::pow(omega, 5) * std::exp(-1.25 * ratio2 * ratio2) *
           std::pow(sea.peak_enhancement, std::exp(-0.5 * offset * offset));
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
    out.heights = synthesise(harmonics, width, height, table_x, table_y);
    if (sea.choppiness == 0) return out;
    for (int axis = 0; axis < 2; ++axis)
        out.displacement.push_back(
            synthesise(displaced(harmonics, size, sea.choppiness, axis), width, height, table_x, table_y));
    return out;
}

}  // namespace photic
