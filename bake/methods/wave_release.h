// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/field/grid_frame.h"
#include "bake/numerics/wave_stepper.h"
#include "bake/scene/scene.h"

namespace photic {

/// The cells that a wave runs through: those of the voxel grid, divided, in blocks of 8^3 that share the origin of the
/// voxels' leaves.
struct WaveCells {
    GridFrame frame;          ///< of the voxels, axis-aligned
    int per_voxel = 1;        ///< along each axis: 1, 2, 4 or 8
    glm::ivec3 low_block{0};  ///< block (0, 0, 0) of `grid`, in blocks from the voxels' origin
    WaveGrid grid;
    glm::ivec3 asked_low{0},
        asked_high{0};  ///< the cells whose light counts: of the voxels, up to two voxels behind planes that block

    /// Cells are numbered from the voxels' origin: voxel v holds cells v * per_voxel ...
    glm::dvec3 world(const glm::dvec3& cell) const {
        return frame.worldFromIndex((cell + 0.5) / static_cast<double>(per_voxel) - 0.5);
    }
    glm::dvec3 cell(const glm::dvec3& world) const {
        return (frame.indexFromWorld(world) + 0.5) * static_cast<double>(per_voxel) - 0.5;
    }
    glm::ivec3 lowCell() const { return low_block * kWaveSide; }
    glm::ivec3 size() const { return grid.blocks * kWaveSide; }
};

class WaveIndex;

/// A light and the surface that it goes through.
struct LitSurface {
    const Surface& surface;
    const Light& light;
};

/// What a pulse is and what it runs through.
struct PulseInWater {
    WavePulse pulse;
    double extinction = 0;             ///< [1/m]
    const WaveIndex* index = nullptr;  ///< null: constant
};

/// Light in a cell that the surface cuts and whose centre is above it.
struct WaveRim {
    glm::ivec3 cell{0};
    float energy =
        0;  ///< irradiance across the ray for a light of 1 W/m2, times the part of the cell below the surface
    glm::vec3 direction{0};
};

/// The surface over the cells, and the light that it lets through.
struct WaveRelease {
    WaveSource source;
    std::vector<float> level;       ///< height of the surface above each column [cells from lowCell().z], x slowest
    std::vector<std::int32_t> top;  ///< highest cell of each column that is wet or driven, from lowCell().z
    std::vector<WaveRim> rim;
    // Of a light of 1 W/m2 through the columns:
    double launched = 0, reflected = 0;  ///< power [W], and what of it the surface reflects
    double path = 0;                     ///< integral of power along the rays within the cells that count [W m]
    double folded = 0;                   ///< part of the driven cells where neighbouring rays cross within two cells
};

/// Heights of the surface over the columns of `cells` (its box; blocks may be left out later): fills `level` and `top`.
void levelSurface(const WaveCells& cells, const Surface& surface, WaveRelease& release);

/// A pulse along the interface at the light's arrival time there: Snell's law and Fresnel's transmittance at the smooth
/// surface, arrival n1/n2 (d . y) + |x - y| and amplitude sqrt(E0 T cos ti / cos tt / |J|) carried back along the ray
/// to the cells just above the surface, whose values are then given for all times: one-sided, and exact as far as rays
/// are. Times are lengths in the medium below. Needs levelSurface().
/// Where the index varies, `surface.ior_below` is its least; rays are refracted by the index at their feet and carried
/// back straight, at the index halfway: arrivals are off by about r^3 (grad n / n)^2, r < 4 cells, a thousandth of a
/// cell.
void releasePulse(const WaveCells& cells, const LitSurface& lit, const PulseInWater& water, WaveRelease& release);

/// The paper's start [Mercier 2014, algorithm 3]: phi = 1 at rest in the cells that the surface cuts. Needs
/// levelSurface().
void releaseAtRest(const WaveCells& cells, WaveRelease& release);

}  // namespace photic
