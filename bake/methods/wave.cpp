// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <numbers>

#include "bake/field/disc_blur.h"
#include "bake/field/lobes.h"
#include "bake/field/post_process.h"
#include "bake/methods/method_options.h"
#include "bake/methods/part_monitor.h"
#include "bake/methods/sun_disc.h"
#include "bake/methods/wave_cost.h"
#include "bake/methods/wave_domain.h"
#include "bake/methods/wave_index.h"
#include "bake/methods/wave_refusal.h"
#include "bake/numerics/wave_calibration.h"
#include "bake/optics/snell.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr double kFewestPoints = 3, kEnoughPoints = 5;

std::span<const OptionBinding<WaveOptions>> waveOptions() {
    using O = WaveOptions;
    static const std::vector<OptionBinding<O>> bindings{
        bindOption<O, WavePreset>(
            "preset", &O::preset, {{"none", WavePreset::None}, {"mercier", WavePreset::Mercier}},
            "mercier: the paper's own variant (infinite index, at rest, second order, sponge, sum of phi)"),
        bindOption("wavelength", &O::wavelength, {0, 1e6}, "m",
                   "of the pulse, where the index is largest; 0: `points` cells"),
        bindOption("points", &O::points, {kFewestPoints, 1000}, "cells", "a wavelength, where `wavelength` is 0"),
        bindOption("cells", &O::cells, {1, 8}, "", "of the waves, along each side of a voxel: 1, 2, 4 or 8"),
        bindOption<O, WaveAccumulate>(
            "accumulate", &O::accumulate,
            {{"energy", WaveAccumulate::Energy}, {"amplitude", WaveAccumulate::Amplitude}},
            "phi_t^2, which tends to the irradiance, or the paper's sum of phi, which is harmonic"),
        bindOption<O, WaveAbsorber>("absorber", &O::absorber,
                                    {{"pml", WaveAbsorber::Pml}, {"sponge", WaveAbsorber::Sponge}},
                                    "at the open sides: a matched layer of 8 cells, or the paper's band of damping"),
        bindOption("sponge_cells", &O::sponge_cells, {4, 256}, "cells", "width of the sponge"),
        bindOption("courant", &O::courant, {0.05, 1}, "", "time step over the largest stable one"),
        bindOption("threshold", &O::threshold, {1e-6, 0.1}, "",
                   "amplitude, over that of unfocused light, below which blocks are given up"),
        bindOption("disc", &O::disc, "blur by the sun's disc, where one blur a layer serves; otherwise a point sun"),
        bindOption("clamp", &O::clamp, "preset mercier: phi >= 0 after each step"),
        bindOption("gain", &O::gain, {0, 1e6}, "", "a of a * phi^b, of the amplitude"),
        bindOption("exponent", &O::exponent, {0.01, 100}, "", "b of a * phi^b, of the amplitude"),
    };
    return bindings;
}

WaveOptions withPreset(WaveOptions o) {
    if (o.preset != WavePreset::Mercier) return o;
    o.accumulate = WaveAccumulate::Amplitude, o.absorber = WaveAbsorber::Sponge, o.cells = 1;
    return o;
}

/// Power of light through flat water, as irradiance across the refracted ray, for a light of 1 W/m2.
double unfocused(const Surface& surface, const Light& light) {
    const glm::dvec3 up(0, 0, 1);
    const Interface i = interfaceAt(light.direction, up, surface.ior_above, surface.ior_below);
    return i.transmittance * light.direction.z / i.refracted.z;
}

/// The scene's surface; over an index that varies, with its least below: waves are timed by that.
Surface withLeastIndex(const Scene& scene) {
    Surface surface = scene.surfaces.front();
    if (scene.index) surface.ior_below = scene.index->least();
    return surface;
}

/// How much slower than light waves of `points` cells run along an axis: d(omega)/omega of the fourth-order difference,
/// whose symbol is k^2 (1 - (k h)^4 / 90).
double lag(double points) { return std::pow(2 * std::numbers::pi / points, 4) / 180; }

