// SPDX-License-Identifier: Apache-2.0
// Photons through media whose index varies: against rays in closed form, and beside `wavefront`.
#include "bake/methods/graded_photons.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

/// Photons beside fine fronts, with all light counted: where light begins to count, both are a voxel off. Noise alone
/// is 0.8 standard errors on average.
void expectAlike(Scene scene, double bias, const std::string& what) {
    scene.bake.paths = Paths::All, scene.bake.quadrature = 4;
    GivenOptions fine = with("spacing", 0.25);
    fine["steps"] = {std::int64_t{4}, "test"};
    const Bake photons = bakeWith("photons", scene, paths(96000)), fronts = bake(scene, fine);
    const Difference d = compare(photons, fronts);
    EXPECT_LT(d.apart, 0.8 * d.error + bias) << what << ": error " << d.error;
    EXPECT_NEAR(d.total, 1, 5e-3) << what;
    EXPECT_LT(d.error, 0.05) << what;
    EXPECT_LT(photons.report().power.imbalance(), 1e-9) << what;
    EXPECT_LT(photons.report().path.imbalance(), 1e-5) << what;
    EXPECT_NEAR(photons.report().power.emitted, fronts.report().power.emitted, 2e-3 * fronts.report().power.emitted)
        << what;
}

const std::string kBox = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32",
                  kSlant = "type = \"sun\"\ndirection = [0.3, 0.2, -0.93]\nirradiance = 1\nangular_diameter = 0";

TEST(GradedPhotons, AgreeWithFrontsInALens) {
    expectAlike(sceneOf(kBox, kDown, medium("{ kind = \"luneburg\", radius = 0.4 }")), 0.01, "luneburg");
    expectAlike(sceneOf(kBox, kSlant, medium("{ kind = \"fish_eye\", n0 = 1.6, scale = 0.5163978, radius = 0.4 }")),
                0.01, "ball");
    // What attenuates in colour, below a lamp.
    expectAlike(sceneOf(kBox, "type = \"point\"\nposition = [0.1, 0, 1.5]\npower = 12.566370614",
                        medium("{ kind = \"luneburg\", radius = 0.4 }", "absorption = [1, 2, 3]\nscattering = 1")),
                0.01, "lamp");
}

TEST(GradedPhotons, AgreeWithFrontsInAWorldThatIsAllMedium) {
    // Which light enters by its sides too.
    expectAlike(sceneOf("min = [-0.5, 0, -1]\nmax = [0.5, 0.25, 0]\nvoxel_size = 0.03125",
                        "type = \"sun\"\ndirection = [0.5, 0, -0.866]\nirradiance = 1\nangular_diameter = 0",
                        medium("{ kind = \"salt\", level = -0.3, thickness = 0.1, n_above = 1.3, n_below = 1.4, "
                               "amplitude = 0.05, wavelength = 0.5 }")),
                0.01, "salt");
}

TEST(GradedPhotons, FollowTheRaysOfASelfocRod) {
    // r = r0 cos(g depth / root), root = sqrt(1 - g^2 r0^2): light from a ring stays between its ring's rays. The power
    // within a circle that narrows as a ray of r0 = 0.1 does is the same at every depth.
    const double g = 1.4, r0 = 0.1, root = std::sqrt(1 - g * g * r0 * r0);
    const Bake b = bakeWith("photons",
                            sceneOf("min = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0]\nresolution = 32", kDown,
                                    medium("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }")),
                            paths(160000));
    const GridFrame& frame = b.field().frame();
    const double h = frame.worldFromIndex()[0][0];
    for (const double depth : {0.2, 0.4, 0.6}) {
        const int k = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -depth}).z));
        const double middle = -frame.worldFromIndex(glm::dvec3(0, 0, k)).z;
        const double radius = r0 * std::cos(g * middle / root);
        double within = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j) {
                // Each voxel's share of the circle.
                const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                int inside = 0;
                for (int n = 0; n < 256; ++n)
                    inside += std::hypot(p.x + h * ((n % 16 + 0.5) / 16 - 0.5), p.y + h * ((n / 16 + 0.5) / 16 - 0.5)) <
                              radius;
                within -= b.field().flux({i, j, k}).z * h * h * inside / 256;
            }
        EXPECT_NEAR(within, 3.14159265 * r0 * r0, 0.012 * 3.14159265 * r0 * r0) << depth;
    }
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    EXPECT_EQ(b.report().power.dropped, 0);
}

