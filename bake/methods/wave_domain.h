// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/wave_release.h"
#include "bake/numerics/wave_absorber.h"

namespace photic {

struct WaveDomainSettings {
    int cells_per_voxel = 1;
    double wavelength = 0;  ///< [m], where the index is least
    WaveAbsorber absorber = WaveAbsorber::Pml;
    int sponge_cells = 16;
    bool both_sides = false;  ///< the water and the air above it, in the grid's own box (the paper)
};

/// The box of blocks that the waves need, with its surface's levels and without the blocks that they cannot use.
///
/// Besides the voxel grid: what lies between it and the surface; to the sides, whatever light can come from
/// (launchDomain) and a margin of half a Fresnel zone and of how far an index that varies bends rays, narrowing towards
/// the bottom; and the absorbing layer around. Planes that block and are perpendicular to an axis end it two voxels
/// behind them. An axis along which light and surface repeat with the grid is periodic.
WaveCells waveCells(const Scene& scene, const LitSurface& lit, const GridFrame& frame,
                    const WaveDomainSettings& settings, WaveRelease& release);

}  // namespace photic