/// One light through one surface.
class WaveBake {
public:
    WaveBake(const Scene& scene, const Light& light, const NeededVoxels& needed, const WaveOptions& options,
             PartMonitor& monitor)
        : scene_(scene),
          surface_(withLeastIndex(scene)),
          light_(light),
          needed_(needed),
          options_(options),
          monitor_(monitor) {
        paper_ = options.preset == WavePreset::Mercier;
    }

    /// Adds the light of channels whose bits are set in `channels`, in a medium of `extinction`.
    void run(double extinction, unsigned channels, LightField& field, BakeReport& report, WaveRun& run) {
        const auto start = Clock::now();
        const GridFrame& frame = needed_.frame();
        double coarsest = 0;
        for (int a = 0; a < 3; ++a)
            coarsest = std::max(coarsest, std::fabs(frame.worldFromIndex()[a][a]) / options_.cells);
        run.wavelength = options_.wavelength > 0 ? options_.wavelength : options_.points * coarsest;
        run.points = run.wavelength / coarsest;
        checkResolution(run, coarsest);

        const double slowest = scene_.index ? scene_.index->largest() / scene_.index->least() : 1;
        WaveRelease release;
        const WaveCells cells = waveCells(
            scene_, surface_, light_, frame,
            {options_.cells, run.wavelength * slowest, options_.absorber, options_.sponge_cells, paper_}, release);
        const WavePulse pulse =
            WavePulse::ofWavelength(run.wavelength * slowest, amplitude() ? PulseShape::Bump : PulseShape::Slope);
        const double dt = options_.courant * WaveStepper::largestStep(cells.grid.spacing, order());
        // The light under flat water, along which the scheme's waves are made to run as fast as light.
        const Interface flat = interfaceAt(light_.direction, {0, 0, 1}, surface_.ior_above, surface_.ior_below);
        const double speed = paper_ ? 1
                                    : tunedSpeed(pulse.frequency(), dt, cells.grid.spacing, order(), flat.refracted,
                                                 (1 - 1e-9) / options_.courant);
        if (scene_.index)
            index_.emplace(*scene_.index, cells, WaveScheme{pulse, dt, order(), speed},
                           surface_.ior_above * light_.direction);
        if (paper_)
            releaseAtRest(cells, release);
        else
            releasePulse(cells, surface_, light_, pulse, extinction, index_ ? &*index_ : nullptr, release);

        std::vector<std::uint8_t> wanted(static_cast<std::size_t>(cells.grid.count()));
        for (int b = 0; b < cells.grid.count(); ++b) wanted[static_cast<std::size_t>(b)] = slotOf(cells, b) >= 0;
        WaveSettings settings;
        settings.order = order();
        settings.courant = options_.courant, settings.speed = speed;
        // Energy falls twice as fast as phi, and by the time that it takes.
        const double travel =
            paper_ ? 1 : schemeGroupVelocity(pulse.frequency(), dt, cells.grid.spacing, order(), flat.refracted, speed);
        settings.damping = travel * extinction / 2;
        settings.absorber = options_.absorber, settings.sponge_cells = options_.sponge_cells;
        const bool flux = field.channels().flux;
        settings.sum = flux ? WaveSum::EnergyAndFlux : amplitude() ? WaveSum::Nothing : WaveSum::Energy;
        settings.sum_field = amplitude();
        settings.clamp = paper_ && options_.clamp;
        settings.threshold = options_.threshold * (paper_ ? 1 : std::sqrt(unfocused(surface_, light_) / slowest));
        if (index_) settings.speed2 = [&](int block, float* speed2) { index_->fillSpeed2(block, speed2); };
        // phi_t^2 has twice the frequency of phi, and 13 steps a period at 6 cells a wavelength: every third step
        // samples it finely enough (tests/methods), and the sums are most of the traffic with memory.
        settings.sum_every = paper_ ? 1 : std::clamp(static_cast<int>(run.points / 2), 1, 4);

        report.seconds.emplace_back("release", secondsSince(start));

        const auto stepping = Clock::now();
        WaveStepper stepper(cells.grid, settings, std::move(release.source), std::move(wanted),
                            [&](int block, const float* sums) { fold(cells, release, block, sums, channels, field); });
        run.dt = stepper.dt();
        // Sums are taken over those of a plane wave along the light under flat water.
        scale_energy_ =
            1 / planeSums(pulse, run.dt, cells.grid.spacing, settings.order, flat.refracted, 1 / speed).energy;
        flux_scale_.emplace(pulse, run.dt, cells.grid.spacing, settings.order, flat.refracted, speed);
        // The paper's start is a slab of one cell at rest: half of it runs down, and phi sums up to half a cell's time.
        scale_field_ = 1 / (paper_ ? 0.5 * cells.grid.spacing.z : pulse.integral());
        const double begin = stepper.time();
        const double crossing =
            slowest * glm::length(glm::dvec3(cells.size()) * cells.grid.spacing) + 2 * pulse.reach();
        while (!stepper.finished()) {
            stepper.step();
            if (stepper.counts().steps % 16 != 0) continue;
            monitor_.checkCancelled();
            const double passed = stepper.time() - begin;
            monitor_.progress("waves", std::min(0.99, passed / crossing));
            // What is still there after three crossings is a slow remainder between the surface and itself.
            if (passed > 3 * crossing) break;
        }
        stepper.finish();
        run.counts = stepper.counts();
        if (!paper_) addRim(cells, release, channels, field);
        report.seconds.emplace_back("waves", secondsSince(stepping));
        fillReport(release, channels, run, report);
        monitor_.nextPart();
    }

private:
    int order() const { return paper_ ? 2 : 4; }
    bool amplitude() const { return options_.accumulate == WaveAccumulate::Amplitude; }