TEST(GradedPhotons, FallAsBallsDo) {
    // n^2 = 4 - 14 z: level light goes down as z = z0 - 14 x^2 / (4 n0^2), n0 at z0; before its caustic, at x = 0.37 or
    // more, the light in a voxel is that of one parabola.
    const Scene scene = sceneOf("min = [0, 0, -0.9]\nmax = [1, 0.25, 0.1]\nresolution = 32",
                                "type = \"sun\"\ndirection = [1, 0, 0]\nirradiance = 1\nangular_diameter = 0",
                                medium("{ kind = \"linear\", n0 = 2, slope = [0, 0, -14] }"));
    const Bake b = bakeWith("photons", scene, paths(48000));
    const GridFrame& frame = b.field().frame();
    // The slope of the light: dz/dx = -14 x / (2 n0^2), and n0^2 = n^2 at the height where it came in.
    double worst = 0;
    for (const double x : {0.1, 0.2, 0.3})
        for (const double z0 : {0.05, 0.0, -0.1}) {
            const double square = 4 - 14 * z0, z = z0 - 14 * x * x / (4 * square);
            const glm::ivec3 voxel(glm::round(frame.indexFromWorld({x, 0.125, z})));
            const glm::dvec3 flux = b.field().flux(voxel), at = frame.worldFromIndex(glm::dvec3(voxel));
            // Of the ray that comes through the voxel's middle.
            double from = z0;
            for (int i = 0; i < 50; ++i) from = at.z + 14 * at.x * at.x / (4 * (4 - 14 * from));
            worst = std::max(worst, std::fabs(flux.z / flux.x + 14 * at.x / (2 * (4 - 14 * from))));
        }
    EXPECT_LT(worst, 0.02);
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    EXPECT_LT(b.report().path.imbalance(), 1e-5);
}

TEST(GradedPhotons, ThreeIndicesDisperse) {
    const std::string ball = "{ kind = \"luneburg\", radius = 0.3 }";
    Scene scene =
        sceneOf("min = [-0.4, -0.4, -0.6]\nmax = [0.4, 0.4, 0.4]\nresolution = 24", kDown,
                medium("[" + ball + ", " + ball + ", { kind = \"fish_eye\", n0 = 1.1, scale = 1, radius = 0.3 }]"));
    scene.bake.paths = Paths::All;
    const Bake b = bakeWith("photons", scene, paths(16000)), fronts = bake(scene);
    EXPECT_EQ(b.field().sum(0), b.field().sum(1));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(b.field().sum(c), fronts.field().sum(c), 0.02 * fronts.field().sum(c)) << c;
    EXPECT_GT(std::fabs(b.field().sum(0) - b.field().sum(2)), 1e-3 * b.field().sum(0));
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
}

TEST(GradedPhotons, AreCountedOnceAVoxel) {
    // Through air that hardly bends, steps are half a voxel long, and each photon counts once in each.
    const Scene scene = sceneOf("min = [0, 0, 0]\nmax = [1, 1, 1]\nresolution = 8", kDown,
                                medium("{ kind = \"linear\", n0 = 1.2, slope = [0, 0, 1e-3] }"));
    const Bake b = bakeWith("photons", scene, paths(16000));
    for (int layer = 0; layer < 8; ++layer) {
        double sum = 0;
        for (int i = 0; i < 64; ++i) sum += double(b.result.path_count->value({i % 8, i / 8, layer}, 0));
        EXPECT_EQ(sum, 16000) << layer;
    }
}

