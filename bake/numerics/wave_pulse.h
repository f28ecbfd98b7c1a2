// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace photic {

enum class PulseShape {
    Slope,  ///< -x exp((1 - x^2) / 2): the first derivative of a Gaussian; the widest spectrum without a mean, so that
            ///< arrivals that overlap show few fringes, and nothing slow is left behind
    Bump    ///< exp(-x^2 / 2): a Gaussian, whose integral over time is not 0
};

/// A short pulse f(x), x = t / width, of height 1.
class WavePulse {
public:
    /// @param wavelength  speed (1) times the period of the mean frequency of f'^2, the energy; > 0
    static WavePulse ofWavelength(double wavelength, PulseShape shape = PulseShape::Slope) {
        // The spectra of f' are w^2 exp(-w^2/2) and w exp(-w^2/2); the means of |w| over their squares:
        const double mean = (shape == PulseShape::Slope ? 8.0 / 3.0 : 2.0) * std::numbers::inv_sqrtpi;
        return WavePulse(mean * wavelength / (2.0 * std::numbers::pi), shape);
    }
    explicit WavePulse(double width, PulseShape shape = PulseShape::Slope) : width_(width), shape_(shape) {}

    double width() const { return width_; }
    PulseShape shape() const { return shape_; }
    /// Mean angular frequency of the energy.
    double frequency() const {
        return (shape_ == PulseShape::Slope ? 8.0 / 3.0 : 2.0) * std::numbers::inv_sqrtpi / width_;
    }
    /// f is below 1e-5 of its height beyond +- reach().
    double reach() const { return kReach * width_; }
    double operator()(double t) const {
        const double x = t / width_;
        if (std::fabs(x) >= kReach) return 0.0;
        return shape_ == PulseShape::Slope ? -x * std::exp(0.5 * (1.0 - x * x)) : std::exp(-0.5 * x * x);
    }
    /// Integral of f over all time.
    double integral() const { return shape_ == PulseShape::Slope ? 0.0 : width_ * std::sqrt(2.0 * std::numbers::pi); }
    /// Integral of f'^2 over all time.
    double slopeEnergy() const {
        return (shape_ == PulseShape::Slope ? 0.75 * std::numbers::e : 0.5) / (std::numbers::inv_sqrtpi * width_);
    }
    /// |f^(w)|^2 / pi at angular frequency w > 0: the integral of w^2 times it over all w > 0 is slopeEnergy().
    double spectrum(double w) const {
        const double x = w * width_, bump = 2 * width_ * width_ * std::exp(-x * x);
        return shape_ == PulseShape::Slope ? std::numbers::e * x * x * bump : bump;
    }

private:
    static constexpr double kReach = 5.5;
    double width_;
    PulseShape shape_;
};

}  // namespace photic
