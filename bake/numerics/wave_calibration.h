// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "bake/numerics/wave_pulse.h"

namespace photic {

/// How finely waves are stepped: their dispersion follows from it.
struct WaveDifferencing {
    double dt = 0;  ///< [m]
    glm::dvec3 spacing{0};
    int order = 4;  ///< of the differences in space
};

/// What the stepper's sums are for a plane wave of amplitude 1: integrals of phi_t^2, and of -phi_t grad phi along its
/// way.
struct WavePlaneSums {
    double energy = 0, flux = 0;
};

/// Differences are not derivatives: at 6 cells a wavelength the central difference in time alone loses 7 % of phi_t^2.
/// Frequencies are kept exactly (what drives the waves sets them), and wavenumbers follow from the scheme's own
/// dispersion along `direction`, at the speed 1 / `slowness`; so both integrals are known to rounding, one frequency at
/// a time.
WavePlaneSums planeSums(const WavePulse& pulse, const WaveDifferencing& grid, const glm::dvec3& direction,
                        double slowness = 1);

/// The wavenumber that the scheme gives to waves of angular frequency w along `direction`; about w slowness; 0 where
/// they do not propagate.
double schemeWavenumber(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double slowness = 1);

/// The speed that the differential equation must be given so that waves of angular frequency w travel along `direction`
/// at 1 in the scheme: leapfrog is too fast, central differences too slow. At six cells a wavelength and 0.95 of the
/// largest step waves would be 0.4 to 0.8 % too fast; what the surface sets along itself then leaves too flat.
/// @param most  bound for stability
double tunedSpeed(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double most);

/// At which energy of angular frequency w travels along `direction` in the scheme: what damping per time must be
/// multiplied by to be damping per length.
double schemeGroupVelocity(double w, const WaveDifferencing& grid, const glm::dvec3& direction, double speed);

/// Turns the stepper's sums of -phi_t grad phi into the flux of a unit of irradiance.
///
/// Along each axis central differences fall short of derivatives by a part that grows with the wave's component along
/// it, as its fourth power. One factor for all three would turn a slanting wave: by 0.9 degrees at 45 degrees and six
/// cells a wavelength, at every resolution, since the wavelength follows the cells. Here each axis has its own factor,
/// by the cosine of the wave to it: found from the sums themselves, and right to rounding for waves along `direction`.
class WaveFluxScale {
public:
    /// @param direction  of the light under flat water, whose components along the surface the waves keep
    /// @param speed      that the stepper was given
    WaveFluxScale(const WavePulse& pulse, const WaveDifferencing& grid, const glm::dvec3& direction, double speed);
    glm::dvec3 operator()(const glm::dvec3& sums) const;

private:
    static constexpr int kSteps = 64;
    glm::dvec3 unitsAt(const glm::dvec3& direction) const;

    glm::dvec3 direction_;
    /// By axis and the size of a direction's component along it: what the sums hold for each unit of it.
    std::array<std::array<double, kSteps + 1>, 3> units_{};
};

}  // namespace photic