TEST(GradedPhotons, EndOnReceiversAndBlockers) {
    // A floor below the lens, and a blocker above half of it.
    const std::string
        lens = medium("{ kind = \"luneburg\", radius = 0.3 }"),
        floor = "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -0.35], normal = [0, 0, 1] }\n",
        shade =
            "[[object]]\nname = \"shade\"\nrole = \"blocker\"\nbox = { min = [0, -1, 1], max = [1, 1, 1.1] "
            "}\n";
    const std::string box = "min = [-0.4, -0.4, -0.5]\nmax = [0.4, 0.4, 0.4]\nresolution = 32";
    const Bake open = bakeWith("photons", sceneOf(box, kDown, lens), paths(50000)),
               floored = bakeWith("photons", sceneOf(box, kDown, lens + floor), paths(50000));
    const PowerLedger &free = open.report().power, &caught = floored.report().power;
    EXPECT_LT(caught.imbalance(), 1e-9);
    EXPECT_EQ(free.received, 0);
    // Light beside the lens is not in the grid, and ends on the floor as well.
    EXPECT_GT(caught.received, 0.9 * free.escaped);
    const GridFrame& frame = floored.field().frame();
    const auto at = [&](double z) { return glm::ivec3(glm::round(frame.indexFromWorld({0, 0, z}))); };
    EXPECT_EQ(floored.fluence(at(-0.48)), 0);
    EXPECT_GT(open.fluence(at(-0.48)), 0.1);
    EXPECT_NEAR(floored.fluence(at(-0.31)), open.fluence(at(-0.31)), 1e-3 * open.fluence(at(-0.31)));
    // The blocker stands between the sun and the plane that light comes in by.
    const Bake shaded = bakeWith("photons", sceneOf(box, kDown, lens + shade), paths(50000));
    EXPECT_LT(shaded.report().power.imbalance(), 1e-9);
    EXPECT_NEAR(shaded.report().power.absorbed_surface, 0.5 * free.emitted, 0.01 * free.emitted);
    EXPECT_NEAR(shaded.report().power.escaped, 0.5 * free.escaped, 0.01 * free.emitted);
}

TEST(GradedPhotons, StandHardIndices) {
    const std::string box = ", min = [-0.2, -0.2, -0.2], max = [0.21, 0.2, 0.2] }";
    for (const std::string& index :
         {"{ kind = \"linear\", n0 = 2.5, slope = [0, 0, 0]" + box,
          "{ kind = \"linear\", n0 = 0.5, slope = [0, 0, 0]" + box,
          "{ kind = \"linear\", n0 = 2, slope = [6, 3, -4]" + box,
          std::string("{ kind = \"luneburg\", radius = 0.007 }"), std::string("{ kind = \"luneburg\", radius = 0.05 }"),
          std::string("{ kind = \"fish_eye\", n0 = 3, scale = 0.15, radius = 0.25 }"),
          std::string("{ kind = \"fish_eye\", n0 = 3, scale = 0.15 }")})
        for (const char* way : {"[0, 0, -1]", "[1, 0.2, 0.1]", "[0, 1, 1]"}) {
            const Bake b = bakeWith(
                "photons",
                sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 12",
                        "type = \"sun\"\nangular_diameter = 1\nirradiance = 1\ndirection = " + std::string(way),
                        medium(index, "absorption = 0.5")),
                paths(1000));
            EXPECT_LT(b.report().power.imbalance(), 1e-9) << index << way;
            EXPECT_LT(b.report().path.imbalance(), 1e-4) << index << way;
            EXPECT_TRUE(std::isfinite(b.field().sum(0))) << index << way;
            EXPECT_GE(b.field().sum(0), 0) << index << way;
        }
}

TEST(GradedPhotons, ThreadsChangeNoBit) {
    const Scene scene = sceneOf("min = [-0.4, -0.4, -0.5]\nmax = [0.4, 0.4, 0.4]\nresolution = 24", kDown,
                                medium("{ kind = \"luneburg\", radius = 0.3 }", "absorption = 0.3"));
    setThreadCount(1);
    const Bake one = bakeWith("photons", scene, paths(8000));
    setThreadCount(3);
    const Bake three = bakeWith("photons", scene, paths(8000));
    setThreadCount(0);
    EXPECT_EQ(one.report().path.expected, three.report().path.expected);
    EXPECT_EQ(one.report().power.escaped, three.report().power.escaped);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
}

}  // namespace
}  // namespace photic
