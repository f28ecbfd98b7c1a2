// SPDX-License-Identifier: Apache-2.0
#include "tests/support/diffracted_light.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace photic::truth {
namespace {

using Complex = std::complex<double>;
constexpr int kFrequencies = 48, kLayers = 4;  // a voxel

/// sum of a[j] exp(sign 2 pi i j k / n), n a power of two.
void transform(std::vector<Complex>& a, double sign) {
    const std::size_t n = a.size();
    for (std::size_t i = 1, j = 0; i < n; ++i) {
        std::size_t bit = n >> 1;
        for (; j & bit; bit >>= 1) j ^= bit;
        j ^= bit;
        if (i < j) std::swap(a[i], a[j]);
    }
    for (std::size_t length = 2; length <= n; length <<= 1) {
        const Complex step = std::polar(1.0, sign * 2 * std::numbers::pi / double(length));
        for (std::size_t i = 0; i < n; i += length) {
            Complex w = 1;
            for (std::size_t k = 0; k < length / 2; ++k, w *= step) {
                const Complex u = a[i + k], v = a[i + k + length / 2] * w;
                a[i + k] = u + v, a[i + k + length / 2] = u - v;
            }
        }
    }
}

}  // namespace

DiffractedLight::DiffractedLight(Profile profile, double eta, double period, double wavelength, double start)
    : period_(period), wavelength_(wavelength), start_(start), count_(256) {
    while (count_ < 40 * period / wavelength) count_ *= 2;
    for (int i = 0; i < count_; ++i) {
        const double x = (double(i) / count_ - 0.5) * period;
        double u = x, tangent = 0;
        ProfilePoint p;
        for (int step = 0; step < 100; ++step) {
            p = profile(u);
            const double beta = std::atan(p.slope);
            tangent = std::tan(beta - std::asin(std::sin(beta) / eta));
            u = x - (p.h - start) * tangent;
        }
        const double beta = std::atan(p.slope), t = std::asin(std::sin(beta) / eta), alpha = beta - t;
        const double turn = p.curvature / (1 + p.slope * p.slope);
        const double spread =
            1 + p.slope * tangent +
            (p.h - start) / std::pow(std::cos(alpha), 2) * turn * (1 - std::cos(beta) / (eta * std::cos(t)));
        const double ci = std::cos(beta), ct = std::cos(t);
        const double rs = (ci - eta * ct) / (ci + eta * ct), rp = (eta * ci - ct) / (eta * ci + ct);
        amplitude_.push_back(std::sqrt((1 - 0.5 * (rs * rs + rp * rp)) / (spread * std::cos(alpha))));
        arrival_.push_back(-p.h / eta + (p.h - start) / std::cos(alpha));
    }
}

std::vector<double> DiffractedLight::voxelMeans(int nx, double z0, double dz, int nz) const {
    std::vector<double> means(static_cast<std::size_t>(nx) * static_cast<std::size_t>(nz), 0.0);
    const double width = 8.0 / 3 * std::numbers::inv_sqrtpi * wavelength_ / (2 * std::numbers::pi);
    const auto count = static_cast<std::size_t>(count_), a_voxel = count / static_cast<std::size_t>(nx);
    double all = 0;
    std::vector<double> weights;
    for (int f = 0; f < kFrequencies; ++f) {  // the energy's spectrum: w^4 exp(-(w width)^2)
        const double w = 0.05 + 4.15 * f / (kFrequencies - 1);
        weights.push_back(std::pow(w, 4) * std::exp(-w * w)), all += weights.back();
    }
    std::vector<Complex> start(count), field(count);
    for (int f = 0; f < kFrequencies; ++f) {
        const double w = (0.05 + 4.15 * f / (kFrequencies - 1)) / width;
        for (std::size_t i = 0; i < count; ++i) start[i] = std::polar(amplitude_[i], -w * arrival_[i]);
        transform(start, -1);
        for (int k = 0; k < nz; ++k)
            for (int s = 0; s < kLayers; ++s) {
                const double depth = start_ - z0 - (k + (s + 0.5) / kLayers) * dz;
                for (std::size_t i = 0; i < count; ++i) {
                    const double mode = double(i) - (i < count / 2 ? 0.0 : double(count));
                    const double across = 2 * std::numbers::pi / period_ * mode, squared = w * w - across * across;
                    field[i] = squared > 0 ? start[i] * std::polar(1.0, -depth * std::sqrt(squared))
                                           : start[i] * std::exp(-depth * std::sqrt(-squared));
                }
                transform(field, 1);
                const double share =
                    weights[std::size_t(f)] / all / (kLayers * double(a_voxel) * double(count) * double(count));
                for (std::size_t i = 0; i < count; ++i)
                    means[static_cast<std::size_t>(k) * static_cast<std::size_t>(nx) + i / a_voxel] +=
                        share * std::norm(field[i]);
            }
    }
    return means;
}

}  // namespace photic::truth
