// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/field/disc_blur.h"
#include "bake/field/lobes.h"
#include "bake/field/post_process.h"
#include "bake/methods/method_options.h"
#include "bake/methods/part_monitor.h"
#include "bake/methods/sun_disc.h"
#include "bake/methods/wave_cost.h"
#include "bake/methods/wave_refusal.h"
#include "bake/methods/wave_run.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/crest_warnings.h"
#include "bake/scene/index_volume.h"

namespace photic {
namespace {

std::span<const OptionBinding<WaveOptions>> waveOptions() {
    using O = WaveOptions;
    static const std::vector<OptionBinding<O>> bindings{
        bindOption<O, WavePreset>(
            "preset", &O::preset, {{"none", WavePreset::None}, {"mercier", WavePreset::Mercier}},
            "mercier: the paper's own variant (infinite index, at rest, second order, sponge, sum of phi)"),
        bindOption("wavelength", &O::wavelength, {0, 1e6}, "m",
                   "of the pulse, where the index is largest; 0: `points` cells"),
        bindOption("points", &O::points, {kFewestWavePoints, 1000}, "cells", "a wavelength, where `wavelength` is 0"),
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

/// Blurs by the sun's disc where one blur a layer serves.
void blurByDisc(const Scene& scene, const Light& light, LightField& field, BakeReport& report, Monitor& monitor) {
    if (light.angular_diameter_deg <= 0) return;
    if (scene.index || !blurServes(scene, light, field.frame())) {
        monitor.warn("the sun's disc is left out: one blur a layer does not serve this scene");
        return;
    }
    const Stopwatch watch;
    blurLayers(field, discKernels(scene.surfaces.front(), light, field.frame()), BeyondNeeded::Alike);
    report.seconds.emplace_back("disc", watch.seconds());
}

/// What flat water lets through of a light, the mean of its channels.
double flatLight(const Scene& scene, const Light& light, int channels) {
    double mean = 0;
    for (int c = 0; c < channels; ++c) mean += light.irradiance[c] / channels;
    Surface below = scene.surfaces.front();
    if (scene.index) below.ior_below = scene.index->at(below.center);
    return mean * throughFlatWater(below, light);
}

/// Irradiance times volume, the mean of the channels.
double depositedLight(const LobeFields& lobes) {
    const LightField& field = lobes.first;
    const int channels = field.channels().irradiance;
    double deposited = 0;
    for (int c = 0; c < channels; ++c)
        deposited +=
            (field.sum(c) + (lobes.second ? lobes.second->sum(c) : 0)) * field.frame().voxelVolume() / channels;
    return deposited;
}

void refuseIndexOfThePaper(const Scene& scene, const WaveOptions& options) {
    if (scene.index && (options.accumulate == WaveAccumulate::Amplitude || options.absorber == WaveAbsorber::Sponge))
        throw Error(
            ErrorCode::Input,
            "the paper's sum and its sponge are for one index, and the scene has an [[index]]; use accumulate = "
            "\"energy\" and absorber = \"pml\"",
            "wave");
}

/// Bakes a scene's lights one after the other.
class WaveLights {
public:
    WaveLights(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const WaveOptions& options,
               Monitor& monitor)
        : scene_(scene),
          needed_(std::move(needed)),
          options_(options),
          monitor_(monitor),
          progress_(monitor, static_cast<int>(scene.lights.size()) * (scene.medium.coloured() ? 3 : 1)),
          channels_{scene.coloured() ? 3 : 1, scene.bake.grids.direction},
          lobes_(emptyLobes(needed_, channels_, scene.lights.size() > 1 && scene.bake.lobe_axis)) {}

    void add(const Light& light) {
        LightField part(needed_, channels_);
        LightField& to = scene_.lights.size() == 1 ? lobes_.first : part;
        WaveBake bake(scene_, light, *needed_, options_, progress_);
        const glm::dvec3 extinction = scene_.medium.extinction();
        if (scene_.medium.coloured()) {
            for (int c = 0; c < 3; ++c) bake.run(extinction[c], 1u << c, to, report_, last_);
        } else {
            bake.run(extinction.x, channels_.irradiance == 3 ? 7u : 1u, to, report_, last_);
        }
        if (channels_.flux) restoreFluxBound(to);
        if (options_.disc && options_.preset == WavePreset::None) blurByDisc(scene_, light, to, report_, monitor_);
        if (&to == &part)
            addField(lobes_.second && goesAgainst(part, *scene_.bake.lobe_axis) ? *lobes_.second : lobes_.first, part);
        flat_ += flatLight(scene_, light, channels_.irradiance);
    }

    /// What all lights have given; the last call.
    BakeResult finish(WaveRun* run) {
        const double deposited = depositedLight(lobes_);
        // The path ledger is a law of rays: waves diffract through the box's sides and through its surface. What they
        // carry over what rays would is said beside it; rays are followed through the whole box only.
        std::map<std::string, std::string> metadata;
        if (needed_->isEverything() && !scene_.index && options_.accumulate == WaveAccumulate::Energy &&
            report_.path.expected > 0) {
            last_.path_over_rays = deposited / report_.path.expected;
            metadata["path_over_rays"] = fmt::format("{:.6f}", last_.path_over_rays);
        }
        report_.path.deposited = report_.path.expected = deposited;
        std::optional<LightField> caustic;
        if (scene_.bake.grids.caustic) caustic = causticGrid(lobes_, flat_);
        if (run) *run = last_;
        BakeResult result{std::move(lobes_.first), std::move(report_), std::nullopt, std::nullopt, std::move(caustic)};
        result.second = std::move(lobes_.second);
        result.metadata = std::move(metadata);
        return result;
    }

private:
    const Scene& scene_;
    const std::shared_ptr<const NeededVoxels> needed_;
    const WaveOptions& options_;
    Monitor& monitor_;
    PartMonitor progress_;
    const FieldChannels channels_;
    LobeFields lobes_;
    BakeReport report_;
    WaveRun last_;
    double flat_ = 0;  ///< what flat water would let through
};

}  // namespace

BakeResult bakeWave(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const WaveOptions& given,
                    Monitor& monitor, WaveRun* run) {
    const WaveOptions options = withPreset(given);
    refuseIndexOfThePaper(scene, options);
    for (const std::string& warning : crestWarnings(scene)) monitor.warn(warning);
    WaveLights lights(scene, std::move(needed), options, monitor);
    for (const Light& light : scene.lights) lights.add(light);
    return lights.finish(run);
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