    void checkResolution(const WaveRun& run, double coarsest) {
        if (run.points < kFewestPoints * (1 - 1e-9))
            throw Error(
                ErrorCode::Input,
                fmt::format(
                    "a wavelength of {:.4g} m is {:.2g} cells of {:.4g} m, and waves need {:g} to run at all; use "
                    "wavelength = {:.4g} or more, or cells = {} or a smaller voxel_size",
                    run.wavelength, run.points, coarsest, kFewestPoints, kEnoughPoints * coarsest,
                    std::min(8, 2 * options_.cells)),
                "wave.wavelength");
    }

    int slotOf(const WaveCells& cells, int block) const {
        const glm::ivec3 b = cells.low_block + cells.grid.place(block);
        const int r = cells.per_voxel;
        return needed_.slotOf(
            {(b.x * kWaveSide) >> shift(r), (b.y * kWaveSide) >> shift(r), (b.z * kWaveSide) >> shift(r)});
    }
    static int shift(int per_voxel) { return std::countr_zero(static_cast<unsigned>(per_voxel)); }

    /// The part of a cell below the surface, from its middle.
    static float wetPart(const WaveCells& cells, const WaveRelease& release, const glm::ivec3& local) {
        const float level = release.level[static_cast<std::size_t>(local.x) * static_cast<std::size_t>(cells.size().y) +
                                          static_cast<std::size_t>(local.y)];
        const float above = level - static_cast<float>(local.z);
        return above <= 0 ? 0.0f : std::min(1.0f, above + 0.5f);
    }

