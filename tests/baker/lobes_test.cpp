// SPDX-License-Identifier: Apache-2.0
// Light that opposes itself, from two suns or off a mirror, against closed forms: what a wall and a ceiling get.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/baker/bake_scene.h"
#include "bake/field/lobes.h"
#include "bake/methods/lobe_axis.h"
#include "bake/picture/volume_lookup.h"
#include "tests/baker/pool_scene.h"
#include "tests/support/tube_scenes.h"

namespace photic {
namespace {

using test::Record;

constexpr double kEast = 600, kWest = 300, kCosine = 0.6, kIor = 1.333;

Scene sceneOf(const std::string& text) {
    Monitor monitor;
    return parseScene("photic = 1\n[domain]\nmin = [-1, -1, -2]\nmax = [1, 1, 0.1]\nvoxel_size = 0.05\n" + text,
                      "lobes.toml", ".", 0, monitor);
}

constexpr const char* kCalm = R"(
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
flat = true
)";

/// Suns of 53 degrees from the east and from the west, which carry kEast and kWest.
Scene opposedSuns(const std::string& surface = kCalm, const std::string& more = {}) {
    const auto sun = [](const char* name, double x, double irradiance) {
        return fmt::format("[[light]]\ntype = \"sun\"\nname = \"{}\"\ndirection = [{}, 0, {}]\nirradiance = {}\n", name,
                           x, -kCosine, irradiance);
    };
    return sceneOf(sun("east", -0.8, kEast) + sun("west", 0.8, kWest) + surface + more);
}

/// Fresnel's share that enters calm water, unpolarised.
double entering(double cosine) {
    const double sine_in = std::sqrt(1 - cosine * cosine) / kIor, inside = std::sqrt(1 - sine_in * sine_in);
    const double s = (cosine - kIor * inside) / (cosine + kIor * inside),
                 p = (kIor * cosine - inside) / (kIor * cosine + inside);
    return 1 - 0.5 * (s * s + p * p);
}

/// What a wall gets below calm water that faces a sun of unit irradiance.
double onAWall() {
    const double sine = 0.8 / kIor, cosine = std::sqrt(1 - sine * sine);
    return entering(kCosine) * kCosine * sine / cosine;
}

/// Mean over the middle of the water of what faces with this normal get.
double received(const LightVolume& volume, const glm::dvec3& normal) {
    const VolumeLookup lookup(volume);
    double sum = 0;
    int n = 0;
    for (double x = -0.4; x <= 0.4; x += 0.087)
        for (double y = -0.4; y <= 0.4; y += 0.087)
            for (double z = -1.2; z <= -0.5; z += 0.093, ++n) sum += lookup.receiverIrradiance({x, y, z}, normal).x;
    return sum / n;
}

TEST(Lobes, OpposedSunsLightEachItsWall) {
    Record record;
    const BakedScene baked = bakeScene(opposedSuns(), record);
    ASSERT_TRUE(baked.volume.second.has_value());
    EXPECT_EQ(baked.volume.metadata.at("lobe_axis"), "[-1,0,0]");  // most light comes from the east
    EXPECT_NEAR(received(baked.volume, {1, 0, 0}) / (kEast * onAWall()), 1, 1e-3);
    EXPECT_NEAR(received(baked.volume, {-1, 0, 0}) / (kWest * onAWall()), 1, 1e-3);
    EXPECT_NEAR(received(baked.volume, {0, 0, 1}) / ((kEast + kWest) * entering(kCosine) * kCosine), 1, 1e-3);
    EXPECT_LT(baked.report.path.imbalance(), 1e-6);
    for (const std::string& warning : record.warnings)
        EXPECT_EQ(warning.find("far apart"), std::string::npos) << warning;
}

// Each lobe is filtered by itself. Where a roof keeps one sun out, leaves of the second lobe end beside leaves whose
// light the first has alone: looked up together nothing of that may show.
TEST(Lobes, ThePrefilterLeavesTheirSumAlone) {
    const std::string roof = "[[object]]\nname = \"roof\"\nbox = { min = [-4, -4, 0.5], max = [-0.5, 4, 0.6] }\n";
    Scene scene = opposedSuns(kCalm, roof);
    Record record;
    const BakedScene plain = bakeScene(scene, record);
    scene.bake.prefilter = true;
    const BakedScene filtered = bakeScene(scene, record);
    ASSERT_TRUE(plain.volume.second.has_value() && filtered.volume.second.has_value());
    const auto all = [](const LightVolume& volume) { return volume.field.sum(0) + volume.second->sum(0); };
    EXPECT_NEAR(all(filtered.volume) / all(plain.volume), 1, 1e-5);
    const VolumeLookup before(plain.volume), after(filtered.volume);
    int looked_at = 0;
    for (double x = -0.8; x <= 0.8; x += 0.043)
        for (double z = -1.7; z <= -0.2; z += 0.11)
            for (const glm::dvec3 normal : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0)}) {
                // Away from the roof's shadows, which it does sharpen.
                const auto at = [&](double shift) { return before.receiverIrradiance({x + shift, 0.01, z}, normal).x; };
                if (std::fabs(at(0.2) - at(-0.2)) > 1e-3 * kEast || std::fabs(at(0.1) - at(-0.1)) > 1e-3 * kEast)
                    continue;
                EXPECT_NEAR(after.receiverIrradiance({x, 0.01, z}, normal).x, at(0), 2e-3 * kEast) << x << " " << z;
                ++looked_at;
            }
    EXPECT_GT(looked_at, 300);
}

