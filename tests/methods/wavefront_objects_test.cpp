// SPDX-License-Identifier: Apache-2.0
// Receivers and blockers among media whose index varies.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "bake/methods/wavefront.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

const std::string kBox = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32",
                  kSlant = "type = \"sun\"\ndirection = [0.3, 0.2, -0.93]\nirradiance = 1\nangular_diameter = 0",
                  kEven = medium("{ kind = \"linear\", n0 = 1.3, slope = [0, 0, 0] }"),
                  kLuneburg = medium("{ kind = \"luneburg\", radius = 0.4 }");

std::string plane(const std::string& point, const std::string& normal, const std::string& role = "receiver",
                  const std::string& name = "plane") {
    return fmt::format("[[object]]\nname = \"{}\"\nrole = \"{}\"\nplane = {{ point = {}, normal = {} }}\n", name, role,
                       point, normal);
}
std::string box(const std::string& low, const std::string& high, const std::string& name = "box") {
    return fmt::format("[[object]]\nname = \"{}\"\nrole = \"blocker\"\nbox = {{ min = {}, max = {} }}\n", name, low,
                       high);
}

void expectClosed(const Bake& b) {
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    EXPECT_LT(b.report().path.imbalance(), 1e-5);
}

TEST(WavefrontObjects, AFloorEndsLightTwoVoxelsBehindIt) {
    // 32 layers of 1/32 from -0.5 on: the floor is in layer 8, light fills it and two more.
    const Bake b = bake(sceneOf(kBox, kDown, kEven + plane("[0, 0, -0.24]", "[0, 0, 1]")));
    const GridFrame& frame = b.field().frame();
    const int floor = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.24}).z));
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        EXPECT_NEAR(b.fluence({0, 3, k}), k >= floor - 2 ? 1 : 0, 1e-5) << k - floor;
    EXPECT_NEAR(b.report().power.received, 1, 1e-4);  // 1 W/m2 on 1 m2
    EXPECT_NEAR(b.report().power.escaped, 0, 1e-9);
    expectClosed(b);
    // A blocker ends it where it is: its layer is filled up to it.
    const Bake blocked = bake(sceneOf(kBox, kDown, kEven + plane("[0, 0, -0.24]", "[0, 0, 1]", "blocker")));
    const double part = frame.indexFromWorld({0, 0, -0.24}).z - floor;
    EXPECT_NEAR(blocked.fluence({0, 3, floor}), 0.5 - part, 1e-4);
    EXPECT_EQ(blocked.fluence({0, 3, floor - 1}), 0);
    expectClosed(blocked);
}

// Endless walls along the rays of a sun's middle hide none of its disc: half of its directions come from behind each.
TEST(WavefrontObjects, WallsAlongTheSunHideNoneOfItsDisc) {
    const std::string sun = "type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1\nangular_diameter = 2";
    const std::string walls = plane("[-0.5, 0, 0]", "[1, 0, 0]", "receiver", "west") +
                              plane("[0.5, 0, 0]", "[-1, 0, 0]", "receiver", "east") +
                              plane("[0, -0.5, 0]", "[0, 1, 0]", "receiver", "south") +
                              plane("[0, 0.5, 0]", "[0, -1, 0]", "receiver", "north");
    const auto light = [&](const std::string& method, const GivenOptions& options, const std::string& beside) {
        return bakeWith(method, sceneOf(kBox, sun, kLuneburg + beside), options).report().path.deposited;
    };
    const GivenOptions eight = with("disc_samples", std::int64_t{8});
    EXPECT_NEAR(light("wavefront", eight, walls), light("wavefront", eight, ""), 0.01 * light("wavefront", eight, ""));
    EXPECT_NEAR(light("photons", paths(65536), walls), light("photons", paths(65536), ""),
                0.02 * light("photons", paths(65536), ""));
}

TEST(WavefrontObjects, ASlopeEndsEachRayWhereItIs) {
    const Bake b = bake(sceneOf(kBox, kDown, kEven + plane("[0, 0, 0]", "[0.6, 0, 0.8]")));
    const GridFrame& frame = b.field().frame();
    for (int i = frame.min.x; i <= frame.max.x; i += 3)
        for (int k = frame.min.z; k <= frame.max.z; ++k) {
            const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, 2, k));
            const double above = (p.z + 0.75 * p.x) * 32;  // voxels
            if (above > 1.2) {
                EXPECT_NEAR(b.fluence({i, 2, k}), 1, 1e-5);
            }
            if (above < -6) {
                EXPECT_EQ(b.fluence({i, 2, k}), 0) << i << " " << k << " " << above;
            }
        }
    EXPECT_NEAR(b.report().power.received, 1, 2e-3);
    expectClosed(b);
}