    /// Adds a block's sums to the voxels that it lies in.
    void fold(const WaveCells& cells, const WaveRelease& release, int block, const float* sums, unsigned channels,
              LightField& field) {
        const int slot = slotOf(cells, block);
        if (slot < 0) return;
        float* out = field.makeDense(slot);
        const NeededVoxels::Mask& mask = needed_.mask(slot);
        const int s = shift(cells.per_voxel), light_channels = field.channels().irradiance;
        const glm::ivec3 place = cells.grid.place(block) * kWaveSide, origin = cells.lowCell();
        const double share = 1.0 / (cells.per_voxel * cells.per_voxel * cells.per_voxel);
        const bool flux = field.channels().flux;
        const float* amplitude_sum = amplitude() ? sums + (flux ? 4 : 0) * kWaveCells : nullptr;
        for (int i = 0; i < kWaveCells; ++i) {
            const glm::ivec3 local = place + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const glm::ivec3 cell = origin + local;
            if (glm::any(glm::lessThan(cell, cells.asked_low)) || glm::any(glm::greaterThan(cell, cells.asked_high)))
                continue;
            const int v = NeededVoxels::offsetInLeaf(cell >> s);
            if (!NeededVoxels::maskBit(mask, v)) continue;
            const double wet = wetPart(cells, release, local) * share;
            if (wet <= 0) continue;
            double energy = sums[i] * scale_energy_;
            if (index_) energy *= index_->carriedAt(cells.world(glm::dvec3(cell)));
            glm::dvec3 f(0);
            if (flux) f = (*flux_scale_)({sums[kWaveCells + i], sums[2 * kWaveCells + i], sums[3 * kWaveCells + i]});
            if (amplitude_sum) {
                const double value =
                    options_.gain * std::pow(std::max(0.0, double(amplitude_sum[i]) * scale_field_), options_.exponent);
                f *= energy > 0 ? value / std::max(energy, glm::length(f)) : 0.0;
                energy = value;
            }
            add(out, v, light_channels, channels, energy * wet, f * wet, flux);
        }
    }

    void add(float* out, int v, int light_channels, unsigned channels, double energy, const glm::dvec3& f,
             bool flux) const {
        double mean = 0;
        for (int c = 0; c < light_channels; ++c) {
            if ((channels >> c & 1) == 0) continue;
            out[c * kWaveCells + v] += static_cast<float>(energy * light_.irradiance[c]);
            mean += light_.irradiance[c] / light_channels;
        }
        if (!flux) return;
        for (int a = 0; a < 3; ++a) out[(light_channels + a) * kWaveCells + v] += static_cast<float>(f[a] * mean);
    }

    /// Light in cells that the surface cuts above their middle.
    void addRim(const WaveCells& cells, const WaveRelease& release, unsigned channels, LightField& field) {
        const double share = 1.0 / (cells.per_voxel * cells.per_voxel * cells.per_voxel);
        const int s = shift(cells.per_voxel);
        for (const WaveRim& rim : release.rim) {
            const glm::ivec3 voxel = rim.cell >> s;
            if (!needed_.contains(voxel)) continue;
            add(field.makeDense(needed_.slotOf(voxel)), NeededVoxels::offsetInLeaf(voxel), field.channels().irradiance,
                channels, rim.energy * share, glm::dvec3(rim.direction) * double(rim.energy) * share,
                field.channels().flux);
        }
    }