TEST(Lobes, PhotonsAndWavesPartThemToo) {
    Scene scene = opposedSuns();
    for (const char* method : {"photons", "wave"}) {
        scene.bake.method = method;
        Record record;
        const BakedScene baked = bakeScene(scene, record);
        ASSERT_TRUE(baked.volume.second.has_value()) << method;
        const double allowed = method == std::string("wave") ? 0.02 : 0.005;
        EXPECT_NEAR(received(baked.volume, {1, 0, 0}) / (kEast * onAWall()), 1, allowed) << method;
        EXPECT_NEAR(received(baked.volume, {-1, 0, 0}) / (kWest * onAWall()), 1, allowed) << method;
    }
}

TEST(Lobes, OneLobeLosesLightAndSaysSo) {
    Record record;
    const BakedScene baked = bakeScene(opposedSuns(kCalm, "[bake]\nlobes = 1\n"), record);
    EXPECT_FALSE(baked.volume.second.has_value());
    EXPECT_EQ(baked.volume.metadata.count("lobe_axis"), 0u);
    EXPECT_NEAR(received(baked.volume, {-1, 0, 0}), 0, 1e-3 * kWest);
    EXPECT_NE(std::find_if(record.warnings.begin(), record.warnings.end(),
                           [](const std::string& w) {
                               return w.find("lobes = 2") != std::string::npos ||
                                      w.find("a volume of its own") != std::string::npos;
                           }),
              record.warnings.end());
}

TEST(Lobes, OfASunAloneThereIsOne) {
    Record record;
    EXPECT_FALSE(bakeScene(test::poolScene(), record).volume.second.has_value());
    // Two suns side by side differ by few degrees.
    const Scene near = sceneOf(
        "[[light]]\ntype = \"sun\"\nname = \"a\"\ndirection = [0.05, 0, -1]\nirradiance = 500.0\n"
        "[[light]]\ntype = \"sun\"\nname = \"b\"\ndirection = [-0.05, 0, -1]\nirradiance = 500.0\n" +
        std::string(kCalm));
    EXPECT_FALSE(bakeScene(near, record).volume.second.has_value());
}

TEST(Lobes, AnAxisThatIsGivenIsKept) {
    Record record;
    const BakedScene baked = bakeScene(opposedSuns(kCalm, "[bake]\nlobe_axis = [-2, 0.2, 0]\n"), record);
    ASSERT_TRUE(baked.volume.second.has_value());
    EXPECT_EQ(baked.volume.metadata.at("lobe_axis").substr(0, 6), "[-0.99");
    EXPECT_NEAR(received(baked.volume, {-1, 0, 0}) / (kWest * onAWall()), 1, 1e-3);
    EXPECT_THROW(opposedSuns(kCalm, "[bake]\nlobe_axis = [0, 0, 0]\n"), Error);
    EXPECT_THROW(opposedSuns(kCalm, "[bake]\nlobes = 3\n"), Error);
}

