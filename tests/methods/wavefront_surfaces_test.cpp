// SPDX-License-Identifier: Apache-2.0
// Sharp surfaces and water among media whose index varies.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "bake/methods/wavefront.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

const std::string kSlant = "type = \"sun\"\ndirection = [0.3, 0.12, -0.95]\nirradiance = 1\nangular_diameter = 0",
                  kPool = "min = [-0.5, -0.5, -1]\nmax = [0.5, 0.5, 0.125]\nvoxel_size = 0.03125",
                  kBox = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 32",
                  kWaves =
                      "[[surface]]\nname = \"waves\"\nkind = \"height_field\"\nevent = \"EVENT\"\n"
                      "waves = [{ amplitude = 0.02, wavelength = 0.6, direction = [1, 0.3] }, "
                      "{ amplitude = 0.01, wavelength = 0.35, direction = [-0.3, 1] }]\n";

std::string named(const std::string& name, const std::string& index, const std::string& more = "") {
    return fmt::format("[[medium]]\nname = \"{}\"\nindex = {}\n{}\n", name, index, more);
}
std::string even(double n) { return fmt::format("{{ kind = \"linear\", n0 = {}, slope = [0, 0, 0] }}", n); }
std::string flat(const std::string& more = "") {
    return "[[surface]]\nname = \"flat\"\nkind = \"height_field\"\nflat = true\n" + more + "\n";
}
std::string waves(const std::string& event) {
    std::string out = kWaves;
    return out.replace(out.find("EVENT"), 5, event);
}
std::string ball(const std::string& name, const std::string& inside, const std::string& at, double radius,
                 const std::string& event = "both") {
    return fmt::format(
        "[[surface]]\nname = \"{}\"\nkind = \"sphere\"\nposition = {}\nradius = {}\ninside = \"{}\"\nevent = \"{}\"\n",
        name, at, radius, inside, event);
}
std::string glass(double n = 1.5, const std::string& more = "") {
    return fmt::format("[[medium]]\nname = \"glass\"\nior = {}\n{}\n", n, more);
}
std::string plane(const std::string& point, const std::string& normal, const std::string& role = "receiver") {
    return fmt::format("[[object]]\nname = \"plane\"\nrole = \"{}\"\nplane = {{ point = {}, normal = {} }}\n", role,
                       point, normal);
}

void expectClosed(const Bake& b, const std::string& what, double path = 1e-5) {
    EXPECT_LT(b.report().power.imbalance(), 1e-9) << what;
    EXPECT_LT(b.report().path.imbalance(), path) << what;
}

/// Share of unpolarised light that passes a flat face.
double passes(double n1, double n2, double cosine) {
    const double sine = n1 / n2 * std::sqrt(1 - cosine * cosine), other = std::sqrt(1 - sine * sine);
    const double s = (n1 * cosine - n2 * other) / (n1 * cosine + n2 * other),
                 p = (n2 * cosine - n1 * other) / (n2 * cosine + n1 * other);
    return 1 - 0.5 * (s * s + p * p);
}

