// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wave_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <numbers>

#include "bake/methods/wave_domain.h"
#include "bake/optics/snell.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/index_volume.h"

namespace photic {
namespace {

constexpr double kEnoughPoints = 5;

/// The scene's surface; over an index that varies, with its least below: waves are timed by that.
Surface withLeastIndex(const Scene& scene) {
    Surface surface = scene.surfaces.front();
    if (scene.index) surface.ior_below = scene.index->least();
    return surface;
}

/// How much slower than light waves of `points` cells run along an axis: d(omega)/omega of the fourth-order difference,
/// whose symbol is k^2 (1 - (k h)^4 / 90).
double lag(double points) { return std::pow(2 * std::numbers::pi / points, 4) / 180; }

/// log2 of the cells a voxel.
int voxelShift(const WaveCells& cells) { return std::countr_zero(static_cast<unsigned>(cells.per_voxel)); }

/// A cell's part of its voxel.
double cellShare(const WaveCells& cells) { return 1.0 / (cells.per_voxel * cells.per_voxel * cells.per_voxel); }

/// The part of a cell below the surface, from its middle.
float wetPart(const WaveCells& cells, const WaveRelease& release, const glm::ivec3& local) {
    const float level = release.level[static_cast<std::size_t>(local.x) * static_cast<std::size_t>(cells.size().y) +
                                      static_cast<std::size_t>(local.y)];
    const float above = level - static_cast<float>(local.z);
    return above <= 0 ? 0.0f : std::min(1.0f, above + 0.5f);
}

}  // namespace

double throughFlatWater(const Surface& surface, const Light& light) {
    const glm::dvec3 up(0, 0, 1);
    const Interface i = interfaceAt(light.direction, up, surface.ior_above, surface.ior_below);
    return i.transmittance * light.direction.z / i.refracted.z;
}

WaveBake::WaveBake(const Scene& scene, const Light& light, const NeededVoxels& needed, const WaveOptions& options,
                   PartMonitor& monitor)
    : scene_(scene),
      surface_(withLeastIndex(scene)),
      light_(light),
      needed_(needed),
      options_(options),
      monitor_(monitor),
      paper_(options.preset == WavePreset::Mercier) {}

void WaveBake::run(double extinction, unsigned channels, LightField& field, BakeReport& report, WaveRun& run) {
    Stopwatch watch;
    chooseWavelength(run);
    Ready ready;
    prepare(extinction, run, ready);
    std::vector<std::uint8_t> wanted = wantedBlocks(ready.cells);
    const WaveSettings settings = settingsOf(ready, extinction, field.channels().flux, run.points);
    report.seconds.emplace_back("release", watch.lap());

    const Target to{field, channels};
    WaveStepper stepper(ready.cells.grid, settings, std::move(ready.release.source), std::move(wanted),
                        [&](int block, const float* sums) { fold(ready, block, sums, to); });
    run.dt = ready.grid.dt = stepper.dt();
    setScales(ready);
    step(ready, stepper);
    run.counts = stepper.counts();
    if (!paper_) addRim(ready, to);
    report.seconds.emplace_back("waves", watch.lap());
    reportBand(run, report);
    warn(ready.release, run);
    if (!paper_) countLight(ready.release, channels, report);
    monitor_.nextPart();
}

/// @throws Error{Input} where the waves are too short for the cells
void WaveBake::chooseWavelength(WaveRun& run) const {
    const GridFrame& frame = needed_.frame();
    double coarsest = 0;
    for (int a = 0; a < 3; ++a) coarsest = std::max(coarsest, std::fabs(frame.worldFromIndex()[a][a]) / options_.cells);
    run.wavelength = options_.wavelength > 0 ? options_.wavelength : options_.points * coarsest;
    run.points = run.wavelength / coarsest;
    if (run.points < kFewestWavePoints * (1 - 1e-9))
        throw Error(
            ErrorCode::Input,
            fmt::format("a wavelength of {:.4g} m is {:.2g} cells of {:.4g} m, and waves need {:g} to run at all; use "
                        "wavelength = {:.4g} or more, or cells = {} or a smaller voxel_size",
                        run.wavelength, run.points, coarsest, kFewestWavePoints, kEnoughPoints * coarsest,
                        std::min(8, 2 * options_.cells)),
            "wave.wavelength");
}

/// The cells, the pulse and what it sets out from.
void WaveBake::prepare(double extinction, const WaveRun& run, Ready& out) {
    out.slowest = scene_.index ? scene_.index->largest() / scene_.index->least() : 1;
    const double longest = run.wavelength * out.slowest;
    const LitSurface lit{surface_, light_};
    out.cells = waveCells(scene_, lit, needed_.frame(),
                          {options_.cells, longest, options_.absorber, options_.sponge_cells, paper_}, out.release);
    out.pulse = WavePulse::ofWavelength(longest, amplitude() ? PulseShape::Bump : PulseShape::Slope);
    const glm::dvec3 spacing = out.cells.grid.spacing;
    out.grid = {options_.courant * WaveStepper::largestStep(spacing, order()), spacing, order()};
    out.flat_direction = interfaceAt(light_.direction, {0, 0, 1}, surface_.ior_above, surface_.ior_below).refracted;
    out.speed =
        paper_ ? 1 : tunedSpeed(out.pulse.frequency(), out.grid, out.flat_direction, (1 - 1e-9) / options_.courant);
    if (scene_.index)
        index_.emplace(*scene_.index, out.cells, WaveScheme{out.pulse, out.grid.dt, order(), out.speed},
                       surface_.ior_above * light_.direction);
    if (paper_)
        releaseAtRest(out.cells, out.release);
    else
        releasePulse(out.cells, lit, {out.pulse, extinction, index_ ? &*index_ : nullptr}, out.release);
}

/// Those whose sums are asked for.
std::vector<std::uint8_t> WaveBake::wantedBlocks(const WaveCells& cells) const {
    std::vector<std::uint8_t> wanted(static_cast<std::size_t>(cells.grid.count()));
    for (int b = 0; b < cells.grid.count(); ++b) wanted[static_cast<std::size_t>(b)] = slotOf(cells, b) >= 0;
    return wanted;
}

WaveSettings WaveBake::settingsOf(const Ready& ready, double extinction, bool flux, double points) const {
    WaveSettings settings;
    settings.order = order();
    settings.courant = options_.courant, settings.speed = ready.speed;
    // Energy falls twice as fast as phi, and by the time that it takes.
    const double travel =
        paper_ ? 1 : schemeGroupVelocity(ready.pulse.frequency(), ready.grid, ready.flat_direction, ready.speed);
    settings.damping = travel * extinction / 2;
    settings.absorber = options_.absorber, settings.sponge_cells = options_.sponge_cells;
    settings.sum = flux ? WaveSum::EnergyAndFlux : amplitude() ? WaveSum::Nothing : WaveSum::Energy;
    settings.sum_field = amplitude();
    settings.clamp = paper_ && options_.clamp;
    settings.threshold =
        options_.threshold * (paper_ ? 1 : std::sqrt(throughFlatWater(surface_, light_) / ready.slowest));
    if (index_) settings.speed2 = [this](int block, float* speed2) { index_->fillSpeed2(block, speed2); };
    // phi_t^2 has twice the frequency of phi, and 13 steps a period at 6 cells a wavelength: every third step
    // samples it finely enough (tests/methods), and the sums are most of the traffic with memory.
    settings.sum_every = paper_ ? 1 : std::clamp(static_cast<int>(points / 2), 1, 4);
    return settings;
}

/// Sums are taken over those of a plane wave along the light under flat water.
void WaveBake::setScales(const Ready& ready) {
    scale_energy_ = 1 / planeSums(ready.pulse, ready.grid, ready.flat_direction, 1 / ready.speed).energy;
    flux_scale_.emplace(ready.pulse, ready.grid, ready.flat_direction, ready.speed);
    // The paper's start is a slab of one cell at rest: half of it runs down, and phi sums up to half a cell's time.
    scale_field_ = 1 / (paper_ ? 0.5 * ready.grid.spacing.z : ready.pulse.integral());
}

/// Steps until the waves have left.
void WaveBake::step(const Ready& ready, WaveStepper& stepper) const {
    const double begin = stepper.time();
    const double crossing =
        ready.slowest * glm::length(glm::dvec3(ready.cells.size()) * ready.grid.spacing) + 2 * ready.pulse.reach();
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
}

int WaveBake::slotOf(const WaveCells& cells, int block) const {
    const glm::ivec3 b = cells.low_block + cells.grid.place(block);
    return needed_.slotOf((b * kWaveSide) >> voxelShift(cells));
}

/// Adds a block's sums to the voxels that it lies in.
void WaveBake::fold(const Ready& ready, int block, const float* sums, const Target& to) const {
    const WaveCells& cells = ready.cells;
    const int slot = slotOf(cells, block);
    if (slot < 0) return;
    float* out = to.field.makeDense(slot);
    const NeededVoxels::Mask& mask = needed_.mask(slot);
    const int s = voxelShift(cells);
    const glm::ivec3 place = cells.grid.place(block) * kWaveSide, origin = cells.lowCell();
    const double share = cellShare(cells);
    const bool flux = to.field.channels().flux;
    const float* amplitude_sum = amplitude() ? sums + (flux ? 4 : 0) * kWaveCells : nullptr;
    for (int i = 0; i < kWaveCells; ++i) {
        const glm::ivec3 local = place + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
        const glm::ivec3 cell = origin + local;
        if (glm::any(glm::lessThan(cell, cells.asked_low)) || glm::any(glm::greaterThan(cell, cells.asked_high)))
            continue;
        const int v = NeededVoxels::offsetInLeaf(cell >> s);
        if (!NeededVoxels::maskBit(mask, v)) continue;
        const double wet = wetPart(cells, ready.release, local) * share;
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
        add(to, out + v, energy * wet, f * wet);
    }
}

/// Adds a light of 1 W/m2 to one voxel, whose first channel is at `out`.
void WaveBake::add(const Target& to, float* out, double energy, const glm::dvec3& flux) const {
    const int light_channels = to.field.channels().irradiance;
    double mean = 0;
    for (int c = 0; c < light_channels; ++c) {
        if ((to.channels >> c & 1) == 0) continue;
        out[c * kWaveCells] += static_cast<float>(energy * light_.irradiance[c]);
        mean += light_.irradiance[c] / light_channels;
    }
    if (!to.field.channels().flux) return;
    for (int a = 0; a < 3; ++a) out[(light_channels + a) * kWaveCells] += static_cast<float>(flux[a] * mean);
}

/// Light in cells that the surface cuts above their middle.
void WaveBake::addRim(const Ready& ready, const Target& to) const {
    const double share = cellShare(ready.cells);
    const int s = voxelShift(ready.cells);
    for (const WaveRim& rim : ready.release.rim) {
        const glm::ivec3 voxel = rim.cell >> s;
        if (!needed_.contains(voxel)) continue;
        add(to, to.field.makeDense(needed_.slotOf(voxel)) + NeededVoxels::offsetInLeaf(voxel), rim.energy * share,
            glm::dvec3(rim.direction) * double(rim.energy) * share);
    }
}

void WaveBake::reportBand(const WaveRun& run, BakeReport& report) const {
    const double all = static_cast<double>(run.counts.blocks) * static_cast<double>(run.counts.steps);
    report.skipped.push_back(fmt::format(
        "{:.0f} % of a full grid's {} steps: the band held {:.1f} % of {} blocks on average, {:.1f} % at most, "
        "{:.1f} bytes a cell of it",
        100 - 100 * static_cast<double>(run.counts.block_steps) / all, run.counts.steps,
        100 * static_cast<double>(run.counts.block_steps) / all, run.counts.blocks,
        100 * static_cast<double>(run.counts.peak_blocks) / static_cast<double>(run.counts.blocks),
        static_cast<double>(run.counts.peak_bytes) / static_cast<double>(run.counts.peak_blocks * kWaveCells)));
}

void WaveBake::warn(const WaveRelease& release, const WaveRun& run) const {
    const HeightField& field = *surface_.height_field;
    if (paper_) {
        monitor_.warn(
            "preset mercier is the paper's: rays leave the surface at right angles (infinite index), and the sum "
            "of phi is "
            "harmonic, so that it shows no caustics");
        return;
    }
    if (run.points < kEnoughPoints)
        monitor_.warn(fmt::format(
            "{:.2g} cells a wavelength: along the axes waves lag {:.1f} % behind the light and bend it; {:g} "
            "lag {:.1f} % (raise points, or cells)",
            run.points, 100 * lag(run.points), kEnoughPoints + 1, 100 * lag(kEnoughPoints + 1)));
    if (run.wavelength > field.featureSize())
        monitor_.warn(fmt::format(
            "the wavelength, {:.3g} m, is longer than the surface's details of {:.3g} m, whose light it cannot "
            "focus; use a smaller voxel_size, or cells",
            run.wavelength, field.featureSize()));
    // A fold's Airy width (R / 2 k^2)^(1/3), R the caustic's radius of curvature, of the order of its depth.
    const GridFrame& frame = needed_.frame();
    const double depth = std::max(1e-9, field.maxZ() - frame.worldFromIndex(glm::dvec3(frame.min)).z);
    const double k = 2 * std::numbers::pi / run.wavelength, airy = std::cbrt(depth / (2 * k * k));
    const double voxel = std::cbrt(frame.voxelVolume());
    if (airy > voxel)
        monitor_.warn(fmt::format(
            "caustics {:.2g} m deep are about {:.2g} m wide ({:.2g} voxels) at a wavelength of {:.3g} m; shorter "
            "waves (cells, a smaller voxel_size) are sharper",
            depth, airy, airy / voxel, run.wavelength));
    if (release.folded > 1e-3)
        monitor_.warn(fmt::format("the surface bends more sharply than the cells resolve at {:.2g} % of it",
                                  100 * release.folded));
}

void WaveBake::countLight(const WaveRelease& release, unsigned channels, BakeReport& report) const {
    // What is launched and reflected is counted at the surface; that the rest leaves is taken for granted. The path
    // ledger sets the waves' own sum against that of rays through the box: it is off by what waves do differently.
    const double irradiance = meanIrradiance(channels);
    report.power.emitted += release.launched * irradiance;
    report.power.reflected += release.reflected * irradiance;
    report.path.expected += release.path * irradiance;
    report.power.escaped += (release.launched - release.reflected) * irradiance;
}

double WaveBake::meanIrradiance(unsigned channels) const {
    const int count = scene_.coloured() ? 3 : 1;
    double sum = 0;
    for (int c = 0; c < count; ++c)
        if (channels >> c & 1) sum += light_.irradiance[c] / count;
    return sum;
}

}  // namespace photic