TEST(WavefrontObjects, AShadowIsAsLargeAsItsBlocker) {
    // A plate of 0.3 by 0.21 m across light that goes straight, anywhere among the rays: within the medium, and before
    // light comes to it.
    for (const double z : {0.1, 0.7})
        for (const double shift : {0.0, 0.011, 0.023}) {
            const Bake b = bake(sceneOf(kBox, kDown,
                                        kEven + plane("[0, 0, -0.24]", "[0, 0, 1]") +
                                            box(fmt::format("[{}, -0.1, {}]", -0.15 + shift, z),
                                                fmt::format("[{}, 0.11, {}]", 0.15 + shift, z + 0.02))));
            const GridFrame& frame = b.field().frame();
            const int above_floor = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.2}).z));
            double missing = 0;
            for (int i = frame.min.x; i <= frame.max.x; ++i)
                for (int j = frame.min.y; j <= frame.max.y; ++j) missing += 1 - b.fluence({i, j, above_floor});
            EXPECT_NEAR(missing / (32 * 32), 0.3 * 0.21, 0.01 * 0.3 * 0.21) << z << " " << shift;
            EXPECT_NEAR(
                z < 0.5 ? b.report().power.emitted - b.report().power.received : b.report().power.absorbed_surface,
                z < 0.5 ? 0 : 0.063, 7e-4);
            expectClosed(b);
        }
}

TEST(WavefrontObjects, APostBetweenTheRaysIsFound) {
    // A post of a third of a voxel, wherever it stands among rays that are a voxel apart, level in light that falls.
    double shadows = 0;
    for (const double shift : {0.0, 0.004, 0.009, 0.013, 0.02, 0.027}) {
        const Bake b = bake(
            sceneOf(kBox, kDown,
                    kEven + plane("[0, 0, -0.24]", "[0, 0, 1]") +
                        box(fmt::format("[-0.3, {}, 0.1]", shift), fmt::format("[0.3, {}, 0.11]", shift + 0.0104))));
        const GridFrame& frame = b.field().frame();
        const int above_floor = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.2}).z));
        double missing = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j) missing += 1 - b.fluence({i, j, above_floor});
        EXPECT_NEAR(missing / (32 * 32), 0.6 * 0.0104, 0.4 * 0.6 * 0.0104) << shift;
        shadows += missing / (32 * 32) / 6;
        expectClosed(b);
    }
    EXPECT_NEAR(shadows, 0.6 * 0.0104, 0.15 * 0.6 * 0.0104);
}

TEST(WavefrontObjects, TheShadowOfBentLightIsWhereItsRaysGo) {
    // n^2 = 1.5 - 3 x: a ray that passes the lower edge of a plate, at x = -0.1 and a depth of 0.42, is bent on along
    // its parabola x = x0 - g d^2 / (2 n0^2), g = 1.5, and is the shadow's rim.
    const double g = 1.5, edge = -0.1, depth = 0.42;
    double low = edge, high = 0.4;
    for (int i = 0; i < 60; ++i) {
        const double x0 = 0.5 * (low + high);
        (x0 - 0.5 * g * depth * depth / (1.5 - 3 * x0) < edge ? low : high) = x0;
    }
    for (const double h : {1.0 / 32, 1.0 / 64}) {
        const std::string domain = fmt::format("min = [-0.8, 0, -0.75]\nmax = [0.2, 0.25, 0]\nvoxel_size = {}", h),
                          index = medium("{ kind = \"linear\", n0 = 1.224744871391589, slope = [-3, 0, 0] }");
        const Bake b = bake(sceneOf(domain, kDown, index + box("[-1, -1, -0.42]", fmt::format("[{}, 1, -0.4]", edge)))),
                   open = bake(sceneOf(domain, kDown, index));
        const GridFrame& frame = b.field().frame();
        for (int k = frame.min.z; k <= frame.max.z; ++k) {
            const double at = -frame.worldFromIndex(glm::dvec3(0, 0, k)).z;
            if (at < 0.45 || at > 0.6) continue;
            const double rim = low - 0.5 * g * at * at / (1.5 - 3 * low);
            double lit = 0, all = 0;
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const double x = frame.worldFromIndex(glm::dvec3(i, 0, k)).x;
                const glm::ivec3 voxel(i, 3, k);
                if (x < rim - 1.5 * h) {
                    EXPECT_LT(b.fluence(voxel), 1e-5) << h << " " << x << " " << at;
                }
                // Of the voxel with the rim, the part beyond it.
                const double beyond = std::clamp((x - rim) / h + 0.5, 0.0, 1.0);
                lit += b.fluence(voxel), all += beyond * open.fluence(voxel);
            }
            EXPECT_NEAR(lit, all, 6e-3 * all) << h << " " << at;
        }
        expectClosed(b);
    }
}