TEST(WavefrontSurfaces, LightFallsOnAParabolaBelowFlatWater) {
    // n^2 = 1.333^2 - 2 z below the water. What lies level of the light's momentum stays: sin of its angle times n.
    const double n0 = 1.333, sine = 0.6, cosine = 0.8;
    const std::string media = named("water", "{ kind = \"linear\", n0 = 1.333, slope = [0, 0, -2] }"),
                      sun = "type = \"sun\"\ndirection = [0.6, 0, -0.8]\nirradiance = 1\nangular_diameter = 0";
    const Bake b = bake(sceneOf(kPool, sun, media + flat()));
    expectClosed(b, "open");
    const GridFrame& frame = b.field().frame();
    const double level = cosine * passes(1, n0, cosine);
    EXPECT_EQ(b.fluence({0, 0, 1}), 0) << "above the water";
    for (int k = frame.min.z; k < 0; ++k) {
        const double z = frame.worldFromIndex(glm::dvec3(0, 0, k)).z, n = std::sqrt(n0 * n0 - 2 * z);
        const double down = std::sqrt(1 - sine * sine / (n * n));
        for (const int i : {-12, 0, 12}) {
            EXPECT_NEAR(b.fluence({i, 5, k}), level / down, 2e-3 * level) << z;
            EXPECT_NEAR(-b.field().flux({i, 5, k}).z, level, 5e-4 * level) << z;
        }
    }
    // The rim of a shadow goes down the parabola of its ray: x = 2 sine (sqrt(c - 2 z) - sqrt(c)) / 2, c = n0^2 -
    // sine^2.
    const std::string shade =
        "[[object]]\nname = \"shade\"\nrole = \"blocker\"\nbox = { min = [-9, -9, 0.09], max = [-0.3, 9, 0.11] }\n";
    const Bake shaded = bake(sceneOf(kPool, sun, media + flat() + shade));
    expectClosed(shaded, "shaded");
    const double c = n0 * n0 - sine * sine, h = frame.worldFromIndex()[0][0];
    const double on_water = -0.3 + 0.11 * sine / cosine;  // from the upper edge of the box
    for (const int k : {-8, -16, -24, -31}) {
        const double z = frame.worldFromIndex(glm::dvec3(0, 0, k)).z;
        const double rim = on_water + sine * (std::sqrt(c - 2 * z) - std::sqrt(c));
        double lit = 0;  // voxels of a row
        for (int i = frame.min.x; i <= frame.max.x; ++i) lit += shaded.fluence({i, 5, k}) / b.fluence({i, 5, k});
        EXPECT_NEAR(0.5 - lit * h, rim, 0.15 * h) << z;
    }
}

TEST(WavefrontSurfaces, AreTheBeamsWhereTheIndexIsEven) {
    // The same water by beams, which refine their tubes, at default settings of both.
    const Bake fronts =
                   bake(sceneOf(kPool, kSlant, named("water", even(1.333), "absorption = 0.4") + waves("refract"))),
               beams = bakeWith("beams",
                                sceneOf(kPool, kSlant, "[medium]\nior = 1.333\nabsorption = 0.4\n" + waves("refract")));
    expectClosed(fronts, "waves");
    EXPECT_LT(apart(fronts, beams), 0.01);
    EXPECT_NEAR(fronts.field().sum(0), beams.field().sum(0), 1e-3 * beams.field().sum(0));
    // And a ball, of eight voxels, with all that it reflects.
    const std::string at = "[0.05, 0, 0.1]";
    const Bake ball_fronts = bake(sceneOf(
                   kBox, kSlant, named("core", even(1.5), "absorption = 0.5") + ball("ball", "core", at, 0.25))),
               ball_beams = bakeWith(
                   "beams", sceneOf(kBox, kSlant, glass(1.5, "absorption = 0.5") + ball("ball", "glass", at, 0.25)));
    expectClosed(ball_fronts, "ball");
    EXPECT_LT(apart(ball_fronts, ball_beams), 0.03);
    EXPECT_NEAR(ball_fronts.field().sum(0), ball_beams.field().sum(0), 3e-3 * ball_beams.field().sum(0));
    // What is in each term of both ledgers, of what meets the ball.
    const PowerLedger &a = ball_fronts.report().power, &b = ball_beams.report().power;
    const double caught = std::numbers::pi * 0.25 * 0.25;
    EXPECT_NEAR(a.absorbed_medium, b.absorbed_medium, 2e-3 * caught);
    EXPECT_NEAR(a.escaped, b.escaped, 5e-3 * caught);
    EXPECT_LT(a.dropped, 0.01 * caught);
}