    void fillReport(const WaveRelease& release, unsigned channels, const WaveRun& run, BakeReport& report) {
        const double all = static_cast<double>(run.counts.blocks) * static_cast<double>(run.counts.steps);
        report.skipped.push_back(fmt::format(
            "{:.0f} % of a full grid's {} steps: the band held {:.1f} % of {} blocks on average, {:.1f} % at most, "
            "{:.1f} bytes a cell of it",
            100 - 100 * static_cast<double>(run.counts.block_steps) / all, run.counts.steps,
            100 * static_cast<double>(run.counts.block_steps) / all, run.counts.blocks,
            100 * static_cast<double>(run.counts.peak_blocks) / static_cast<double>(run.counts.blocks),
            static_cast<double>(run.counts.peak_bytes) / static_cast<double>(run.counts.peak_blocks * kWaveCells)));
        const auto warn = [&](const std::string& text) { monitor_.warn(text); };
        const HeightField& field = *surface_.height_field;
        if (paper_) {
            warn(
                "preset mercier is the paper's: rays leave the surface at right angles (infinite index), and the sum "
                "of phi is "
                "harmonic, so that it shows no caustics");
            return;
        }
        if (run.points < kEnoughPoints)
            warn(fmt::format(
                "{:.2g} cells a wavelength: along the axes waves lag {:.1f} % behind the light and bend it; {:g} "
                "lag {:.1f} % (raise points, or cells)",
                run.points, 100 * lag(run.points), kEnoughPoints + 1, 100 * lag(kEnoughPoints + 1)));
        if (run.wavelength > field.featureSize())
            warn(fmt::format(
                "the wavelength, {:.3g} m, is longer than the surface's details of {:.3g} m, whose light it cannot "
                "focus; use a smaller voxel_size, or cells",
                run.wavelength, field.featureSize()));
        // A fold's Airy width (R / 2 k^2)^(1/3), R the caustic's radius of curvature, of the order of its depth.
        const GridFrame& frame = needed_.frame();
        const double depth = std::max(1e-9, field.maxZ() - frame.worldFromIndex(glm::dvec3(frame.min)).z);
        const double k = 2 * std::numbers::pi / run.wavelength, airy = std::cbrt(depth / (2 * k * k));
        const double voxel = std::cbrt(frame.voxelVolume());
        if (airy > voxel)
            warn(fmt::format(
                "caustics {:.2g} m deep are about {:.2g} m wide ({:.2g} voxels) at a wavelength of {:.3g} m; shorter "
                "waves (cells, a smaller voxel_size) are sharper",
                depth, airy, airy / voxel, run.wavelength));
        if (release.folded > 1e-3)
            warn(fmt::format("the surface bends more sharply than the cells resolve at {:.2g} % of it",
                             100 * release.folded));
        if (release.turned_away > 0)
            warn(fmt::format(
                "{:.3g} % of the surface turns away from the light; the shadow that it casts on itself is left out",
                100 * release.turned_away));

        // What is launched and reflected is counted at the surface; that the rest leaves is taken for granted. The path
        // ledger sets the waves' own sum against that of rays through the box: it is off by what waves do differently.
        const double irradiance = meanIrradiance(channels);
        report.power.emitted += release.launched * irradiance;
        report.power.reflected += release.reflected * irradiance;
        report.path.expected += release.path * irradiance;
        report.power.escaped += (release.launched - release.reflected) * irradiance;
    }
    double meanIrradiance(unsigned channels) const {
        const int count = scene_.coloured() ? 3 : 1;
        double sum = 0;
        for (int c = 0; c < count; ++c)
            if (channels >> c & 1) sum += light_.irradiance[c] / count;
        return sum;
    }

    const Scene& scene_;
    const Surface surface_;
    const Light& light_;
    const NeededVoxels& needed_;
    const WaveOptions& options_;
    PartMonitor& monitor_;
    std::optional<WaveIndex> index_;
    bool paper_ = false;
    double scale_energy_ = 1, scale_field_ = 1;
    std::optional<WaveFluxScale> flux_scale_;
};

/// Irradiance over what flat water would let through, or the paper's sum as it is.
LightField causticGrid(const LobeFields& lobes, double flat) {
    LightField caustic(lobes.first.neededPtr(), {1, false});
    forEachLeaf(lobes.first.needed(), [&](int slot) {
        std::array<double, LightField::kLeafVoxels> light;
        if (!totalIrradiance(lobes, slot, light.data())) return;
        float* out = caustic.makeDense(slot);
        for (std::size_t v = 0; v < light.size(); ++v) out[v] = static_cast<float>(light[v] / flat);
    });
    return caustic;
}

/// Whether light as a whole travels against an axis.
bool goesAgainst(const LightField& field, const glm::dvec3& axis) {
    const int f = field.channels().irradiance;
    return glm::dot(glm::dvec3(field.sum(f), field.sum(f + 1), field.sum(f + 2)), axis) < 0;
}

BakeResult bakeFromCatalogue(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                             Monitor& monitor) {
    WaveOptions options;
    applyOptions("wave", options, waveOptions(), given);
    if (!std::has_single_bit(static_cast<unsigned>(options.cells)))
        throw Error(ErrorCode::Input,
                    fmt::format("option 'cells' of method 'wave' is {}; give 1, 2, 4 or 8", options.cells),
                    given.at("cells").where);
    return bakeWave(scene, std::move(needed), options, monitor);
}

}  // namespace

