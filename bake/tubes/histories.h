// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "bake/tubes/launch.h"

namespace photic {

/// A wavelength at which light is traced where media disperse, and what it counts for in each channel.
struct SpectralSample {
    double wavelength_nm = 0;
    glm::dvec3 weight{0};  ///< never negative; all samples' add up to 1 in each channel
};

/// `count` wavelengths, evenly spread over the refractive power of glass (1 / lambda^2). Each counts for the two
/// channels on either side of it, the nearer one more: so weights are never negative (those of a pure wavelength in
/// linear sRGB are) and white light stays white.
std::vector<SpectralSample> spectralSamples(int count);
/// Their wavelengths alone [nm].
std::vector<double> wavelengthsOf(const std::vector<SpectralSample>& spectrum);

/// How far light is followed.
struct FollowLimits {
    int events = 12;          ///< most of a path
    double threshold = 1e-4;  ///< share of an emission's power below which a branch is not followed; the ledger has it
};

/// Light of faint histories that other samples of a light leave to its last one [W].
///
/// What a sun's disc or a lamp's face blurs is seen in the few histories that carry most of the light. The others are
/// followed for one sample, with the power of all.
class FaintLight {
public:
    void leave(const History& history, int surface, int wavelength, double power);
    double take(const History& history, int surface, int wavelength);
    /// What nobody took.
    double rest() const;

private:
    using Key = std::vector<int>;
    static Key key(const History& history, int surface, int wavelength);
    std::map<Key, double> power_;
};

/// Launches every history of an emission: the events at its own surface, then, for what meets another surface (or the
/// same one again), each branch there, until the limits. A history lays its last legs only; those before were laid by
/// the histories that it continues, and its domain is the tubes of those that met the surface.
///
/// Wavelengths part at the first surface that disperses, and only there.
class HistoryLauncher {
public:
    /// All must outlive the launcher. @param options  `tubes` says channels; its other members are set here
    HistoryLauncher(const OpticalScene& optics, const std::vector<SpectralSample>& spectrum,
                    const LaunchOptions& options, const FollowLimits& limits, const TubeSink& sink, Monitor& monitor)
        : optics_(optics), spectrum_(spectrum), options_(options), limits_(limits), sink_(sink), monitor_(monitor) {}

    /// Faint histories of what is launched from here on are left to a later sample, or taken up again.
    void shareFaint(FaintLight* faint, bool take) { faint_ = faint, takes_faint_ = take; }

    /// @param domain  of a height field; unused for meshes
    void launch(const Emission& emission, const LaunchDomain& domain, LaunchTotals& totals);

    /// How many like them the tubes stand for that the sink is handed; 1 unless LaunchOptions::sampled leaves some out.
    double standsFor() const { return stands_for_; }

private:
    struct Light {
        Emission emission;
        int wavelength = 0;  ///< of OpticalScene's; 0: white
        double emitted = 0;  ///< [W]
    };
    void begin(Light light, const LaunchDomain& domain, LaunchTotals& totals);
    void goOn(const Light& light, const History& history, const std::vector<TubeSeed>& seeds, LaunchTotals& totals);
    void followFrom(const Light& light, const History& history, int surface, const std::vector<TubeSeed>& part,
                    double power, LaunchTotals& totals);
    void branchAt(const Light& light, const History& history, int surface, const std::vector<TubeSeed>& seeds,
                  double power, LaunchTotals& totals);
    bool takesSecond(const History& history, std::vector<double>& shares, Light& light) const;
    double shareOf(const Light& light, double power) const;
    double powerOnAVoxel(const Light& light) const;
    double faintness() const;
    std::vector<glm::dvec3> coloursOf(const Light& light, const History& history, int surface,
                                      const std::vector<TubeSeed>& seeds) const;
    LaunchOptions optionsFor(const History& history, bool first_branch) const;
    std::optional<Lattice> latticeFor(const Light& light, const LaunchDomain& domain) const;
    std::vector<Light> parted(const Light& light, int surface) const;

    const OpticalScene& optics_;
    const std::vector<SpectralSample>& spectrum_;
    LaunchOptions options_;
    FollowLimits limits_;
    const TubeSink& sink_;
    Monitor& monitor_;
    FaintLight* faint_ = nullptr;
    bool takes_faint_ = true;
    double stands_for_ = 1;
};

}  // namespace photic