/// A block with flat faces, wound outwards.
std::shared_ptr<TriangleMesh> block(const glm::dvec3& low, const glm::dvec3& high) {
    auto mesh = std::make_shared<TriangleMesh>();
    for (int axis = 0; axis < 3; ++axis)
        for (const bool up : {false, true}) {
            const auto first = static_cast<std::uint32_t>(mesh->positions.size());
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            glm::dvec3 normal(0);
            normal[axis] = up ? 1 : -1;
            for (int corner = 0; corner < 4; ++corner) {
                glm::dvec3 p;
                p[axis] = up ? high[axis] : low[axis];
                p[u] = corner == 1 || corner == 2 ? high[u] : low[u], p[v] = corner > 1 ? high[v] : low[v];
                mesh->positions.push_back(p), mesh->normals.push_back(normal);
            }
            for (const auto& t : {std::array<std::uint32_t, 3>{0, 1, 2}, std::array<std::uint32_t, 3>{0, 2, 3}}) {
                std::array<std::uint32_t, 3> corners{first + t[0], first + t[1], first + t[2]};
                if (!up) std::swap(corners[1], corners[2]);
                mesh->triangles.push_back({corners[0], corners[1], corners[2]});
            }
        }
    return mesh;
}

/// A scene whose surface is that block, in place of a ball.
Scene blockScene(const std::string& domain, const std::string& light, const std::string& media, const glm::dvec3& low,
                 const glm::dvec3& high, const std::string& event) {
    Scene scene = sceneOf(domain, light, media + ball("block", "core", "[0, 0, 0]", 0.1, event));
    Surface& surface = scene.surfaces.front();
    surface.sphere.reset(), surface.mesh = block(low, high), surface.smooth = false,
                            surface.center = 0.5 * (low + high);
    return scene;
}

TEST(WavefrontSurfaces, ASlabOfSelfocLosesLightAtItsFacesAlone) {
    // r = r0 cos(g depth / root) inside; straight on, and bent by Snell's law, below it.
    const double n0 = 1.5, g = 1.4, r0 = 0.15, thickness = 0.4;
    const Bake b = bake(blockScene("min = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0.1]\nvoxel_size = 0.0125", kDown,
                                   named("core", "{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }"),
                                   {-0.35, -0.35, -thickness}, {0.35, 0.35, 0}, "refract"));
    expectClosed(b, "slab");
    const GridFrame& frame = b.field().frame();
    const double h = frame.worldFromIndex()[0][0];
    const auto indexAt = [&](double r) { return n0 * std::sqrt(1 - g * g * r * r); };
    struct Ray {
        double r, slope, power;  // below the slab at a depth, of a ring's ray
    };
    const auto rayAt = [&](double start, double depth) {
        const double root = std::sqrt(1 - g * g * start * start), in = std::min(depth, thickness);
        Ray ray{start * std::cos(g * in / root), 0, passes(1, indexAt(start), 1)};
        if (depth <= thickness) return ray;
        // p_z = n0 root stays; p_r is what is left of the index.
        const double n = indexAt(ray.r), across = -n0 * g * start * std::sin(g * in / root);
        ray.power *= passes(n, 1, std::sqrt(1 - across * across / (n * n)));
        ray.slope = across / std::sqrt(1 - across * across);
        ray.r += (depth - thickness) * ray.slope;
        return ray;
    };
    for (const double depth : {0.1, 0.3, 0.39, 0.45, 0.55, 0.65}) {
        const int k = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -depth}).z));
        const double middle = -frame.worldFromIndex(glm::dvec3(0, 0, k)).z;
        const double radius = std::fabs(rayAt(r0, middle).r);
        double within = 0, truth = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j) {
                const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                int inside = 0;
                for (int n = 0; n < 256; ++n)
                    inside += std::hypot(p.x + h * ((n % 16 + 0.5) / 16 - 0.5), p.y + h * ((n / 16 + 0.5) / 16 - 0.5)) <
                              radius;
                within -= b.field().flux({i, j, k}).z * h * h * inside / 256;
            }
        constexpr int kRings = 2000;
        for (int ring = 0; ring < kRings; ++ring) {
            const double start = 0.4 * (ring + 0.5) / kRings;
            const Ray ray = rayAt(std::min(start, 0.35), middle);
            if (std::fabs(ray.r) <= radius && start < 0.35)
                truth += 2 * std::numbers::pi * start * (0.4 / kRings) * ray.power;
        }
        EXPECT_NEAR(within, truth, 0.01 * truth) << depth;
    }
}

