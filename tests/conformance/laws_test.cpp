// SPDX-License-Identifier: Apache-2.0
// Laws that hold for every method whatever the scene: ledgers, linearity, motion, threads, conservation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/field/grid_laws.h"
#include "bake/threads/parallel_for.h"
#include "tests/conformance/bake_scene.h"
#include "tests/support/closed_forms.h"

namespace photic {
namespace {

/// Waves over a box, or a ball without faces in it for a method that bakes media whose index varies; turned by a
/// multiple of 90 degrees about z and moved.
struct Pool {
    int quarter_turns = 0;
    glm::dvec3 shift{0};
    double irradiance = 1;
    double absorption = 0;
    std::string shear = "none";
    std::string extra;
    bool ball = false;

    glm::dvec3 turned(glm::dvec3 p) const {
        for (int i = 0; i < quarter_turns; ++i) p = {-p.y, p.x, p.z};
        return p;
    }
    std::string toml() const {
        const glm::dvec3 a = turned({-0.5, -0.5, -0.75}) + shift, b = turned({0.5, 0.5, 0.0625}) + shift;
        const glm::dvec3 low = glm::min(a, b), high = glm::max(a, b), d = turned({0.3, 0.2, -0.9});
        const double turn = 90.0 * quarter_turns;
        if (ball) return ballToml(low, high, d);
        return fmt::format(R"(photic = 1
[domain]
min = [{}, {}, {}]
max = [{}, {}, {}]
voxel_size = 0.03125
shear = "{}"
[[light]]
type = "sun"
direction = [{}, {}, {}]
irradiance = {}
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [3.0, 3.0]
center = [{}, {}, {}]
outside = "none"
waves = [
  {{ amplitude = 0.02, wavelength = 0.8, direction = {}, phase = 0.4 }},
  {{ amplitude = 0.015, wavelength = 0.5, direction = {}, phase = 1.7 }},
]
[medium]
absorption = {}
{}
)",
                           low.x, low.y, low.z, high.x, high.y, high.z, shear, d.x, d.y, d.z, irradiance, shift.x,
                           shift.y, shift.z, 20 + turn, 95 + turn, absorption, extra);
    }

    std::string ballToml(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& d) const {
        const glm::dvec3 center = turned({0.1, -0.05, -0.3}) + shift;
        return fmt::format(R"(photic = 1
[domain]
min = [{}, {}, {}]
max = [{}, {}, {}]
voxel_size = 0.03125
[[light]]
type = "sun"
direction = [{}, {}, {}]
irradiance = {}
angular_diameter = 0
[[medium]]
name = "ball"
index = {{ kind = "fish_eye", center = [{}, {}, {}], n0 = 1.3, scale = 0.54772256, radius = 0.3 }}
absorption = {}
)",
                           low.x, low.y, low.z, high.x, high.y, high.z, d.x, d.y, d.z, irradiance, center.x, center.y,
                           center.z, absorption);
    }
};

