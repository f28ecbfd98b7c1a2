// SPDX-License-Identifier: Apache-2.0
// Waves against rays: closed forms where there are some, the method's own promises elsewhere.
#include "bake/methods/wave.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/field/grid_laws.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wave_pool.h"
#include "tests/support/closed_forms.h"
#include "tests/support/diffracted_light.h"
#include "tests/support/wave_light.h"

namespace photic {
namespace {

/// Keeps what it is warned of.
class Warnings final : public Monitor {
public:
    void warn(const std::string& message) override { all.push_back(message); }
    std::vector<std::string> all;
};

struct Result {
    BakeResult bake;
    WaveRun run;
    std::vector<std::string> warnings;
    const LightField& field() const { return bake.field; }
};

Result bakeText(const std::string& toml, const WaveOptions& options = {}) {
    Warnings monitor;
    const Scene scene = parseScene(toml, "test.toml", ".", 0, monitor);
    const auto needed = std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, sceneFrame(scene), monitor));
    WaveRun run;
    BakeResult bake = bakeWave(scene, needed, options, monitor, &run);
    return {std::move(bake), run, std::move(monitor.all)};
}

/// z = a cos(k x) under light that falls straight down, one voxel thin in y; a metre holds two waves and `cells`
/// voxels.
struct Ripples {
    int cells = 64;
    double extinction = 0;
    int rows = 1;  ///< voxels along y
    static constexpr double kAmplitude = 0.03, kWavelength = 0.5, kIor = 1.333, kBottom = -1.5, kTop = 0.0625;

    std::string toml() const {
        return fmt::format(R"(photic = 1
[domain]
min = [-0.5, 0.0, {bottom}]
max = [0.5, {thickness}, {top}]
voxel_size = {voxel}
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1.0
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [2.0, 0.5]
outside = "periodic"
waves = [{{ amplitude = {amplitude}, wavelength = {wavelength}, direction = 0, phase = {phase:.17g} }}]
[medium]
absorption = {extinction}
)",
                           fmt::arg("bottom", kBottom), fmt::arg("top", kTop), fmt::arg("voxel", 1.0 / cells),
                           fmt::arg("thickness", double(rows) / cells), fmt::arg("amplitude", kAmplitude),
                           fmt::arg("wavelength", kWavelength), fmt::arg("phase", std::numbers::pi / 2),
                           fmt::arg("extinction", extinction));
    }
    int layers() const { return static_cast<int>((kTop - kBottom) * cells + 0.5); }
    truth::VoxelMeans truth() const {
        const double k = 2 * std::numbers::pi / kWavelength;
        return truth::WaveLight(truth::cosineProfile(kAmplitude, k), kIor, -1, 1, 1024, extinction)
            .voxelMeans(-0.5, 1.0 / cells, cells, kBottom, 1.0 / cells, layers());
    }
};

struct Errors {
    double irradiance = 0, flux = 0, energy = 0;  ///< relative L1; sum over the truth's
};
Errors errorsOf(const Ripples& ripples, const LightField& field, const truth::VoxelMeans& means) {
    Errors e;
    double sum = 0, total = 0, flux = 0;
    for (int k = 0; k < ripples.layers(); ++k)
        for (int i = 0; i < ripples.cells; ++i) {
            const auto m = means.index(i, k);
            const glm::ivec3 v = field.frame().min + glm::ivec3(i, 0, k);
            e.irradiance += std::fabs(field.irradiance(v) - means.fluence[m]);
            const glm::dvec3 f(means.across[m], 0, -means.down[m]);
            e.flux += glm::length(field.flux(v) - f), flux += glm::length(f);
            sum += means.fluence[m], total += field.irradiance(v);
        }
    return {e.irradiance / sum, e.flux / flux, total / sum};
}

TEST(Wave, ErrorFallsAsTheRootOfTheWavelength) {
    const Ripples ripples{64};
    const truth::VoxelMeans means = ripples.truth();
    const double wavelengths[] = {0.071, 0.036, 0.018};
    Errors errors[3];
    for (int i = 0; i < 3; ++i) {
        WaveOptions options;
        options.cells = 8, options.wavelength = wavelengths[i];
        errors[i] = errorsOf(ripples, bakeText(ripples.toml(), options).field(), means);
        fmt::print("  wavelength {:.3f} m: relative L1 {:.4f}, of the flux {:.4f}, energy {:.4f}\n", wavelengths[i],
                   errors[i].irradiance, errors[i].flux, errors[i].energy);
        EXPECT_NEAR(errors[i].energy, 1, 5e-3);
    }
    for (int i = 0; i < 2; ++i) {
        const double octaves = std::log2(wavelengths[i] / wavelengths[i + 1]);
        EXPECT_GE(std::log2(errors[i].irradiance / errors[i + 1].irradiance) / octaves, 0.5) << i;
        EXPECT_GE(std::log2(errors[i].flux / errors[i + 1].flux) / octaves, 0.5) << i;
    }
    EXPECT_LT(errors[2].irradiance, 0.16);
}

