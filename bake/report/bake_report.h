// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace photic {

/// Where the power of all lights went, in watts, summed over channels' mean. Each term is
/// counted where it happens, in double.
///
/// emitted = reflected + absorbed_medium + scattered + absorbed_surface + received + escaped
///         + dropped + culled, to rounding.
struct PowerLedger {
    double emitted = 0;           ///< through the launched patch (before any blocker)
    double reflected = 0;         ///< Fresnel branch that is not traced
    double absorbed_medium = 0;   ///< by the medium's absorption
    double scattered = 0;         ///< out of the beam by the medium's scattering
    double absorbed_surface = 0;  ///< at blockers before the first specular event
    double received = 0;          ///< ended on a receiver or blocker after it
    double escaped = 0;           ///< left the domain
    double dropped = 0;           ///< tubes given up at the refinement floor
    double culled = 0;            ///< tubes that touch no needed voxel, and launched light that misses everything

    /// All terms, `emitted` first.
    static constexpr double PowerLedger::*kTerms[] = {
        &PowerLedger::emitted,   &PowerLedger::reflected,        &PowerLedger::absorbed_medium,
        &PowerLedger::scattered, &PowerLedger::absorbed_surface, &PowerLedger::received,
        &PowerLedger::escaped,   &PowerLedger::dropped,          &PowerLedger::culled};

    double accounted() const {
        return reflected + absorbed_medium + scattered + absorbed_surface + received + escaped + dropped + culled;
    }
    /// |emitted - accounted| / emitted; 0 without light.
    double imbalance() const { return emitted > 0 ? std::fabs(emitted - accounted()) / emitted : 0.0; }
};

/// What PowerLedger::dropped is made of where tubes are laid [W].
struct GivenUpPower {
    double outlines = 0;   ///< at silhouettes: where rays at the floor of refinement part so far that no tube serves
                           ///< them, or where nothing is found of what a shorter history has handed on
    double turned = 0;     ///< which a smoothed normal sends to the wrong side of its face
    double events = 0;     ///< that meets more surfaces than are followed
    double threshold = 0;  ///< of histories too faint to be followed

    static constexpr double GivenUpPower::*kTerms[] = {&GivenUpPower::outlines, &GivenUpPower::turned,
                                                       &GivenUpPower::events, &GivenUpPower::threshold};
    double sum() const { return outlines + turned + events + threshold; }
};

/// Sum of irradiance x voxel volume against the integral of power along the paths through
/// needed voxels, in W m (mean of the channels). The two sides are computed independently.
struct PathLedger {
    double deposited = 0;  ///< sum over needed voxels of fluence rate [W/m2] x volume [m3]
    double expected = 0;   ///< integral of power along paths through needed voxels
    double imbalance() const {
        return expected > 0 ? std::fabs(deposited - expected) / expected : std::fabs(deposited);
    }
};

/// How far look-ups on a receiver are from the light that falls on it.
struct ReceiverError {
    std::string name;
    double detail = 0;       ///< [m] side of the texels
    double relative_l1 = 0;  ///< sum of |look-up - light| over the sum of light
    double share = 1;        ///< of its texels that were looked at
};

/// How light that comes to a voxel from several directions is shared out among its arrivals, where a bake kept one of
/// them.
struct ArrivalShares {
    double several = 0;    ///< share of the lit voxels to which other arrivals bring a hundredth of the light, or more
    double strongest = 0;  ///< what the strongest arrival brings of the light there, mean over those voxels
    double left_out = 0;   ///< share of all light that the others bring: what the volume is off, in relative L1
    double rmse = 0;       ///< root mean square of that over the root mean square of all light, over lit voxels
};

/// What a bake did: both ledgers, counts, seconds by stage, and what was skipped.
struct BakeReport {
    PowerLedger power;
    PathLedger path;
    double reference_irradiance = 1;  ///< [W/m2]
    std::int64_t tubes = 0;           ///< ray tubes (or photons) deposited
    std::int64_t corner_rays = 0;     ///< rays traced
    std::int64_t needed_voxels = 0;
    std::int64_t active_voxels = 0;
    std::int64_t field_bytes = 0;  ///< memory held by the field
    std::string instruction_set;   ///< of the deposit kernel: "avx512", "avx2", "portable"
    int threads = 0;
    std::vector<std::pair<std::string, double>> seconds;  ///< wall time by stage, in order
    std::vector<std::string> skipped;                     ///< what was not computed, in words
    std::vector<ReceiverError> receivers;                 ///< those that were measured
    std::string advice;  ///< what would halve the largest of their errors; empty when nothing is known
    std::vector<std::string> warnings;
    std::optional<GivenUpPower> given_up;  ///< of methods that tell
    /// Power of the tubes that stand astride a silhouette, legs of one path each for itself [W]: none of it is lost,
    /// and each corner's third lies within a tube's width, bake.beams.silhouette, of where it belongs. Of methods that
    /// tell.
    std::optional<double> astride;
    std::optional<ArrivalShares> arrivals;  ///< where one arrival a voxel was kept
};

}  // namespace photic