class Laws : public ::testing::TestWithParam<std::string> {
protected:
    Baked bake(Pool pool, const GivenOptions& options = {}) const {
        pool.ball = GetParam() == "wavefront";
        return bakeText(pool.toml(), GetParam(),
                        (noisy() ? option("count", std::int64_t{400'000}) : GivenOptions{}) | options);
    }
    bool noisy() const { return GetParam() == "photons"; }
    /// A fixed mesh, so that one scene in two guises is cut into the same triangles.
    GivenOptions uniform() const {
        if (noisy()) return option("count", std::int64_t{400'000});
        return GetParam() == "beams" ? option("mesh", std::int64_t{160}) : GivenOptions{};
    }
};

/// Of methods that follow all the light to its end.
class ConservationLaws : public Laws {};

template <class Body>
void forEachVoxel(const GridFrame& f, Body body) {
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) body(glm::ivec3(i, j, k));
}

TEST_P(ConservationLaws, BothLedgersClose) {
    for (const double absorption : {0.0, 0.8}) {
        Pool pool;
        pool.absorption = absorption;
        const Baked baked = bake(pool);
        EXPECT_LT(baked.result.report.power.imbalance(), 1e-6);
        EXPECT_LT(baked.result.report.path.imbalance(), 1e-6);
        // The ledger's own figure is that of the field.
        const double deposited = baked.field().sum(0) * baked.field().frame().voxelVolume();
        EXPECT_NEAR(baked.result.report.path.deposited / deposited, 1, 1e-6);
        EXPECT_GT(baked.result.report.power.emitted, 0);
        EXPECT_EQ(baked.result.report.power.absorbed_medium > 0, absorption > 0);
    }
}

TEST_P(Laws, DoubledLightDoublesIrradianceTimesReference) {
    const Baked one = bake({});
    const Baked two = bake({.irradiance = 2});
    EXPECT_DOUBLE_EQ(two.result.report.reference_irradiance, 2 * one.result.report.reference_irradiance);
    double worst = 0, brightest = 0;
    forEachVoxel(one.field().frame(), [&](const glm::ivec3& v) {
        worst = std::max(worst, std::fabs(two.field().irradiance(v) - 2 * one.field().irradiance(v)));
        brightest = std::max(brightest, two.field().irradiance(v));
    });
    EXPECT_GT(brightest, 1);
    EXPECT_LT(worst, 1e-6 * brightest);
}

TEST_P(Laws, TranslationMovesTheField) {
    const glm::ivec3 step(7, -11, 5);
    const Baked here = bake({}, uniform());
    const Baked there = bake({.shift = glm::dvec3(step) * 0.03125}, uniform());
    ASSERT_EQ(there.field().frame().min, here.field().frame().min + step);
    double difference = 0, sum = 0;
    forEachVoxel(here.field().frame(), [&](const glm::ivec3& v) {
        difference += std::fabs(there.field().irradiance(v + step) - here.field().irradiance(v)),
            sum += here.field().irradiance(v);
    });
    EXPECT_GT(sum, 0);
    // The same triangles, up to rounding; photons keep their points on the patch.
    // Which samples lie in a ball, and which rays meet it, is decided by comparisons, which rounding tips at its rim.
    EXPECT_LT(difference / sum, GetParam() == "wavefront" ? 2e-3 : 1e-5);
}

TEST_P(Laws, RotationTurnsTheField) {
    const Baked here = bake({}, uniform());
    for (const int turns : {1, 2}) {
        Pool pool;
        pool.quarter_turns = turns;
        const Baked turned = bake(pool, uniform());
        double difference = 0, sum = 0, flux = 0;
        forEachVoxel(here.field().frame(), [&](const glm::ivec3& v) {
            glm::ivec3 to = v;
            for (int i = 0; i < turns; ++i) to = {-to.y - 1, to.x, to.z};
            difference += std::fabs(turned.field().irradiance(to) - here.field().irradiance(v)),
                sum += here.field().irradiance(v);
            flux += glm::length(turned.field().flux(to) - pool.turned(here.field().flux(v)));
        });
        // Squares are cut along the other diagonal by a quarter turn: within the error of the mesh. Photons: within
        // their noise.
        const double coarse = GetParam() == "wavefront" && turns == 1 ? 0.05 : 0.01;  // a ball of ten voxels' radius
        const double tolerance = noisy() ? 0.2 : coarse;
        EXPECT_LT(difference / sum, tolerance) << turns;
        EXPECT_LT(flux / sum, tolerance) << turns;
    }
}

TEST_P(Laws, ThreadCountChangesNoBit) {
    std::vector<Baked> bakes;
    for (const int threads : {1, 2, 3}) {
        setThreadCount(threads);
        bakes.push_back(bake({.absorption = 0.3}));
    }
    setThreadCount(0);
    const LightField& a = bakes[0].field();
    for (std::size_t b = 1; b < bakes.size(); ++b) {
        const LightField& other = bakes[b].field();
        ASSERT_EQ(a.leafCount(), other.leafCount());
        for (int slot = 0; slot < a.leafCount(); ++slot) {
            ASSERT_EQ(a.state(slot), other.state(slot));
            if (a.state(slot) == LeafState::Dense) {
                ASSERT_EQ(std::memcmp(a.dense(slot), other.dense(slot),
                                      sizeof(float) * 512 * static_cast<std::size_t>(a.channels().count())),
                          0);
            }
        }
        EXPECT_EQ(bakes[0].result.report.power.escaped, bakes[b].result.report.power.escaped);
        EXPECT_EQ(bakes[0].result.report.path.expected, bakes[b].result.report.path.expected);
    }
}

TEST_P(Laws, FluxIsNeverLongerThanIrradiance) {
    const Baked baked = bake({});
    for (const LawCheck& check : checkLaws(baked.field())) EXPECT_TRUE(check.holds) << check.name << " " << check.value;
    bool fails = false;
    LightField broken(baked.field().neededPtr(), baked.field().channels());
    std::vector<float> values{1, 0, 0, -1.1f};
    broken.setConstant(0, values);
    for (const LawCheck& check : checkLaws(broken)) fails = fails || !check.holds;
    EXPECT_TRUE(fails) << "the checker accepts anything";
}

/// A small bright patch whose light stays inside an aligned and a leaning grid.
std::string containedLight(const char* shear) {
    return fmt::format(R"(photic = 1
[domain]
min = [-1.0, -1.0, -0.75]
max = [1.0, 1.0, -0.0625]
voxel_size = 0.03125
shear = "{}"
[[light]]
type = "sun"
direction = [0.3, 0.2, -0.9]
angular_diameter = 0
irradiance = 1.0
[[surface]]
name = "water"
kind = "height_field"
size = [0.5, 0.5]
outside = "none"
waves = [{{ amplitude = 0.02, wavelength = 0.4, direction = 30, phase = 0.4 }}]
)",
                       shear);
}

TEST_P(ConservationLaws, PlaneFluxOfContainedLightIsConstant) {
    const std::vector<double> power = layerPower(bakeText(containedLight("none"), GetParam(), uniform()).field());
    EXPECT_GT(power[0], 0.1 * 0.5 * 0.5);
    for (std::size_t k = 0; k < power.size(); ++k) EXPECT_NEAR(power[k] / power[0], 1, noisy() ? 1e-4 : 1e-5) << k;
}

TEST_P(ConservationLaws, PlaneFluxOfPeriodicLightIsConstant) {
    WaveScene scene;
    // The box ends under crests, on the caustic: tubes a quarter of a voxel off would move some of it across the
    // border.
    const Baked baked =
        bakeText(scene.toml(), GetParam(),
                 noisy() ? option("count", std::int64_t{1'000'000}) : option("mesh", std::int64_t{512}));
    const std::vector<double> power = layerPower(baked.field());
    double expected = 0;
    const int steps = 4096;
    const double k = 2 * std::numbers::pi / WaveScene::kWavelength;
    for (int i = 0; i < steps; ++i) {
        const double slope = k * WaveScene::kAmplitude * std::sin(2 * std::numbers::pi * (i + 0.5) / steps);
        expected += truth::fresnelTransmittance(1 / std::hypot(1, slope), 1, WaveScene::kIor) / steps;
    }
    expected *= 8 * scene.voxel();  // W through 1 m x 8 voxels
    // The tubes do not repeat with the waves, so that what leaves on one side comes in on the other within the mesh's
    // error only.
    const auto wet = static_cast<std::size_t>((-WaveScene::kAmplitude - WaveScene::kBottom) * scene.cells);
    for (std::size_t layer = 0; layer < wet; ++layer) EXPECT_NEAR(power[layer] / expected, 1, 2e-3) << layer;
}

TEST_P(ConservationLaws, LittleFluxEndsInABox) {
    const Baked baked = bake({});
    const GridFrame& f = baked.field().frame();
    double worst = 0;
    for (int size : {6, 12}) {
        for (int start = 2; start + size < 20; start += 5) {
            const glm::ivec3 low = f.min + glm::ivec3(start, start + 1, 2);
            worst = std::max(worst, std::fabs(netFluxThroughBox(baked.field(), low, low + size)));
        }
    }
    EXPECT_LT(worst, noisy() ? 0.05 : 0.02);
    // Absorbing water does swallow flux.
    const Baked dark = bake({.absorption = 2});
    EXPECT_LT(netFluxThroughBox(dark.field(), f.min + 3, f.min + 15), -0.1);
}

TEST_P(ConservationLaws, ShearedAndAlignedGridsHoldTheSameLight) {
    const Baked aligned = bakeText(containedLight("none"), GetParam(), uniform()),
                sheared = bakeText(containedLight("light"), GetParam(), uniform());
    EXPECT_FALSE(sheared.field().frame().axisAligned());
    const auto total = [](const Baked& b) { return b.field().sum(0) * b.field().frame().voxelVolume(); };
    EXPECT_NEAR(total(sheared) / total(aligned), 1, noisy() ? 1e-3 : 1e-5);
    const auto a = layerPower(aligned.field()), s = layerPower(sheared.field());
    ASSERT_EQ(a.size(), s.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(s[k] / a[k], 1, noisy() ? 5e-3 : 1e-5) << k;
}

INSTANTIATE_TEST_SUITE_P(Methods, ConservationLaws, ::testing::Values("beams", "photons"),
                         [](const auto& row) { return row.param; });
INSTANTIATE_TEST_SUITE_P(Methods, Laws, ::testing::ValuesIn([] {
                             std::vector<std::string> names = methodNames();
                             names.emplace_back("wavefront");
                             return names;
                         }()),
                         [](const auto& row) { return row.param; });

}  // namespace
}  // namespace photic