/// What is left between waves and rays is diffraction, not the solver: against the wave equation's exact solution the
/// error is a half to one per cent at wavelengths at which rays are 15 to 34 % away. At folds it falls as the third
/// root of the wavelength (the width of Airy's integral), which the exact solution's own distance from the rays shows.
TEST(Wave, FollowsTheWaveEquationMoreCloselyThanRays) {
    const Ripples ripples{32};
    constexpr int layers = 46;  // below the surface
    const truth::VoxelMeans rays = ripples.truth();
    for (const double wavelength : {0.071, 0.036}) {
        const double k = 2 * std::numbers::pi / Ripples::kWavelength;
        const std::vector<double> exact =
            truth::DiffractedLight(truth::cosineProfile(Ripples::kAmplitude, k), Ripples::kIor, 1, wavelength, -0.05)
                .voxelMeans(ripples.cells, Ripples::kBottom, 1.0 / ripples.cells, layers);
        WaveOptions options;
        options.cells = 8, options.wavelength = wavelength;
        const BakeResult bake = bakeText(ripples.toml(), options).bake;
        double off = 0, from_rays = 0, exact_from_rays = 0, sum = 0;
        for (int l = 0; l < layers; ++l)
            for (int i = 0; i < ripples.cells; ++i) {
                const double e = exact[static_cast<std::size_t>(l * ripples.cells + i)];
                const double value = bake.field.irradiance(bake.field.frame().min + glm::ivec3(i, 0, l));
                off += std::fabs(value - e), sum += e;
                from_rays += std::fabs(value - rays.fluence[rays.index(i, l)]);
                exact_from_rays += std::fabs(e - rays.fluence[rays.index(i, l)]);
            }
        fmt::print("  wavelength {:.3f} m: from the exact wave {:.4f}, from rays {:.4f}, exact wave from rays {:.4f}\n",
                   wavelength, off / sum, from_rays / sum, exact_from_rays / sum);
        EXPECT_LT(off / sum, 0.015) << wavelength;
        EXPECT_NEAR(from_rays / exact_from_rays, 1, 0.03) << wavelength;
    }
}

TEST(Wave, LayersCarryTheSamePower) {
    const Ripples ripples{64};
    WaveOptions options;
    options.cells = 2;
    const std::vector<double> power = layerPower(bakeText(ripples.toml(), options).field());
    double expected = 0;
    const double k = 2 * std::numbers::pi / Ripples::kWavelength;
    for (int i = 0; i < 1024; ++i) {
        const double slope = k * Ripples::kAmplitude * std::sin(2 * std::numbers::pi * (i + 0.5) / 1024);
        expected += truth::fresnelTransmittance(1 / std::hypot(1, slope), 1, Ripples::kIor) / 1024;
    }
    expected /= ripples.cells;  // through a strip one voxel wide
    const auto wet = static_cast<std::size_t>((-Ripples::kAmplitude - Ripples::kBottom) * ripples.cells);
    for (std::size_t layer = 0; layer + 1 < wet; ++layer) EXPECT_NEAR(power[layer] / expected, 1, 0.01) << layer;
}

TEST(Wave, AbsorptionIsBeersLaw) {
    const Ripples clear{32}, murky{32, 1.2};
    WaveOptions options;
    options.cells = 2;
    const Errors a = errorsOf(clear, bakeText(clear.toml(), options).field(), clear.truth());
    const Errors b = errorsOf(murky, bakeText(murky.toml(), options).field(), murky.truth());
    EXPECT_NEAR(b.energy, a.energy, 1e-2);
    for (const Ripples& r : {clear, murky}) {
        const Result result = bakeText(r.toml(), options);
        fmt::print("  path over that of rays: {:.4f}\n", result.run.path_over_rays);
        EXPECT_NEAR(result.run.path_over_rays, 1, 0.02);
        EXPECT_NE(result.run.path_over_rays, 1) << "the two sides are not computed apart";
        // The ledger is a law of rays: it claims nothing here.
        EXPECT_EQ(result.bake.report.path.imbalance(), 0);
        EXPECT_EQ(result.bake.metadata.count("path_over_rays"), 1u);
    }
    EXPECT_LT(b.irradiance, 1.1 * a.irradiance);
}

