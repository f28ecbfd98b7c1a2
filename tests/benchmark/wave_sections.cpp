// SPDX-License-Identifier: Apache-2.0
// The wave method: run time and error beside the paper's Table 1, and error against the wavelength.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/methods/wave.h"
#include "bake/scene/load_toml.h"
#include "tests/benchmark/sections.h"
#include "tests/support/diffracted_light.h"
#include "tests/support/wave_light.h"

namespace photic::benchmark {
namespace {

std::string percent(double part) { return fmt::format("{:.3g} %", 100 * part); }

struct WaveTimed {
    BakeResult result;
    WaveRun run;
    double seconds = 0;  ///< of the stages, without the scene and the write
};
WaveTimed bakeOnce(const Scene& scene, const WaveOptions& options) {
    Monitor monitor;
    const auto needed = std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, sceneFrame(scene), monitor));
    WaveRun run;
    BakeResult result = bakeWave(scene, needed, options, monitor, &run);
    double seconds = 0;
    for (const auto& stage : result.report.seconds) seconds += stage.second;
    return {std::move(result), run, seconds};
}

/// A sine wave under light that falls straight down, one voxel thin.
struct Ripples {
    static constexpr double kAmplitude = 0.03, kWavelength = 0.5, kIor = 1.333, kBottom = -1.5, kTop = 0.0625;
    int cells;
    Scene scene() const {
        Monitor monitor;
        return parseScene(
            fmt::format("photic = 1\n[domain]\nmin = [-0.5, 0, {}]\nmax = [0.5, {}, {}]\nvoxel_size = {}\n[[light]]\n"
                        "type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1.0\nangular_diameter = 0\n[[surface]]\n"
                        "name = \"water\"\nkind = \"height_field\"\nsize = [2.0, 0.5]\noutside = \"periodic\"\nwaves = "
                        "[{{ amplitude = {}, wavelength = {}, direction = 0, phase = {:.17g} }}]\n",
                        kBottom, 1.0 / cells, kTop, 1.0 / cells, kAmplitude, kWavelength, std::numbers::pi / 2),
            "ripples.toml", ".", 0, monitor);
    }
    double error(const LightField& field) const {
        const int layers = static_cast<int>((kTop - kBottom) * cells + 0.5);
        const truth::WaveLight light(truth::cosineProfile(kAmplitude, 2 * std::numbers::pi / kWavelength), kIor, -1, 1,
                                     1024);
        const truth::VoxelMeans means = light.voxelMeans(-0.5, 1.0 / cells, cells, kBottom, 1.0 / cells, layers);
        double off = 0, sum = 0;
        for (int k = 0; k < layers; ++k)
            for (int i = 0; i < cells; ++i) {
                const double r = means.fluence[means.index(i, k)];
                off += std::fabs(field.irradiance(field.frame().min + glm::ivec3(i, 0, k)) - r), sum += r;
            }
        return off / sum;
    }
    /// Relative L1 between the wave equation's own solution and rays, below the surface.
    double diffraction(double wavelength) const {
        const truth::Profile profile = truth::cosineProfile(kAmplitude, 2 * std::numbers::pi / kWavelength);
        const int layers = static_cast<int>((-0.0625 - kBottom) * cells + 0.5);
        const auto waves =
            truth::DiffractedLight(profile, kIor, 1, wavelength, -0.05).voxelMeans(cells, kBottom, 1.0 / cells, layers);
        const truth::VoxelMeans rays = truth::WaveLight(profile, kIor, -1, 1, 1024)
                                           .voxelMeans(-0.5, 1.0 / cells, cells, kBottom, 1.0 / cells, layers);
        double off = 0, sum = 0;
        for (std::size_t v = 0; v < waves.size(); ++v)
            off += std::fabs(waves[v] - rays.fluence[v]), sum += rays.fluence[v];
        return off / sum;
    }
};

}  // namespace

namespace {

struct Row {
    int n;
    double paper;
};
void poolTable(const std::vector<Row>& rows, Findings& findings) {
    Table table{"Waves in the pool, all threads, beside Mercier's Table 1",
                "Irradiance and direction, no write. The error is against beams on the same grid, whose rays do not "
                "diffract; the "
                "wavelength is 6 cells. `band`: blocks that took part in a step, on average, of those of the domain.",
                {"grid", "[s]", "paper [s]", "paper / ours", "wavelength [m]", "relative L1", "relative RMSE", "band",
                 "bytes a cell of it"},
                {}};
    for (const Row& row : rows) {
        const Case c = poolCase(poolBox(row.n), "beams", {});
        const Timed rays = once(c);
        const WaveTimed wave = bakeOnce(c.scene, {});
        const FieldError e = fieldError(wave.result.field, rays.result.volume.field);
        const WaveCounts& k = wave.run.counts;
        table.add({fmt::format("{}^3", row.n), fmt::format("{:.2f}", wave.seconds),
                   row.paper > 0 ? fmt::format("{:.0f}", row.paper) : "",
                   row.paper > 0 ? fmt::format("{:.0f}", row.paper / wave.seconds) : "",
                   fmt::format("{:.4f}", wave.run.wavelength), percent(e.l1), percent(e.rmse),
                   percent(static_cast<double>(k.block_steps) /
                           (static_cast<double>(k.blocks) * static_cast<double>(k.steps))),
                   fmt::format("{:.1f}",
                               static_cast<double>(k.peak_bytes) / static_cast<double>(k.peak_blocks * kWaveCells))});
    }
    findings.tables.push_back(table);
}

}  // namespace

void wavesLarge(const Effort& effort, Findings& findings) { poolTable({{effort.quick ? 16 : 512, 0}}, findings); }

void waves(const Effort& effort, Findings& findings) {
    poolTable(effort.quick ? std::vector<Row>{{16, 0}} : std::vector<Row>{{64, 17}, {128, 21}, {256, 107}}, findings);
    Table ladder{"Waves under a sine wave, in the plane: error against the wavelength",
                 "Voxel means against those of rays, exact; eight cells a voxel. Last: how far the wave equation's "
                 "exact solution "
                 "is from the rays below z = -0.0625, by its angular spectrum.",
                 {"wavelength, of the box's width", "voxels", "cells a wavelength", "[s]", "relative L1", "slope",
                  "the exact wave's", "slope"},
                 {}};
    for (const int cells : effort.quick ? std::vector<int>{16} : std::vector<int>{64, 128}) {
        const Ripples ripples{cells};
        double before = 0, before_length = 0, exact_before = 0;
        for (const double wavelength :
             effort.quick ? std::vector<double>{0.071} : std::vector<double>{0.071, 0.036, 0.018, 0.011}) {
            if (wavelength * 8 * cells < 5.5) continue;
            WaveOptions options;
            options.cells = 8, options.wavelength = wavelength;
            const WaveTimed wave = bakeOnce(ripples.scene(), options);
            const double error = ripples.error(wave.result.field), exact = ripples.diffraction(wavelength);
            const auto slope = [&](double from, double to) {
                return from > 0 ? fmt::format("{:.2f}", std::log(from / to) / std::log(before_length / wavelength))
                                : "";
            };
            ladder.add({fmt::format("{:.3f}", wavelength), std::to_string(cells),
                        fmt::format("{:.1f}", wave.run.points), fmt::format("{:.2f}", wave.seconds),
                        fmt::format("{:.3f}", error), slope(before, error), fmt::format("{:.3f}", exact),
                        slope(exact_before, exact)});
            before = error, exact_before = exact, before_length = wavelength;
        }
    }
    findings.tables.push_back(ladder);
}

}  // namespace photic::benchmark