/// Default fronts beside photons in one scene. Noise alone is 0.8 standard errors on average.
void expectPhotons(const Scene& scene, std::int64_t count, double bias, const std::string& what, double total = 5e-3) {
    const Bake photons = bakeWith("photons", scene, paths(count)), fronts = bake(scene);
    const Difference d = compare(photons, fronts);
    EXPECT_LT(d.apart, 0.8 * d.error + bias) << what << ": error " << d.error;
    EXPECT_NEAR(d.total, 1, total) << what;
    expectClosed(photons, what);
    expectClosed(fronts, what, 1e-4);
    // Not what is absorbed: fronts follow light that leaves the grid by its sides down to its last layer.
    const PowerLedger &a = fronts.report().power, &b = photons.report().power;
    for (const auto term : {&PowerLedger::emitted, &PowerLedger::received, &PowerLedger::absorbed_surface,
                            &PowerLedger::reflected, &PowerLedger::dropped})
        EXPECT_NEAR(a.*term, b.*term, 5e-3 * a.emitted + 0.02 * b.*term) << what;
}

TEST(WavefrontSurfaces, AgreeWithPhotonsInSaltLayersBelowWaves) {
    expectPhotons(sceneOf(kPool, kSlant,
                          named("water",
                                "{ kind = \"salt\", level = -0.4, thickness = 0.08, n_above = 1.333, n_below = 1.4, "
                                "amplitude = 0.05, wavelength = 0.4 }",
                                "absorption = [0.8, 0.3, 0.2]") +
                              waves("both") + plane("[0, 0, -0.9]", "[0, 0, 1]")),
                  200000, 0.015, "salt");
}

TEST(WavefrontSurfaces, AgreeWithPhotonsInBallsOfEveryKind) {
    // Luneburg's lens with a sharp rim, a ball of glass, and one of metal.
    expectPhotons(
        sceneOf(kBox, kSlant,
                glass(1.5, "absorption = [1, 0.5, 0.2]") +
                    named("core", "{ kind = \"luneburg\", center = [0.05, 0, 0.1], radius = 0.3 }") +
                    ball("lens", "core", "[0.05, 0, 0.1]", 0.25) + ball("glass", "glass", "[0.2, 0, -0.25]", 0.12) +
                    "[[surface]]\nname = \"metal\"\nkind = \"sphere\"\nposition = [-0.2, 0.1, -0.3]\nradius = "
                    "0.12\nevent = \"mirror\"\ncolour = [0.9, 0.8, 0.7]\n"),
        200000, 0.08, "balls", 0.01);
    // A ball of glass in water whose index varies, below waves; one of air beside it; a lamp.
    expectPhotons(sceneOf(kPool, "type = \"point\"\nposition = [0.2, 0, 1.2]\npower = 12.566370614",
                          glass(1.6) + named("water", "{ kind = \"linear\", n0 = 1.333, slope = [0.1, 0, -0.3] }") +
                              waves("both") + ball("glass", "glass", "[-0.2, 0, -0.45]", 0.15) +
                              ball("bubble", "air", "[0.2, 0.1, -0.5]", 0.1) + plane("[0, 0, -0.9]", "[0, 0, 1]")),
                  200000, 0.05, "in water", 0.01);
    // A ball of glass in warm air that fills the world.
    Scene warm = sceneOf(kBox, kSlant,
                         glass() +
                             named("air_over",
                                   "{ kind = \"hot_air\", ground = -0.5, height = 0.2, n = 1.0003, drop "
                                   "= 0.1 }") +
                             ball("glass", "glass", "[0, 0, 0.1]", 0.25));
    expectPhotons(warm, 200000, 0.06, "warm air", 0.01);
}