BakeResult bakeWave(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const WaveOptions& given,
                    Monitor& monitor, WaveRun* run) {
    const WaveOptions options = withPreset(given);
    if (scene.index && (options.accumulate == WaveAccumulate::Amplitude || options.absorber == WaveAbsorber::Sponge))
        throw Error(
            ErrorCode::Input,
            "the paper's sum and its sponge are for one index, and the scene has an [[index]]; use accumulate = "
            "\"energy\" and absorber = \"pml\"",
            "wave");
    const FieldChannels channels{scene.coloured() ? 3 : 1, scene.bake.grids.direction};
    BakeReport report;
    const int runs = static_cast<int>(scene.lights.size()) * (scene.medium.coloured() ? 3 : 1);
    PartMonitor progress(monitor, runs);

    LobeFields lobes = emptyLobes(needed, channels, scene.lights.size() > 1 && scene.bake.lobe_axis);
    LightField& field = lobes.first;
    WaveRun last;
    double flat = 0;
    const glm::dvec3 extinction = scene.medium.extinction();
    for (const Light& light : scene.lights) {
        LightField part(needed, channels);
        LightField& to = scene.lights.size() == 1 ? field : part;
        WaveBake bake(scene, light, *needed, options, progress);
        if (scene.medium.coloured()) {
            for (int c = 0; c < 3; ++c) bake.run(extinction[c], 1u << c, to, report, last);
        } else {
            bake.run(extinction.x, channels.irradiance == 3 ? 7u : 1u, to, report, last);
        }
        const auto start = Clock::now();
        if (channels.flux) restoreFluxBound(to);
        if (options.disc && light.angular_diameter_deg > 0 && options.preset == WavePreset::None) {
            if (!scene.index && blurServes(scene, light, needed->frame())) {
                blurLayers(to, discKernels(scene.surfaces.front(), light, needed->frame()), BeyondNeeded::Alike);
                report.seconds.emplace_back("disc", secondsSince(start));
            } else {
                monitor.warn("the sun's disc is left out: one blur a layer does not serve this scene");
            }
        }
        if (&to == &part)
            addField(lobes.second && goesAgainst(part, *scene.bake.lobe_axis) ? *lobes.second : field, part);
        double mean = 0;
        for (int c = 0; c < channels.irradiance; ++c) mean += light.irradiance[c] / channels.irradiance;
        Surface below = scene.surfaces.front();
        if (scene.index) below.ior_below = scene.index->at(below.center);
        flat += mean * unfocused(below, light);
    }
    double deposited = 0;
    for (int c = 0; c < channels.irradiance; ++c)
        deposited += (field.sum(c) + (lobes.second ? lobes.second->sum(c) : 0)) * needed->frame().voxelVolume() /
                     channels.irradiance;
    // The path ledger is a law of rays: waves diffract through the box's sides and through its surface. What they carry
    // over what rays would is said beside it; rays are followed through the whole box only.
    std::map<std::string, std::string> metadata;
    if (needed->isEverything() && !scene.index && options.accumulate == WaveAccumulate::Energy &&
        report.path.expected > 0) {
        last.path_over_rays = deposited / report.path.expected;
        metadata["path_over_rays"] = fmt::format("{:.6f}", last.path_over_rays);
    }
    report.path.deposited = report.path.expected = deposited;
    std::optional<LightField> caustic;
    if (scene.bake.grids.caustic) caustic = causticGrid(lobes, flat);
    if (run) *run = last;
    BakeResult result{std::move(field), std::move(report), std::nullopt, std::nullopt, std::move(caustic)};
    result.second = std::move(lobes.second);
    result.metadata = std::move(metadata);
    return result;
}

Method waveMethod() {
    return {"wave",
            "Accumulated waves [Mercier 2014]: the light that a short pulse carries through the water, diffraction "
            "included",
            {"irradiance", "direction", "caustic"},
            optionSpecs(waveOptions()),
            waveRefusal,
            [](const CostQuestion& question) {
                WaveOptions options;
                applyOptions("wave", options, waveOptions(), question.options);
                return waveCost(question, options);
            },
            bakeFromCatalogue};
}

}  // namespace photic
