// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace photic {

/// A refractive index over the wavelength of light.
///
/// What a glass maker, a renderer and a table of constants each state is kept as it was given, and at() answers for
/// all of them, so that light through several media is traced at one set of wavelengths.
class RefractiveIndex {
public:
    enum class Form { Constant, Channels, Abbe, Cauchy, Sellmeier };

    /// The wavelengths that stand for red, green and blue [nm]: the dominant ones of the sRGB primaries.
    static constexpr glm::dvec3 kChannels_nm{611.4, 549.1, 464.3};
    /// Fraunhofer's lines F, d and C [nm], in which glass makers state an index and its dispersion.
    static constexpr double kF_nm = 486.13, kD_nm = 587.56, kC_nm = 656.27;

    /// The same at every wavelength.
    RefractiveIndex(double n = 1);  // NOLINT: a number is an index
    /// `n` at kChannels_nm. Between them 1/lambda^2 is interpolated linearly; beyond the ends n stays as it is there.
    static RefractiveIndex channels(const glm::dvec3& n);
    /// n = n_d at the line d and (n_d - 1) / (n_F - n_C) = abbe, with two terms of Cauchy's.
    static RefractiveIndex abbe(double n_d, double abbe);
    /// n = a[0] + a[1] / lambda^2 + a[2] / lambda^4 + ..., lambda in micrometres.
    static RefractiveIndex cauchy(std::vector<double> a);
    /// n^2 = 1 + sum of b[i] lambda^2 / (lambda^2 - c[i]), lambda in micrometres, c in square micrometres.
    static RefractiveIndex sellmeier(const glm::dvec3& b, const glm::dvec3& c);

    /// n at a wavelength in a vacuum [nm], 380 to 780.
    double at(double wavelength_nm) const;
    /// n at kChannels_nm.
    glm::dvec3 atChannels() const;
    /// n for white light traced as one: at the line d, and of channels their mean.
    double mean() const;
    /// n differs between wavelengths.
    bool disperses() const;
    Form form() const { return form_; }

private:
    Form form_ = Form::Constant;
    std::vector<double> terms_;  ///< n; the channels' n; Cauchy's a; Sellmeier's b and c
};

}  // namespace photic