template <class Body>
void forEachVoxel(const GridFrame& f, Body body) {
    for (int i = f.min.x; i <= f.max.x; ++i)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int k = f.min.z; k <= f.max.z; ++k) body(glm::ivec3(i, j, k));
}

TEST(Wave, FlatWaterFollowsSnellFresnelAndBeer) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, -0.4, -0.8));
    for (const double absorption : {0.0, 1.5}) {
        const truth::PlaneWater water{800, -d.z, 1, 1.333, absorption};
        const glm::dvec3 w(d.x / 1.333, d.y / 1.333, -water.cosBelow());
        Pool pool;
        pool.absorption = absorption;
        const Result result = bakeText(pool.toml());
        double error = 0, sum = 0, worst = 0, angle = 0;
        int above = 0;
        forEachVoxel(result.field().frame(), [&](const glm::ivec3& v) {
            if (v.z >= 0) {
                above += result.field().irradiance(v) != 0;
                return;
            }
            const double top = -(v.z + 1) * 0.03125, expected = water.meanFluence(top, top + 0.03125);
            const double e = std::fabs(result.field().irradiance(v) - expected);
            error += e, sum += expected, worst = std::max(worst, e / expected);
            angle = std::max(angle, std::acos(std::min(1.0, glm::dot(glm::normalize(result.field().flux(v)), w))));
        });
        fmt::print("  flat water, absorption {}: relative L1 {:.4f}, worst {:.4f}, direction {:.2f} degrees\n",
                   absorption, error / sum, worst, angle * 180 / std::numbers::pi);
        EXPECT_LT(error / sum, 0.01);
        // At the corner where light comes in from two sides the edges of the driven patch diffract into the box.
        EXPECT_LT(worst, 0.16);
        EXPECT_LT(angle, 0.05);
        EXPECT_EQ(above, 0) << "the pulse is one-sided";
    }
}

/// Under a slanting sun the light keeps to Snell's law and Fresnel's, with few cells a wavelength and with more (of
/// longer waves the patch's edges bend some light: by 0.1 degrees of nine cells). One
/// factor for the three differences of the flux would turn it by 0.9 degrees at six cells, and a wave that runs as fast
/// as leapfrog makes it by 0.3.
TEST(Wave, ASlantingSunKeepsItsDirection) {
    for (const double zenith : {0.25 * std::numbers::pi, 1.1})
        for (const double points : {5.0, 6.0, 7.5}) {
            const double sine = std::sin(zenith);
            const glm::dvec3 d(sine * std::cos(3.5), sine * std::sin(3.5), -std::cos(zenith));
            const truth::PlaneWater water{800, -d.z, 1, 1.333, 0};
            const glm::dvec3 w(d.x / 1.333, d.y / 1.333, -water.cosBelow());
            Pool pool;
            pool.direction = fmt::format("[{:.17g}, {:.17g}, {:.17g}]", d.x, d.y, d.z);
            WaveOptions options;
            options.points = points;
            const Result result = bakeText(pool.toml(), options);
            glm::dvec3 flux(0);
            double energy = 0, expected = 0, angle = 0;
            int count = 0;
            forEachVoxel(result.field().frame(), [&](const glm::ivec3& v) {
                const glm::dvec3 p = result.field().frame().worldFromIndex(glm::dvec3(v));
                // Well inside of the driven patch, whose edges diffract.
                if (std::max(std::fabs(p.x), std::fabs(p.y)) > 0.3 || p.z > -0.1 || p.z < -0.5) return;
                flux += result.field().flux(v), energy += result.field().irradiance(v);
                expected += water.meanFluence(0, 0.03125), ++count;
                angle += std::acos(std::min(1.0, glm::dot(glm::normalize(result.field().flux(v)), w)));
            });
            const double off = std::acos(std::min(1.0, glm::dot(glm::normalize(flux), w))) * 180 / std::numbers::pi;
            fmt::print(
                "  zenith {:.0f} degrees, {} cells a wavelength: mean flux {:.3f} degrees off, voxels {:.3f}; energy "
                "{:.4f}\n",
                zenith * 180 / std::numbers::pi, points, off, angle / count * 180 / std::numbers::pi,
                energy / expected);
            EXPECT_LT(off, 0.1) << points;
            EXPECT_NEAR(energy / expected, 1, 0.003) << points;
        }
}