TEST(WavefrontSurfaces, ArrivalTimeCountsEachLeg) {
    // Straight down through flat water whose index grows with depth: T = -z above it, and the integral of n below.
    Scene scene =
        sceneOf(kPool, kDown, named("water", "{ kind = \"linear\", n0 = 1.333, slope = [0, 0, -2] }") + flat());
    scene.bake.grids.arrival_time = true;
    const Bake b = bake(scene);
    ASSERT_TRUE(b.result.arrival_time);
    const GridFrame& frame = b.field().frame();
    for (int k = frame.min.z; k < -1; k += 5) {
        const double z = frame.worldFromIndex(glm::dvec3(0, 0, k)).z, square = 1.333 * 1.333;
        const double truth = (std::pow(square - 2 * z, 1.5) - std::pow(square, 1.5)) / 3;
        EXPECT_NEAR(double(b.result.arrival_time->value({3, -2, k}, 0)), truth, 2e-4) << z;
    }
}

TEST(WavefrontSurfaces, ColoursPartWhereGlassDisperses) {
    // A ball of flint beside one whose index varies: three passes, of which each has its own index.
    const std::string flint = "[[medium]]\nname = \"glass\"\nior = [1.6, 1.62, 1.66]\n";
    const Scene scene = sceneOf(kBox, kDown,
                                flint + named("core", even(1.4)) + ball("flint", "glass", "[-0.2, 0, 0.2]", 0.15) +
                                    ball("other", "core", "[0.25, 0, 0.2]", 0.15));
    const Bake b = bake(scene);
    expectClosed(b, "flint", 5e-5);
    const GridFrame& frame = b.field().frame();
    // The focus of a ball from its centre: n R / (2 (n - 1)); blue's is the nearest.
    double peak[3] = {0, 0, 0};
    int at[3] = {0, 0, 0};
    const int column = static_cast<int>(std::lround(frame.indexFromWorld({-0.2, 0, 0}).x));
    for (int k = frame.min.z; k < static_cast<int>(frame.indexFromWorld({0, 0, 0.04}).z); ++k)
        for (int c = 0; c < 3; ++c) {
            double light = 0;
            for (const int i : {column - 1, column, column + 1})
                for (const int j : {-1, 0, 1}) light += double(b.field().value({i, j, k}, c));
            if (light > peak[c]) peak[c] = light, at[c] = k;
        }
    EXPECT_GE(at[2], at[0]);
    EXPECT_GT(std::fabs(b.field().sum(0) - b.field().sum(2)), 1e-3 * b.field().sum(0));
    // Grey beside the dispersing ball.
    const int other = static_cast<int>(std::lround(frame.indexFromWorld({0.25, 0, 0}).x)),
              below = static_cast<int>(std::lround(frame.indexFromWorld({0, 0, -0.1}).z));
    EXPECT_NEAR(double(b.field().value({other, 0, below}, 0)), double(b.field().value({other, 0, below}, 2)),
                0.02 * b.fluence({other, 0, below}));
}