TEST(WavefrontObjects, AgreeWithPhotons) {
    // A floor, a post in the lens's light, a plate before it, and a wall that light turns to; photons end on the same.
    const std::string objects = plane("[0, 0, -0.38]", "[0, 0, 1]") + box("[-0.3, 0.05, -0.3]", "[-0.05, 0.12, 0.2]") +
                                box("[0.1, -0.2, 0.6]", "[0.3, 0.1, 0.65]", "plate");
    for (const std::string& light :
         {kDown, kSlant, std::string("type = \"point\"\nposition = [0.1, 0, 1.5]\npower = 12.566370614")}) {
        Scene scene = sceneOf(kBox, light, kLuneburg + objects);
        scene.bake.paths = Paths::All, scene.bake.quadrature = 4;
        GivenOptions fine = with("spacing", 0.25);
        fine["steps"] = {std::int64_t{4}, "test"};
        const Bake photons = bakeWith("photons", scene, paths(96000)), fronts = bake(scene, fine);
        const Difference d = compare(photons, fronts);
        EXPECT_LT(d.apart, 0.8 * d.error + 0.015) << light << ": error " << d.error;
        EXPECT_NEAR(d.total, 1, 8e-3) << light;
        const PowerLedger &p = photons.report().power, &f = fronts.report().power;
        // Photons that miss the voxels and meet the floor beside them count as received.
        if (light != kSlant) {
            EXPECT_NEAR(f.received, p.received, 0.01 * p.received) << light;
        }
        EXPECT_NEAR(f.absorbed_surface, p.absorbed_surface, 0.02 * p.absorbed_surface + 1e-6) << light;
        expectClosed(fronts);
    }
}

TEST(WavefrontObjects, LightThatTurnedEndsToo) {
    // Level light that is bent down by more than 60 degrees, onto a floor and beside a post, as photons are.
    Scene scene = sceneOf("min = [0, 0, -0.9]\nmax = [1, 0.25, 0.1]\nresolution = 32",
                          "type = \"sun\"\ndirection = [1, 0, 0]\nirradiance = 1\nangular_diameter = 0",
                          medium("{ kind = \"linear\", n0 = 2, slope = [0, 0, -14] }") +
                              plane("[0, 0, -0.8]", "[0, 0, 1]") + box("[0.5, 0.05, -0.9]", "[0.6, 0.15, -0.3]"));
    scene.bake.quadrature = 4;
    GivenOptions fine = with("spacing", 0.25);
    fine["steps"] = {std::int64_t{4}, "test"};
    const Bake photons = bakeWith("photons", scene, paths(96000)), fronts = bake(scene, fine);
    // Behind the floor photons go straight on, and fronts as they are bent.
    const int floor = static_cast<int>(std::lround(fronts.field().frame().indexFromWorld({0, 0, -0.8}).z));
    const Difference d = compare(photons, fronts, floor);
    EXPECT_LT(d.apart, 0.8 * d.error + 0.015) << "error " << d.error;
    EXPECT_NEAR(d.total, 1, 5e-3);
    EXPECT_NEAR(fronts.report().power.received, photons.report().power.received,
                0.02 * photons.report().power.emitted);  // a photon's last step goes on beside the voxels
    expectClosed(fronts);
}

TEST(WavefrontObjects, ThreadsChangeNoBit) {
    const Scene scene =
        sceneOf(kBox, kSlant,
                kLuneburg + plane("[0, 0, -0.38]", "[0, 0, 1]") + box("[-0.3, 0.05, -0.3]", "[-0.05, 0.12, 0.2]"));
    setThreadCount(1);
    const Bake one = bake(scene);
    setThreadCount(3);
    const Bake three = bake(scene);
    setThreadCount(0);
    EXPECT_EQ(one.report().power.received, three.report().power.received);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
}

}  // namespace
}  // namespace photic
