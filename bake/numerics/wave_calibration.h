// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include "bake/numerics/wave_pulse.h"

namespace photic {

/// What the stepper's sums are for a plane wave of amplitude 1: integrals of phi_t^2, and of -phi_t grad phi along its
/// way.
struct WavePlaneSums {
    double energy = 0, flux = 0;
};

/// Differences are not derivatives: at 6 cells a wavelength the central difference in time alone loses 7 % of phi_t^2.
/// Frequencies are kept exactly (what drives the waves sets them), and wavenumbers follow from the scheme's own
/// dispersion along `direction`, at the speed 1 / `slowness`; so both integrals are known to rounding, one frequency at
/// a time.
WavePlaneSums planeSums(const WavePulse& pulse, double dt, const glm::dvec3& spacing, int order,
                        const glm::dvec3& direction, double slowness = 1);

/// The wavenumber that the scheme gives to waves of angular frequency w along `direction`; about w slowness; 0 where
/// they do not propagate.
double schemeWavenumber(double w, double dt, const glm::dvec3& spacing, int order, const glm::dvec3& direction,
                        double slowness = 1);

}  // namespace photic