TEST(WavefrontSurfaces, StandHardScenes) {
    const std::string water = named("water", "{ kind = \"linear\", n0 = 1.333, slope = [0, 0, -1] }");
    const std::string core = named("core", "{ kind = \"luneburg\", radius = 0.3 }");
    const std::string hard[] = {
        // A ball half in the water, of either priority, and one that is larger than the grid.
        water + glass() + waves("both") + ball("half", "glass", "[0, 0, 0]", 0.2),
        water + glass(1.5, "priority = 3") + waves("both") + ball("half", "glass", "[0, 0, 0]", 0.2),
        core + ball("large", "core", "[0, 0, 0]", 2),
        // Light that is reflected totally; jumps to less and much more than air; a pane; shells.
        core + glass(0.5) + ball("thin air", "glass", "[0, 0, 0]", 0.3),
        core + glass(4) + ball("dense", "glass", "[0, 0, 0]", 0.3),
        core + glass() + ball("pane", "glass", "[0, 0, 0]", 0.3) + "thin = true\n",
        core + glass() + ball("shell", "glass", "[0, 0, 0]", 0.3) + ball("hollow", "air", "[0, 0, 0]", 0.29),
        core + glass() + ball("a", "glass", "[0, 0, 0.1]", 0.2) + ball("b", "core", "[0, 0, -0.1]", 0.2),
        core + glass() + ball("speck", "glass", "[0, 0, 0.1]", 0.004),
        // A surface in a medium that fills the world and that it names.
        named("core", "{ kind = \"linear\", n0 = 1.5, slope = [0.5, 0, 0.5] }") +
            "[[surface]]\nname = \"bubble\"\nkind = \"sphere\"\nradius = 0.2\ninside = \"air\"\noutside = "
            "\"core\"\nevent = \"both\"\n",
    };
    for (const std::string& rest : hard)
        for (const char* way : {"[0, 0, -1]", "[1, 0.2, -0.5]"}) {
            Scene scene =
                sceneOf("min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 12",
                        "type = \"sun\"\nangular_diameter = 0\nirradiance = 1\ndirection = " + std::string(way), rest);
            const std::string what = rest + way;
            // Light that is almost level comes over the water in a long front, of which all goes to and fro between
            // ball and waves: a fourth of the rays shows the same.
            const bool long_front = way[1] == '1' && rest.find("waves") != std::string::npos;
            const Bake b = bake(scene, long_front ? with("spacing", 2.0) : GivenOptions{}),
                       photons = bakeWith("photons", scene, paths(2000));
            expectClosed(b, what, 1e-3);
            expectClosed(photons, what, 1e-3);
            EXPECT_TRUE(std::isfinite(b.field().sum(0))) << what;
            EXPECT_GE(b.field().sum(0), 0) << what;
        }
}

TEST(WavefrontSurfaces, BouncesEndAsPhotonsDo) {
    const std::string rest =
        named("core", "{ kind = \"luneburg\", radius = 0.5 }") + ball("ball", "core", "[0, 0, 0]", 0.25);
    for (const int bounces : {1, 2, 4}) {
        Scene scene = sceneOf(kBox, kDown, rest);
        scene.bake.bounces = bounces;
        const Bake b = bake(scene), photons = bakeWith("photons", scene, paths(50000));
        const PowerLedger &a = b.report().power, &p = photons.report().power;
        EXPECT_NEAR(a.dropped, p.dropped, 0.005 * a.emitted) << bounces;
        EXPECT_NEAR(b.field().sum(0), photons.field().sum(0), 0.01 * photons.field().sum(0)) << bounces;
    }
}

TEST(WavefrontSurfaces, ThreadsChangeNoBit) {
    const Scene scene = sceneOf(
        kPool, kSlant,
        glass() + named("water", "{ kind = \"linear\", n0 = 1.333, slope = [0.1, 0, -0.3] }", "absorption = 0.3") +
            waves("both") + ball("glass", "glass", "[-0.2, 0, -0.45]", 0.15) + plane("[0, 0, -0.9]", "[0, 0, 1]"));
    setThreadCount(1);
    const Bake one = bake(scene);
    setThreadCount(3);
    const Bake three = bake(scene);
    setThreadCount(0);
    EXPECT_EQ(one.report().path.expected, three.report().path.expected);
    EXPECT_EQ(one.report().power.received, three.report().power.received);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
}

}  // namespace
}  // namespace photic