TEST(Wave, DoubledLightDoublesAndLightsAdd) {
    Pool pool;
    pool.flat = false;
    const Result one = bakeText(pool.toml());
    pool.irradiance = 1600;
    const Result two = bakeText(pool.toml());
    pool.irradiance = 800;
    pool.extra = "[[light]]\ntype = \"sun\"\ndirection = [0.3, -0.4, -0.8]\nirradiance = 800\nangular_diameter = 0\n";
    const Result both = bakeText(pool.toml());
    double worst = 0, brightest = 0;
    forEachVoxel(one.field().frame(), [&](const glm::ivec3& v) {
        const double a = 2 * one.field().irradiance(v);
        worst = std::max({worst, std::fabs(two.field().irradiance(v) - a), std::fabs(both.field().irradiance(v) - a)});
        brightest = std::max(brightest, a);
    });
    EXPECT_GT(brightest, 1600);
    EXPECT_LT(worst, 1e-5 * brightest);
}

TEST(Wave, FarFromTheOriginNothingChanges) {
    Pool pool;
    pool.flat = false;
    const Result here = bakeText(pool.toml());
    pool.shift = glm::dvec3(1 << 22, -(1 << 21), 1 << 20) * 0.03125;
    const Result there = bakeText(pool.toml());
    double difference = 0, sum = 0;
    const glm::ivec3 step(1 << 22, -(1 << 21), 1 << 20);
    forEachVoxel(here.field().frame(), [&](const glm::ivec3& v) {
        difference += std::fabs(there.field().irradiance(v + step) - here.field().irradiance(v)),
            sum += here.field().irradiance(v);
    });
    EXPECT_GT(sum, 0);
    EXPECT_LT(difference / sum, 1e-4);
}

TEST(Wave, ThreadsChangeNoBitAndFluxIsWithinIrradiance) {
    Pool pool;
    pool.flat = false;
    std::vector<Result> results;
    for (const int threads : {1, 2, 3}) {
        setThreadCount(threads);
        results.push_back(bakeText(pool.toml()));
    }
    setThreadCount(0);
    for (const LawCheck& check : checkLaws(results[0].field())) EXPECT_TRUE(check.holds) << check.name << check.value;
    const LightField& a = results[0].field();
    for (const Result& r : results)
        for (int slot = 0; slot < a.leafCount(); ++slot) {
            ASSERT_EQ(a.state(slot), r.field().state(slot));
            if (a.state(slot) != LeafState::Dense) continue;
            ASSERT_EQ(std::memcmp(a.dense(slot), r.field().dense(slot), sizeof(float) * 4 * 512), 0);
        }
}

TEST(Wave, BytesOfAVoxelAndOfTheBand) {
    Pool pool;
    pool.flat = false;
    const Result r = bakeText(pool.toml());
    // Two levels and four sums in the band (24 bytes a cell), no sums but memory in the layer around; the field's own
    // four.
    const double cell =
        static_cast<double>(r.run.counts.peak_bytes) / static_cast<double>(r.run.counts.peak_blocks * kWaveCells);
    EXPECT_GT(cell, 8);
    EXPECT_LT(cell, 24.5);
    EXPECT_NEAR(static_cast<double>(r.field().bytes()) / (32 * 32 * 32), 16, 1);
    EXPECT_LT(r.run.counts.block_steps, r.run.counts.blocks * r.run.counts.steps * 3 / 4);
}

std::string complaint(const std::string& toml, const WaveOptions& options) {
    try {
        bakeText(toml, options);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Input);
        return error.what();
    }
    return {};
}
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
bool warned(const Result& r, const std::string& part) {
    for (const std::string& w : r.warnings)
        if (has(w, part)) return true;
    return false;
}

TEST(Wave, WavelengthsThatTheGridCannotHoldAreRefusedOrWarnedOf) {
    Pool pool;
    WaveOptions options;
    options.wavelength = 2.9 * 0.03125;
    const std::string message = complaint(pool.toml(), options);
    EXPECT_TRUE(has(message, "is 2.9 cells")) << message;
    EXPECT_TRUE(has(message, "cells = 2")) << message;
    options.wavelength = 3.5 * 0.03125;
    EXPECT_TRUE(warned(bakeText(pool.toml(), options), "cells a wavelength: along the axes waves lag"));
    pool.flat = false;
    options.wavelength = 8 * 0.03125;
    const Result coarse = bakeText(pool.toml(), options);
    EXPECT_FALSE(warned(coarse, "waves lag"));
    EXPECT_TRUE(warned(coarse, "longer than the surface's details"));
    EXPECT_TRUE(warned(coarse, "caustics"));
}