TEST(Lobes, AMirrorLightsWhatFacesDown) {
    // Calm water over a level mirror: what goes down comes up again, and leaves or is lost at the surface.
    Scene scene = sceneOf(std::string(R"([[light]]
type = "sun"
name = "noon"
direction = [0, 0, -1]
irradiance = 1000.0
angular_diameter = 0
)") + kCalm);
    Surface mirror;
    mirror.name = "mirror", mirror.event = SurfaceEvent::Mirror, mirror.closed = true, mirror.smooth = false;
    mirror.mesh = std::make_shared<const TriangleMesh>(support::boxMesh({-3, -3, -1.85}, {3, 3, -1.7}));
    mirror.colour = glm::dvec3(0.5), mirror.ior_above = kIor, mirror.ior_below = kIor;
    scene.surfaces.push_back(mirror);
    Record record;
    const BakedScene baked = bakeScene(scene, record);
    ASSERT_TRUE(baked.volume.second.has_value());
    const double down = 1000 * entering(1);
    EXPECT_NEAR(received(baked.volume, {0, 0, 1}) / down, 1, 2e-3);
    EXPECT_NEAR(received(baked.volume, {0, 0, -1}) / (0.5 * down), 1, 2e-3);
    for (const std::string& warning : record.warnings)
        EXPECT_EQ(warning.find("far apart"), std::string::npos) << warning;
}

TEST(Lobes, JoinedAgainTheyAreAllLight) {
    Scene scene = opposedSuns(R"(
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
waves = [{ amplitude = 0.01, wavelength = 0.5, direction = 20 }]
)");
    Record record;
    const BakedScene two = bakeScene(scene, record);
    scene.bake.lobes = 1;
    const BakedScene one = bakeScene(scene, record);
    ASSERT_TRUE(two.volume.second.has_value());
    double apart = 0, sum = 0;
    const GridFrame& frame = one.volume.field.frame();
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                const double both = two.volume.field.irradiance({x, y, z}) + two.volume.second->irradiance({x, y, z});
                apart += std::fabs(both - one.volume.field.irradiance({x, y, z}));
                sum += one.volume.field.irradiance({x, y, z});
            }
    EXPECT_LT(apart, 1e-6 * sum);
}

TEST(KeepOpposedLight, KeepsLeavesThatOpposeAndThoseBesideThem) {
    const GridFrame frame(glm::dmat3(1), glm::dvec3(0), glm::ivec3(0), glm::ivec3(8 * 6 - 1, 7, 7));
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
    LobeFields lobes = emptyLobes(needed, {1, true}, true);
    // The first lobe in leaves 0 to 3, the second in 3 to 5: both in the fourth.
    const auto lit = [](LightField& field, int slot, float along) {
        float* leaf = field.makeDense(slot);
        std::fill_n(leaf, 512, 1.0f), std::fill_n(leaf + 512, 512, along);
    };
    for (int slot = 0; slot <= 3; ++slot) lit(lobes.first, slot, 1.0f);
    for (int slot = 3; slot <= 5; ++slot) lit(*lobes.second, slot, -1.0f);
    keepOpposedLight(lobes, 1e-3);
    ASSERT_TRUE(lobes.second.has_value());
    EXPECT_EQ(lobes.second->state(3), LeafState::Dense);
    EXPECT_EQ(lobes.second->state(4), LeafState::Dense);  // beside it: look-ups between them find both lobes
    EXPECT_EQ(lobes.second->state(5), LeafState::Empty);
    EXPECT_EQ(lobes.first.state(4), LeafState::Empty);
    EXPECT_EQ(lobes.first.flux({44, 0, 0}), glm::dvec3(-1, 0, 0));
    // Where nothing opposes there is no second lobe.
    lobes.second->setEmpty(3);
    keepOpposedLight(lobes, 1e-3);
    EXPECT_FALSE(lobes.second.has_value());
    EXPECT_EQ(lobes.first.flux({36, 0, 0}), glm::dvec3(-1, 0, 0));
}

}  // namespace
}  // namespace photic
