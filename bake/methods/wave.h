// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/catalogue.h"
#include "bake/numerics/wave_stepper.h"

namespace photic {

/// What is accumulated as the waves pass.
enum class WaveAccumulate {
    Energy,    ///< integral of phi_t^2: the scalar irradiance, in the limit of short waves
    Amplitude  ///< integral of phi, the paper's sum: harmonic away from the source, and so no caustics
};
enum class WavePreset {
    None,
    Mercier  ///< [Mercier 2014, section 4]: infinite index, phi = 1 at rest at the interface, second order, sponge,
             ///< amplitude
};

/// [bake.wave]
struct WaveOptions {
    WavePreset preset = WavePreset::None;
    double wavelength = 0;  ///< [m] where the index is largest, of the mean frequency of the energy; 0: `points` cells
    double points = 6;      ///< cells a wavelength where `wavelength` is 0
    int cells = 1;          ///< a voxel, along each axis: 1, 2, 4 or 8
    WaveAccumulate accumulate = WaveAccumulate::Energy;
    WaveAbsorber absorber = WaveAbsorber::Pml;
    int sponge_cells = 16;
    double courant = 0.95;
    double threshold = 0.05;        ///< of unfocused light's amplitude, below which a block is given up
    bool disc = true;               ///< blur by the sun's disc where one blur a layer serves
    bool clamp = false;             ///< the preset's: phi >= 0
    double gain = 1, exponent = 1;  ///< a and b of a * phi^b [Mercier 2014, section 4.1], of the amplitude
};

/// What the waves did, beside the report.
struct WaveRun {
    WaveCounts counts;
    double wavelength = 0;  ///< [m]
    double dt = 0;          ///< [m]
    double points = 0;      ///< cells a wavelength
    /// Sum of irradiance times volume over what rays through the box give; 0 where they were not followed.
    double path_over_rays = 0;
};

/// The method with its options as a struct; the catalogue's row calls it. Sums over lights; one wave each, and one for
/// each channel where the medium is coloured. `run`, if given, is filled from the last wave.
/// @throws Error{Input} for a wavelength of less than 3 cells; Error{Cancelled}
BakeResult bakeWave(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const WaveOptions& options,
                    Monitor& monitor, WaveRun* run = nullptr);

/// The row of the catalogue: accumulated waves [Mercier 2014, section 4], with finite index and energy (docs/wave.md).
Method waveMethod();

}  // namespace photic
