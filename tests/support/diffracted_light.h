// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/support/wave_light.h"

namespace photic::truth {

/// What a short pulse of a scalar wave leaves below a periodic profile under light that falls straight down: the time
/// integral of phi_t^2 over its plane wave's, the limit that any solver of the wave equation tends to.
///
/// Rays, which are exact before their first focus, give amplitude and phase at a height just below the surface; from
/// there each frequency of the pulse (the first derivative of a Gaussian) goes on by its angular spectrum, which solves
/// the wave equation exactly.
class DiffractedLight {
public:
    /// @param period      of the profile [m]
    /// @param wavelength  in the medium, of the mean frequency of the energy [m]
    /// @param start       height at which rays become waves [m], below the profile and above all foci
    DiffractedLight(Profile profile, double eta, double period, double wavelength, double start);

    /// Mean scalar irradiance of voxels [i dx, (i+1) dx] from -period / 2 (nx to a period, a power of two) x
    /// [z0 + k dz, z0 + (k+1) dz], i fastest; layers must lie below the start.
    std::vector<double> voxelMeans(int nx, double z0, double dz, int nz) const;

private:
    double period_, wavelength_, start_;
    int count_;  // of the samples
    std::vector<double> amplitude_, arrival_;
};

}  // namespace photic::truth
