// SPDX-License-Identifier: Apache-2.0
// Beams as a user meets them, every setting left as it is, against closed forms and photons. The bounds say what is
// right; they aren't what some version happened to give.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/conformance/against_photons.h"

namespace photic {
namespace {

// --- The wave of bake_scene.h, whose voxel means are known.

struct DefaultErrors {
    std::vector<double> all, flux;
};
DefaultErrors errorsOfAWave(double extinction, const std::string& bake) {
    DefaultErrors errors;
    for (const int cells : {32, 64, 128}) {
        WaveScene scene;
        scene.cells = cells, scene.extinction = extinction;
        std::string toml = scene.toml();
        toml.replace(toml.find("quadrature"), std::string::npos, bake);  // the scene's last line
        const WaveErrors e = waveErrors(scene, bakeText(toml, "beams"), scene.truth());
        errors.all.push_back(e.irradiance_all), errors.flux.push_back(e.flux_all);
        fmt::print("  {:3} voxels a metre, extinction {}: irradiance {:.2e}, flux {:.2e}\n", cells, extinction,
                   e.irradiance_all, e.flux_all);
    }
    return errors;
}

TEST(DefaultSettings, AWaveIsWithinHalfAPercent) {
    for (const double extinction : {0.0, 1.2}) {
        const DefaultErrors e = errorsOfAWave(extinction, "");
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_LT(e.all[i], 0.005) << i;
            EXPECT_LT(e.flux[i], 0.005) << i;
        }
    }
}

TEST(DefaultSettings, AWaveConvergesWhereOneAsksForMore) {
    // The default tolerance is a part of a voxel, and one plane misplaces what slants through it: what is left of the
    // error where light is focused stays the same part of it at any resolution. It falls with both.
    const DefaultErrors plain = errorsOfAWave(0, ""), finer = errorsOfAWave(0, "quadrature = 4\ntolerance = 0.0625\n");
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(finer.all[i], 0.4 * plain.all[i]) << i;
}

// --- Against photons.

/// Rough enough for caustics within the box, seen from above and below.
struct Basin {
    std::string event = "refract", objects, bake, light = "direction = [0.3, 0.2, -0.9]", surface, medium;
    double low = -0.75, high = 0.0625, voxel = 0.03125, disc = 0;
    std::string toml() const {
        return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, {}]
max = [0.5, 0.5, {}]
voxel_size = {}
[[light]]
type = "sun"
{}
irradiance = 1.0
angular_diameter = {}
[[surface]]
name = "water"
event = "{}"
{}
{}{}[bake]
{}
)",
                           low, high, voxel, light, disc, event, surface.empty() ? waves() : surface, medium, objects,
                           bake);
    }
    static std::string waves(double steepness = 1) {
        return fmt::format(R"(size = [3.0, 3.0]
outside = "none"
waves = [
  {{ amplitude = {}, wavelength = 0.8, direction = 20, phase = 0.4 }},
  {{ amplitude = {}, wavelength = 0.5, direction = 95, phase = 1.7 }},
])",
                           0.02 * steepness, 0.015 * steepness);
    }
};

TEST(DefaultSettings, RefractedLightIsThePhotons) { expectAlike(Basin{}.toml()); }

TEST(DefaultSettings, ReflectedLightIsThePhotons) {
    Basin basin;
    basin.event = "reflect", basin.low = -0.0625, basin.high = 1, basin.light = "direction = [0.6, 0.3, -0.7]";
    expectAlike(basin.toml());
}

TEST(DefaultSettings, BothBranchesAreThePhotons) {
    Basin basin;
    basin.event = "both", basin.high = 0.75, basin.light = "direction = [0.6, 0.3, -0.7]";
    expectAlike(basin.toml());
}

TEST(DefaultSettings, BothBranchesOfSteepWaterAreThePhotons) {
    // Where the waves face away from a low sun, what they reflect would go into the water and is dropped: no other
    // light may make up for it.
    Basin basin;
    basin.event = "both", basin.high = -0.02, basin.voxel = 0.04;
    basin.light = "direction = [0.93, -0.08, -0.358]";
    basin.surface = R"(size = [2, 2]
outside = "periodic"
waves = [{ amplitude = 0.11, wavelength = 0.92, direction = 57, phase = 4.15 }])";
    expectAlike(basin.toml(), 0.01, 0.002);
}

TEST(DefaultSettings, BothBranchesOfASeaCloseTheLedger) {
    // Hundreds of metres of water.
    const Baked baked = bakeText(R"(photic = 1
[domain]
resolution = 16
[[light]]
type = "sun"
direction = [0, 0, -1]
[[surface]]
event = "both"
size = [600, 600]
waves = [{ amplitude = 0.3, wavelength = 300, direction = 60 }, { amplitude = 0.1, wavelength = 200, direction = [0, 1], phase = 1 }]
)",
                                 "beams");
    EXPECT_LT(baked.result.report.power.imbalance(), 1e-6);
    EXPECT_LT(baked.result.report.path.imbalance(), 1e-6);
}