TEST(Wave, TheSpongeReflectsAndTheMatchedLayerDoesNot) {
    const Ripples ripples{32};
    WaveOptions options;
    options.cells = 8, options.points = 12, options.threshold = 1e-3;
    const LightField pml = bakeText(ripples.toml(), options).bake.field;
    options.absorber = WaveAbsorber::Sponge, options.sponge_cells = 8;
    const LightField sponge = bakeText(ripples.toml(), options).bake.field;
    options.sponge_cells = 64;
    const LightField wide = bakeText(ripples.toml(), options).bake.field;
    const auto difference = [&](const LightField& a, const LightField& b) {
        double d = 0, s = 0;
        forEachVoxel(a.frame(), [&](const glm::ivec3& v) {
            d += std::fabs(a.irradiance(v) - b.irradiance(v)), s += b.irradiance(v);
        });
        return d / s;
    };
    EXPECT_LT(difference(wide, pml), 0.01);
    EXPECT_GT(difference(sponge, pml), 2 * difference(wide, pml));
}

/// [Mercier 2014, section 4] as a preset, and what its sum cannot show.
TEST(Wave, ThePapersSumShowsNoCaustics) {
    const Ripples ripples{64, 0, 8};
    WaveOptions options;
    options.preset = WavePreset::Mercier, options.threshold = 0.01;
    const Result paper = bakeText(ripples.toml(), options);
    EXPECT_TRUE(warned(paper, "harmonic"));
    options = {};
    const Result energy = bakeText(ripples.toml(), options);
    // Contrast along x, a metre below the surface.
    const auto contrast = [&](const LightField& field) {
        double low = 1e30, high = 0;
        const int k = static_cast<int>((-1.0 - Ripples::kBottom) * 64);
        for (int i = 0; i < 64; ++i) {
            const double e = field.irradiance(field.frame().min + glm::ivec3(i, 0, k));
            low = std::min(low, e), high = std::max(high, e);
        }
        return high / low;
    };
    // Started at rest, the sum is harmonic everywhere and vanishes: next to nothing of the 1 of a plane front is left.
    double most = 0;
    forEachVoxel(paper.field().frame(), [&](const glm::ivec3& v) {
        if (v.z < -8) most = std::max(most, paper.field().irradiance(v));
    });
    // Clamped at 0 it is not harmonic, and a cloud without caustics.
    options = {};
    options.preset = WavePreset::Mercier, options.clamp = true;
    const LightField clamped = bakeText(ripples.toml(), options).bake.field;
    fmt::print("  the paper's sum at most {:.3f}; contrast a metre down: clamped {:.3f}, energy {:.2f}\n", most,
               contrast(clamped), contrast(energy.field()));
    EXPECT_LT(most, 0.1);
    EXPECT_LT(contrast(clamped), 1.2);
    EXPECT_GT(contrast(energy.field()), 4);
    // a * phi^b
    options.exponent = 4, options.gain = 0.5;
    const LightField sharpened = bakeText(ripples.toml(), options).bake.field;
    EXPECT_NEAR(std::log(contrast(sharpened)) / std::log(contrast(clamped)), 4, 0.05);
    const glm::ivec3 voxel = clamped.frame().min + glm::ivec3(20, 3, 40);
    EXPECT_NEAR(sharpened.irradiance(voxel) / (0.5 * std::pow(clamped.irradiance(voxel), 4)), 1, 1e-3);
}

TEST(Wave, ItsAmplitudeIsHarmonicBelowTheSurface) {
    const Ripples ripples{64};
    WaveOptions options;
    options.accumulate = WaveAccumulate::Amplitude, options.points = 8, options.threshold = 1e-4;
    const LightField sum = bakeText(ripples.toml(), options).bake.field;
    double laplacian = 0, curvature = 0;
    for (int k = 4; k < 80; ++k)
        for (int i = 1; i < 63; ++i) {
            const auto at = [&](int x, int z) { return sum.irradiance(sum.frame().min + glm::ivec3(x, 0, z)); };
            const double xx = at(i - 1, k) - 2 * at(i, k) + at(i + 1, k),
                         zz = at(i, k - 1) - 2 * at(i, k) + at(i, k + 1);
            laplacian += std::fabs(xx + zz), curvature += std::fabs(at(i, k));
        }
    EXPECT_LT(laplacian / curvature, 2e-3);
}

}  // namespace
}  // namespace photic
