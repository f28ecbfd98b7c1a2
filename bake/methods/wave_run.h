// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "bake/field/light_field.h"
#include "bake/methods/part_monitor.h"
#include "bake/methods/wave.h"
#include "bake/methods/wave_index.h"
#include "bake/numerics/wave_calibration.h"
#include "bake/report/bake_report.h"

namespace photic {

/// Cells a wavelength that waves need to run at all.
inline constexpr double kFewestWavePoints = 3;

/// Power of light through flat water, as irradiance across the refracted ray, for a light of 1 W/m2.
double throughFlatWater(const Surface& surface, const Light& light);

/// The waves of one light through one surface.
class WaveBake {
public:
    /// All are kept by reference; `options` have their preset in them.
    WaveBake(const Scene& scene, const Light& light, const NeededVoxels& needed, const WaveOptions& options,
             PartMonitor& monitor);

    /// Adds the light of channels whose bits are set in `channels`, in a medium of `extinction` [1/m].
    void run(double extinction, unsigned channels, LightField& field, BakeReport& report, WaveRun& run);

private:
    /// What a run stands on, from before the first step.
    struct Ready {
        WaveRelease release;
        WaveCells cells;
        WavePulse pulse{1};
        WaveDifferencing grid;
        glm::dvec3 flat_direction{0};  ///< of the light under flat water, along which waves are made as fast as light
        double speed = 1;              ///< that makes them so
        double slowest = 1;            ///< largest index over the least
    };
    /// Where a run's light goes.
    struct Target {
        LightField& field;
        unsigned channels;  ///< bits
    };

    int order() const { return paper_ ? 2 : 4; }
    bool amplitude() const { return options_.accumulate == WaveAccumulate::Amplitude; }

    void chooseWavelength(WaveRun& run) const;
    void prepare(double extinction, const WaveRun& run, Ready& out);
    std::vector<std::uint8_t> wantedBlocks(const WaveCells& cells) const;
    WaveSettings settingsOf(const Ready& ready, double extinction, bool flux, double points) const;
    void setScales(const Ready& ready);
    void step(const Ready& ready, WaveStepper& stepper) const;
    int slotOf(const WaveCells& cells, int block) const;
    void fold(const Ready& ready, int block, const float* sums, const Target& to) const;
    void add(const Target& to, float* out, double energy, const glm::dvec3& flux) const;
    void addRim(const Ready& ready, const Target& to) const;
    void reportBand(const WaveRun& run, BakeReport& report) const;
    void warn(const WaveRelease& release, const WaveRun& run) const;
    void countLight(const WaveRelease& release, unsigned channels, BakeReport& report) const;
    double meanIrradiance(unsigned channels) const;

    const Scene& scene_;
    const Surface surface_;
    const Light& light_;
    const NeededVoxels& needed_;
    const WaveOptions& options_;
    PartMonitor& monitor_;
    std::optional<WaveIndex> index_;
    const bool paper_;
    double scale_energy_ = 1, scale_field_ = 1;
    std::optional<WaveFluxScale> flux_scale_;
};

}  // namespace photic