TEST(DefaultSettings, ADiscBlursAsPhotonsDo) {
    Basin basin;
    basin.disc = 0.53;
    expectAlike(basin.toml());
}

// --- Meshes as water.

/// The basin's waves as a mesh of n^2 squares over [-half, half]^2; removed at the end.
class WaterMesh {
public:
    WaterMesh(int n, double half, double steepness = 1)
        : path_(fmt::format("{}photic_water_{}_{}_{}.obj", ::testing::TempDir(), ::getpid(), n, steepness)) {
        std::ofstream out(path_);
        const auto height = [steepness](double x, double y) {
            const auto wave = [&](double a, double l, double degrees, double phase) {
                const double k = 2 * M_PI / l, d = degrees * M_PI / 180;
                return a * std::sin(k * (x * std::cos(d) + y * std::sin(d)) + phase);
            };
            return steepness * (wave(0.02, 0.8, 20, 0.4) + wave(0.015, 0.5, 95, 1.7));
        };
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                const double x = half * (2.0 * i / n - 1), y = half * (2.0 * j / n - 1);
                out << fmt::format("v {:.9f} {:.9f} {:.9f}\n", x, y, height(x, y));
            }
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const int a = j * (n + 1) + i + 1, b = a + 1, c = b + n + 1, d = a + n + 1;
                out << fmt::format("f {} {} {}\nf {} {} {}\n", a, b, c, a, c, d);
            }
    }
    ~WaterMesh() { std::filesystem::remove(path_); }
    WaterMesh(const WaterMesh&) = delete;
    WaterMesh& operator=(const WaterMesh&) = delete;
    std::string toml() const { return fmt::format("kind = \"mesh\"\nfile = \"{}\"", path_); }

private:
    std::string path_;
};

TEST(DefaultSettings, AMeshOfWaterIsThePhotons) {
    const WaterMesh mesh(60, 1.0);
    Basin basin;
    basin.surface = mesh.toml();
    expectAlike(basin.toml());
}

TEST(DefaultSettings, AMeshOfWaterIsTheHeightField) {
    const WaterMesh mesh(300, 1.5);
    Basin field, triangles;
    triangles.surface = mesh.toml();
    const Baked a = bakeText(field.toml(), "beams"), b = bakeText(triangles.toml(), "beams");
    EXPECT_NEAR(total(b.field()) / total(a.field()), 1, 2e-3);
    EXPECT_LT(blockDifference(b.field(), a.field(), 2), 0.01);
}

// A mesh's triangles stand in each other's light, and the height field's crests in theirs: two ways to the same light.
TEST(DefaultSettings, CrestsShadeTheWaterBehindThem) {
    constexpr double kSteepness = 2.5;
    const WaterMesh mesh(400, 1.5, kSteepness);
    Basin field, triangles;
    field.surface = Basin::waves(kSteepness), triangles.surface = mesh.toml();
    field.low = triangles.low = -0.5, field.high = triangles.high = -0.1;
    field.light = triangles.light = "direction = [0.93, 0.1, -0.35]";
    const Baked a = bakeText(field.toml(), "beams"), b = bakeText(triangles.toml(), "beams");
    EXPECT_NEAR(total(b.field()) / total(a.field()), 1, 3e-3);
    EXPECT_LT(blockDifference(b.field(), a.field(), 2), 0.01);
    expectAlike(field.toml(), 0.015);
}

TEST(DefaultSettings, AMeshAsAMirrorIsThePhotons) {
    const WaterMesh mesh(60, 0.6);
    Basin basin;
    basin.surface = mesh.toml(), basin.event = "reflect", basin.low = -0.0625, basin.high = 1;
    expectAlike(basin.toml());
}

TEST(DefaultSettings, AMeshWithBothBranchesIsThePhotons) {
    const WaterMesh mesh(60, 0.6);
    Basin basin;
    basin.surface = mesh.toml(), basin.event = "both", basin.high = 0.5;
    expectAlike(basin.toml());
}

// --- Shadows.

TEST(DefaultSettings, AMeshShadowIsThePhotons) {
    Basin basin;
    basin.objects = R"([[object]]
name = "ball"
sphere = { center = [0.05, -0.1, -0.35], radius = 0.15 }
[[object]]
name = "post"
role = "blocker"
box = { min = [-0.35, 0.2, -0.75], max = [-0.27, 0.28, -0.1] }
)";
    // Along the shadows' edges light is spread over the smallest tubes.
    expectAlike(basin.toml(), 0.015, 0.005);
}

TEST(DefaultSettings, AShadowOnTheWaterIsThePhotons) {
    Basin basin;
    basin.objects = R"([[object]]
name = "roof"
role = "blocker"
box = { min = [-0.3, -0.2, 0.3], max = [0.1, 0.25, 0.35] }
)";
    expectAlike(basin.toml(), 0.015, 0.005);
}

TEST(DefaultSettings, APlaneShadowIsThePhotons) {
    Basin basin;
    basin.objects = R"([[object]]
name = "slope"
plane = { point = [0, 0, -0.5], normal = [-0.5, 0, 1] }
[[object]]
name = "wall"
plane = { point = [0.3, 0, 0], normal = [-1, 0, 0] }
)";
    expectAlike(basin.toml(), 0.015, 0.005);
}

// --- A low sun.

std::string lowSun(const std::string& bake) {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.8, -0.8, -1.1]
max = [0.8, 0.8, 0.1]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0.7399421116938484, -0.6208851530148456, -0.2588190451025208]
irradiance = 1000.0
angular_diameter = 0.0
[[surface]]
name = "water"
size = [6.0, 6.0]
outside = "none"
waves = [
  {{ amplitude = 0.012, wavelength = 0.9, direction = 65.0, phase = 1.1 }},
  {{ amplitude = 0.006, wavelength = 0.55, direction = -25.0, phase = 0.3 }},
  {{ amplitude = 0.003, wavelength = 0.33, direction = 140.0, phase = 2.2 }},
]
[[object]]
name = "floor"
plane = {{ point = [0, 0, -1] }}
[bake]
{}
)",
                       bake);
}

TEST(DefaultSettings, ALowSunIsWithinOnePercent) {
    // Voxel by voxel against four planes a layer and a fine mesh.
    const Baked plain = bakeText(lowSun(""), "beams"),
                fine = bakeText(lowSun("quadrature = 4\n"), "beams", option("spacing", 0.25));
    const double error = blockDifference(plain.field(), fine.field(), 1);
    fmt::print("  relative L1 of voxels {:.4f}\n", error);
    EXPECT_LT(error, 0.01);
}

TEST(DefaultSettings, ALowSunIsThePhotons) { expectAlike(lowSun("")); }

// Behind a plane light goes on for two layers, and there too it ends on what stands in its way, however wide the tubes
// of level water are: it shone through a box that nearly reaches up to the plane (a seventh of all light in these
// voxels).
TEST(DefaultSettings, WhatStandsRightBehindAPlaneEndsLight) {
    expectAlike(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.42]
max = [0.5, 0.5, 0.38]
voxel_size = 0.125
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1
[[surface]]
name = "water"
size = [2.7, 2.7]
flat = true
[[object]]
name = "box"
box = { min = [0.139, -0.189, -0.664], max = [0.705, 0.284, -0.1596] }
[[object]]
name = "floor"
plane = { point = [0, 0, -0.1556] }
)",
                0.02, 0.003);
}

// The outermost tubes' corners lie on the box's sides to a hair. A third of those tubes' light was said to leave the
// box before it came to the floor: 4 % with eight voxels a side.
TEST(DefaultSettings, WhatLandsAtTheBoxsSidesIsReceived) {
    const std::string toml = R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.8]
max = [0.5, 0.5, 0.1]
voxel_size = 0.125
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1
angular_diameter = 0
[[surface]]
name = "water"
size = [2, 2]
waves = [{ amplitude = 6.5e-6, wavelength = 0.34, direction = 199 }]
[[object]]
name = "floor"
plane = { point = [0, 0, -0.278] }
)";
    const PowerLedger beams = bakeText(toml, "beams").result.report.power,
                      photons = bakeText(toml, "photons").result.report.power;
    EXPECT_NEAR(beams.received / photons.received, 1, 2e-3);
    EXPECT_LT(beams.escaped / beams.emitted, 1e-3);
}

// --- The paper's preset.

TEST(DefaultSettings, TheErnstPresetRunsWithinItsErrorInEnergy) {
    const Baked paper = bakeText(Basin{}.toml(), "beams", option("interpolation", std::string("ernst"))),
                exact = bakeText(Basin{}.toml(), "beams");
    EXPECT_LT(paper.result.report.power.imbalance(), 1e-6);
    const double error = paper.result.report.path.imbalance();
    fmt::print("  energy off by {:.4f}, blocks by {:.4f}\n", error, blockDifference(paper.field(), exact.field(), 4));
    EXPECT_LT(error, 0.1);
    // The ledger tells the error that there is.
    EXPECT_NEAR(std::fabs(total(paper.field()) / total(exact.field()) - 1), error, 0.01);
    EXPECT_LT(blockDifference(paper.field(), exact.field(), 4), 0.15);
}

}  // namespace
}  // namespace photic
