// SPDX-License-Identifier: Apache-2.0
// Media, lights, mirrors, spheres, placement and cameras as a scene file gives them, and what of them no method can
// bake yet.
#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/scene/not_built.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;
using test::SceneText;

class Glass : public SceneTest {
protected:
    void refusedRest(const std::string& rest, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.rest = rest;
        refused(text, where, words);
    }
    Scene loadRest(const std::string& rest) {
        SceneText text;
        text.rest = rest;
        return load(text);
    }
    Scene loadLightKeys(const std::string& keys) {
        SceneText text;
        text.light = "[[light]]\n" + keys + "\n";
        return load(text);
    }
    void refusedLight(const std::string& keys, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.light = "[[light]]\n" + keys + "\n";
        refused(text, where, words);
    }
    void notBuilt(const Scene& scene, const std::vector<std::string>& words) {
        const std::string why = notBuiltYet(scene);
        for (const std::string& word : words) EXPECT_NE(why.find(word), std::string::npos) << word << " in: " << why;
    }
};

TEST_F(Glass, NamedMediaLieInsideAndOutside) {
    const Scene scene = loadRest(
        "[[medium]]\nname = \"glass\"\nabbe = [1.52, 64]\npriority = 2\n"
        "[[medium]]\nname = \"wine\"\nior = [1.34, 1.345, 1.35]\nabsorption = [8, 30, 40]\n"
        "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.2\nposition = [0, 1, 2]\ninside = \"glass\"\n"
        "outside = \"wine\"\nevent = \"both\"\n"
        "[[surface]]\nname = \"bubble\"\nkind = \"sphere\"\nradius = 0.1\ninside = \"air\"\noutside = \"glass\"\n");
    ASSERT_EQ(scene.surfaces.size(), 3u);
    const Surface& ball = scene.surfaces[1];
    EXPECT_EQ(ball.sphere->center, glm::dvec3(0, 1, 2));
    EXPECT_EQ(ball.sphere->radius, 0.2);
    EXPECT_TRUE(ball.closed);
    EXPECT_EQ(ball.mesh->positions[0], glm::dvec3(0, 1, 2.2));
    const Medium inside = sideOf(scene, ball, Side::Below), outside = sideOf(scene, ball, Side::Above);
    EXPECT_EQ(inside.name, "glass");
    EXPECT_EQ(inside.priority, 2);
    EXPECT_NEAR(inside.ior.at(RefractiveIndex::kD_nm), 1.52, 1e-12);
    EXPECT_EQ(outside.name, "wine");
    EXPECT_EQ(outside.absorption, glm::dvec3(8, 30, 40));
    EXPECT_EQ(outside.ior.atChannels(), glm::dvec3(1.34, 1.345, 1.35));
    EXPECT_NEAR(ball.ior_below, 1.52, 1e-12);
    EXPECT_EQ(sideOf(scene, scene.surfaces[2], Side::Below).ior.at(550), 1);
    EXPECT_TRUE(scene.coloured());
    notBuilt(scene, {"'ball' is closed", "not built yet"});
}

TEST_F(Glass, TheWaterMayStateItsIndex) {
    // Constant: the same as ior_below. Dispersing: a medium of its own.
    Scene scene = loadRest("[medium]\nior = 1.34\nabsorption = 0.1\n");
    EXPECT_EQ(scene.surfaces[0].ior_below, 1.34);
    EXPECT_EQ(scene.surfaces[0].medium_below, -1);
    EXPECT_EQ(notBuiltYet(scene), "");
    scene = loadRest("[medium]\ncauchy = [1.324, 0.0031]\nabsorption = 0.1\n");
    const Medium below = sideOf(scene, scene.surfaces[0], Side::Below);
    EXPECT_EQ(below.absorption, glm::dvec3(0.1));
    EXPECT_NEAR(below.ior.at(500), 1.324 + 0.0031 / 0.25, 1e-12);
    notBuilt(scene, {"'water'", "not built yet"});
    scene = loadRest("[[medium]]\nname = \"water\"\nior = 1.33\nscattering = 0.2\n");
    EXPECT_EQ(scene.medium.scattering, glm::dvec3(0.2));
    EXPECT_EQ(scene.surfaces[0].ior_below, 1.33);
    EXPECT_EQ(notBuiltYet(scene), "");
    const Scene named = loadSurfaceKeys("flat = true\nabove = \"air\"\nbelow = \"water\"");
    EXPECT_EQ(named.surfaces[0].ior_below, 1.333);
    EXPECT_EQ(notBuiltYet(named), "");
}

TEST_F(Glass, MediaThatCannotBeAreRefused) {
    refusedRest("[[medium]]\nname = \"a\"\n", "s.toml:13:1", {"needs 'ior'", "abbe"});
    refusedRest("[[medium]]\nname = \"a\"\nior = 1\n[[medium]]\nname = \"a\"\nior = 2\n", "s.toml:17:1",
                {"'a' is taken"});
    refusedRest("[[medium]]\nname = \"a\"\nior = 1\nabbe = [1.5, 60]\n", "s.toml:16:1", {"contradict"});
    refusedRest("[[medium]]\nname = \"a\"\nior = 0\n", "s.toml:15:1", {"'ior' is 0", "0.01"});
    refusedRest("[[medium]]\nname = \"a\"\nior = [1, 2]\n", "s.toml:15:1", {"2 numbers"});
    refusedRest("[[medium]]\nname = \"a\"\nabbe = [1.5, 0]\n", "s.toml:15:1", {"greater than 0", "20 to 85"});
    refusedRest("[[medium]]\nname = \"a\"\nsellmeier = [1, 2, 3]\n", "s.toml:15:1", {"array of 6 numbers"});
    refusedRest("[[medium]]\nname = \"a\"\ncauchy = [1.5, 40000]\n", "s.toml:15:1", {"at 380 nm", "micrometres"});
    refusedRest("[[medium]]\nname = \"a\"\nsellmeier = [1, 0.2, 1, 0.25, 0.02, 100]\n", "s.toml:15:1",
                {"gives an index"});
    refusedRest(
        "[[medium]]\nname = \"glass\"\nior = 1.5\n[[surface]]\nkind = \"sphere\"\nradius = 1\ninside = \"glas\"\n",
        "s.toml:19:1", {"no [[medium]] called 'glas'", "did you mean 'glass'?"});
    refusedSurface("flat = true\nbelow = \"cognac\"", "s.toml:11:1", {"no [[medium]] called 'cognac'", "air, water"});
    refusedSurface("flat = true\nbelow = \"water\"\nior_below = 1.4", "s.toml:12:1", {"contradict"});
    refusedSurface("flat = true\ninside = \"water\"", "s.toml:11:1", {"'below'", "'above'"});
}

TEST_F(Glass, LightsHaveTheirOwnKeysAndUnits) {
    Light light = loadLightKeys("type = \"point\"\nposition = [0, 0, 2]\npower = 100").lights[0];
    EXPECT_EQ(light.type, LightType::Point);
    EXPECT_EQ(light.direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(light.power, glm::dvec3(100));
    EXPECT_NEAR(light.irradiance.x, 100 / (4 * M_PI * 4), 1e-9);

    light = loadLightKeys(
                "type = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 3, -3]\npower = [1, 2, 3]\nangle = 60\n"
                "blend = 0.5")
                .lights[0];
    EXPECT_EQ(light.type, LightType::Spot);
    EXPECT_NEAR(glm::length(light.direction - glm::dvec3(0, 1, -1) / std::sqrt(2.0)), 0, 1e-12);
    EXPECT_EQ(light.cone_angle_deg, 60);
    EXPECT_EQ(light.blend, 0.5);
    EXPECT_NEAR(light.irradiance.y, 2 / (4 * M_PI * 4), 1e-12);
    EXPECT_TRUE(light.coloured());

    const Scene scene = loadLightKeys(
        "type = \"rectangle\"\ncenter = [0, 0, 2]\nsize = [0.5, 0.25]\n"
        "direction = [0, 0, -1]\ntangent = [1, 1, 5]\npower = 40\nsamples = 9");
    light = scene.lights[0];
    EXPECT_EQ(light.type, LightType::Rectangle);
    EXPECT_EQ(*light.position, glm::dvec3(0, 0, 2));
    EXPECT_EQ(light.size, glm::dvec2(0.5, 0.25));
    EXPECT_NEAR(glm::length(light.tangent - glm::dvec3(1, 1, 0) / std::sqrt(2.0)), 0, 1e-12);
    EXPECT_EQ(light.samples, 9);
    EXPECT_NEAR(light.irradiance.x, 40 / (M_PI * 4), 1e-12);
    notBuilt(scene, {"'light 1' is a rectangle", "not built yet"});
    notBuilt(loadLightKeys("type = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -1]\npower = 1"), {"is a spot"});
    EXPECT_EQ(notBuiltYet(loadLightKeys("type = \"point\"\nposition = [0, 0, 2]\npower = 100")), "");
    notBuilt(loadLightKeys("type = \"point\"\nposition = [0, 0, -0.1]\npower = 100"), {"not above", "raise it"});
}

TEST_F(Glass, LightsThatCannotBeAreRefused) {
    refusedLight("type = \"point\"\nposition = [0, 0, 2]\npower = 1\ndirection = [0, 0, -1]", "s.toml:10:1",
                 {"'direction' is a sun's; a point has position, power"});
    refusedLight("type = \"point\"\nposition = [0, 0, 2]", "s.toml:6:1", {"needs 'power'"});
    refusedLight("type = \"point\"\npower = 3", "s.toml:6:1", {"needs 'position'"});
    refusedLight("type = \"point\"\nposition = [0, 0, 0]\npower = 3", "s.toml:6:1",
                 {"in the centre of 'water'", "move it"});
    refusedLight("type = \"point\"\nposition = [0, 0, 2]\npower = 1e13", "s.toml:9:1", {"1e+13 W", "1e+12"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, -1]\npower = 3", "s.toml:9:1",
                 {"'power' is a point's; a sun has"});
    refusedLight("type = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -1]\npower = 1\nangle = 181", "s.toml:11:1",
                 {"'angle' is 181", "0 to 180"});
    refusedLight("type = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -1]\npower = 1\nblend = 2", "s.toml:11:1",
                 {"'blend' is 2"});
    refusedLight(
        "type = \"rectangle\"\ncenter = [0, 0, 2]\nsize = [1, 1]\npower = 1\ndirection = [0, 0, -1]\n"
        "tangent = [0, 0, 2]",
        "s.toml:12:1", {"'tangent' is along 'direction'"});
    refusedLight("type = \"rectangle\"\ncenter = [0, 0, 2]\nsize = [1, 0]\npower = 1\ndirection = [0, 0, -1]",
                 "s.toml:9:", {"'size' is 0"});
}

TEST_F(Glass, ShapesArePlaced) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string keys = "kind = \"mesh\"\nfile = \"a.obj\"\n";
    // About x first: y to z; then about z: x to y.
    Surface surface =
        loadSurfaceKeys(keys + "position = [10, 0, 0]\nrotation = [90, 0, 90]\nscale = [2, 3, 1]\nior_below = 1.5")
            .surfaces[0];
    const auto& p = surface.mesh->positions;
    EXPECT_EQ(p[0], glm::dvec3(10, 0, 0));
    EXPECT_EQ(p[1], glm::dvec3(10, 2, 0));
    EXPECT_EQ(p[2], glm::dvec3(10, 0, 3));
    EXPECT_NEAR(glm::length(surface.mesh->normals[0] - glm::dvec3(1, 0, 0)), 0, 1e-12);
    // A mirror keeps sides: what was up is up.
    surface = loadSurfaceKeys(keys + "scale = [-1, 1, 1]").surfaces[0];
    const auto& t = surface.mesh->triangles[0];
    EXPECT_GT(glm::cross(surface.mesh->positions[t[1]] - surface.mesh->positions[t[0]],
                         surface.mesh->positions[t[2]] - surface.mesh->positions[t[0]])
                  .z,
              0);
    EXPECT_EQ(surface.mesh->normals[0], glm::dvec3(0, 0, 1));

    const Scene scene = loadRest(
        "[[object]]\nbox = { min = [0, 0, 0], max = [1, 1, 1] }\nposition = [0, 0, -3]\nscale = 2\n"
        "albedo = [0.1, 0.2, 0.3]\n");
    EXPECT_EQ(std::get<std::shared_ptr<const TriangleMesh>>(scene.objects[0].shape)->positions[0],
              glm::dvec3(0, 0, -3));
    EXPECT_EQ(*scene.objects[0].albedo, glm::dvec3(0.1, 0.2, 0.3));
    refusedSurface(keys + "scale = 0", "s.toml:12:1", {"'scale' is 0"});
    refusedSurface("flat = true\nposition = [0, 0, 1]", "s.toml:11:1", {"'center'"});
    refusedSurface("kind = \"sphere\"\nradius = 1\nior_below = 1.5\nscale = 2", "s.toml:13:1",
                   {"a sphere has 'radius'"});
    refusedRest("[[object]]\nplane = { point = [0, 0, 0] }\nposition = [0, 0, 1]\n", "s.toml:15:1",
                {"'point' and 'normal'"});
    refusedRest("[[object]]\nplane = { point = [0, 0, 0] }\nalbedo = 1.5\n", "s.toml:15:1", {"'albedo' is 1.5"});
}

TEST_F(Glass, MirrorsPanesAndBouncesAreReadAndRefusedByMethods) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string keys = "kind = \"mesh\"\nfile = \"a.obj\"\n";
    Scene scene = loadSurfaceKeys(keys + "event = \"mirror\"\ncolour = [0.9, 0.6, 0.2]");
    EXPECT_EQ(scene.surfaces[0].event, SurfaceEvent::Mirror);
    EXPECT_EQ(scene.surfaces[0].colour, glm::dvec3(0.9, 0.6, 0.2));
    notBuilt(scene, {"is a mirror", "not built yet"});
    scene = loadSurfaceKeys(keys + "thin = true");
    EXPECT_TRUE(scene.surfaces[0].thin);
    notBuilt(scene, {"thin pane", "not built yet"});
    refusedSurface(keys + "colour = 0.5", "s.toml:12:1", {"event = \"mirror\""});
    refusedSurface(keys + "event = \"mirror\"\nthin = true", "s.toml:13:1", {"lets none through"});
    scene = loadRest("[bake]\nbounces = 8\nthreshold = 1e-3\n");
    EXPECT_EQ(scene.bake.bounces.value_or(0), 8);
    EXPECT_EQ(scene.bake.threshold.value_or(0), 1e-3);
    notBuilt(scene, {"8 bounces"});
    EXPECT_EQ(notBuiltYet(loadRest("[bake]\nbounces = 1\n")), "");
    EXPECT_EQ(notBuiltYet(loadRest("")), "");
    refusedRest("[bake]\nbounces = 0\n", "s.toml:14:1", {"'bounces' is 0", "1 to 1000"});
    refusedRest("[bake]\nthreshold = 2\n", "s.toml:14:1", {"'threshold' is 2"});
}

TEST_F(Glass, CamerasLookSomewhere) {
    const Scene scene = loadRest(
        "[[camera]]\nposition = [3, -4, 2]\ntarget = [0, 0, -1]\nfield_of_view = 50\n"
        "[[camera]]\nname = \"top\"\nposition = [0, 0, 2]\ntarget = [0, 0, -1]\nup = [0, 2, 0]\n");
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.cameras[0].name, "camera 1");
    EXPECT_EQ(scene.cameras[0].field_of_view_deg, 50);
    EXPECT_EQ(scene.cameras[1].up, glm::dvec3(0, 1, 0));
    EXPECT_EQ(scene.cameras[1].field_of_view_deg, 34);
    refusedRest("[[camera]]\nposition = [0, 0, 2]\n", "s.toml:13:1", {"needs 'target'"});
    refusedRest("[[camera]]\nposition = [0, 0, 2]\ntarget = [0, 0, 2]\n", "s.toml:15:1", {"where the camera stands"});
    refusedRest("[[camera]]\nposition = [0, 0, 2]\ntarget = [0, 0, 1]\n", "s.toml:15:1", {"along its own 'up'"});
    refusedRest("[camera]\nposition = [0, 0, 2]\n", "s.toml:13:", {"[[camera]], with two brackets"});
}

TEST_F(Glass, ABodyWhoseEdgesAreAllSharpHasFlatFaces) {
    const std::string corners = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n";
    const std::vector<std::vector<int>> quads{{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5},
                                              {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}};
    std::string plain = corners, rounded = corners;
    for (int i = 0; i < 8; ++i)
        rounded += fmt::format("vn {} {} {}\n", (i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1);
    for (const auto& q : quads) {
        plain += fmt::format("f {} {} {} {}\n", q[0], q[1], q[2], q[3]);
        rounded += fmt::format("f {0}//{0} {1}//{1} {2}//{2} {3}//{3}\n", q[0], q[1], q[2], q[3]);
    }
    write("cube.obj", plain), write("rounded.obj", rounded);
    // A prism of twelve sides: its edges are no sharper than 30 degrees.
    std::string barrel;
    for (int i = 0; i < 24; ++i)
        barrel += fmt::format("v {} {} {}\n", std::cos(i / 2 * M_PI / 6), std::sin(i / 2 * M_PI / 6), i % 2);
    for (int i = 0; i < 12; ++i) {
        const int a = 2 * i + 1, b = 2 * ((i + 1) % 12) + 1;
        barrel += fmt::format("f {} {} {} {}\n", a, b, b + 1, a + 1);
    }
    write("barrel.obj", barrel);
    const auto smooth = [&](const std::string& file, const std::string& keys = "") {
        SceneText text;
        text.surface = "[[surface]]\nkind = \"mesh\"\nfile = \"" + file + "\"\nevent = \"mirror\"\n" + keys;
        return load(text).surfaces[0].smooth;
    };
    EXPECT_FALSE(smooth("cube.obj"));
    EXPECT_TRUE(smooth("cube.obj", "smooth = true\n"));
    EXPECT_TRUE(smooth("rounded.obj")) << "its normals say so";
    EXPECT_FALSE(smooth("rounded.obj", "smooth = false\n"));
    EXPECT_TRUE(smooth("barrel.obj"));
    SceneText text;
    text.surface = "[[surface]]\nkind = \"mesh\"\nfile = \"cube.obj\"\nevent = \"mirror\"\n";
    const Scene scene = load(text);
    for (const auto& t : scene.surfaces[0].mesh->triangles)
        for (const auto corner : t)
            EXPECT_NEAR(std::fabs(scene.surfaces[0].mesh->normals[corner].x) +
                            std::fabs(scene.surfaces[0].mesh->normals[corner].y) +
                            std::fabs(scene.surfaces[0].mesh->normals[corner].z),
                        1, 1e-12);
}

/// A closed drum about z, of `sides` sides between z = 0 and 1; with normals that point away from its axis where asked.
std::string drum(int sides, bool round_normals) {
    std::string obj;
    for (int k = 0; k < sides; ++k)
        for (const int z : {0, 1}) {
            const double x = std::cos(2 * M_PI * k / sides), y = std::sin(2 * M_PI * k / sides);
            obj += fmt::format("v {} {} {}\nvn {} {} 0\n", x, y, z, x, y);
        }
    obj += "vn 0 0 -1\nvn 0 0 1\n";
    std::string bottom = "f", top = "f";
    const auto corner = [&](int k, int z, int normal) {
        const int vertex = 2 * (k % sides) + z + 1;
        return round_normals ? fmt::format(" {}//{}", vertex, normal ? normal : vertex) : fmt::format(" {}", vertex);
    };
    for (int k = 0; k < sides; ++k) {
        obj += "f" + corner(k, 0, 0) + corner(k + 1, 0, 0) + corner(k + 1, 1, 0) + corner(k, 1, 0) + "\n";
        bottom += corner(sides - 1 - k, 0, 2 * sides + 1), top += corner(k, 1, 2 * sides + 2);
    }
    return obj + bottom + "\n" + top + "\n";
}

TEST_F(SceneTest, EdgesOfABodyAreCreasesWhereTheyAreSharp) {
    write("fine.obj", drum(48, false)), write("coarse.obj", drum(6, false)), write("rounded.obj", drum(6, true));
    const auto load_drum = [&](const std::string& file, const std::string& keys = "") {
        SceneText text;
        text.surface = "[[surface]]\nkind = \"mesh\"\nfile = \"" + file + "\"\nevent = \"mirror\"\n" + keys;
        return load(text).surfaces[0];
    };
    // Corners that lean: neither along the axis nor away from it.
    const auto leaning = [](const Surface& surface) {
        int count = 0;
        for (const auto& t : surface.mesh->triangles)
            for (const auto corner : t) {
                const double z = std::fabs(surface.mesh->normals[corner].z);
                count += z > 0.01 && z < 0.99;
            }
        return count;
    };
    const Surface fine = load_drum("fine.obj"), rounded = load_drum("rounded.obj");
    EXPECT_TRUE(fine.smooth);
    EXPECT_TRUE(fine.closed);
    EXPECT_EQ(leaning(fine), 0);
    EXPECT_GT(leaning(load_drum("fine.obj", "smooth = true\n")), 0);
    // Its wall is round between the creases: the mean of the two sides that meet at a corner.
    for (std::size_t i = 0; i < fine.mesh->positions.size(); ++i) {
        const glm::dvec3 &n = fine.mesh->normals[i], p = fine.mesh->positions[i];
        if (std::fabs(n.z) < 0.5) {
            EXPECT_NEAR(n.x * p.x + n.y * p.y, 1, 1e-9);
        }
    }
    // Six sides are a prism, but where the file shades them as round.
    EXPECT_FALSE(load_drum("coarse.obj").smooth);
    EXPECT_TRUE(rounded.smooth);
    EXPECT_EQ(leaning(rounded), 0);
    for (std::size_t i = 0; i < rounded.mesh->positions.size(); ++i) {
        const glm::dvec3 &n = rounded.mesh->normals[i], p = rounded.mesh->positions[i];
        if (std::fabs(n.z) < 0.5) {
            EXPECT_NEAR(n.x * p.x + n.y * p.y, 1, 1e-9);
        }
    }
}

TEST_F(SceneTest, AFileThatShadesSmoothlySaysWhichEdgesAreSharp) {
    // A wall of 24 sides, 15 degrees apart, one of which is flat.
    std::string obj = drum(24, true);
    const double turn = M_PI / 24;
    const std::string round = "f 1//1 3//3 4//4 2//2\n", flat = "f 1//51 3//51 4//51 2//51\n";
    const auto at = obj.find(round);
    ASSERT_NE(at, std::string::npos);
    obj.replace(at, round.size(), fmt::format("vn {} {} 0\n", std::cos(turn), std::sin(turn)) + flat);
    write("cut.obj", obj);
    SceneText text;
    text.surface = "[[surface]]\nkind = \"mesh\"\nfile = \"cut.obj\"\nevent = \"mirror\"\n";
    const Surface surface = load(text).surfaces[0];
    int of_the_flat_side = 0;
    for (const auto& t : surface.mesh->triangles)
        for (const auto corner : t) {
            const glm::dvec3 &n = surface.mesh->normals[corner], p = surface.mesh->positions[corner];
            if (std::fabs(n.z) > 0.5) continue;
            const bool is_flat = glm::length(n - glm::dvec3(std::cos(turn), std::sin(turn), 0)) < 1e-6;
            of_the_flat_side += is_flat;
            EXPECT_NEAR(n.x * p.x + n.y * p.y, is_flat ? std::cos(turn) : 1, 1e-6);
        }
    EXPECT_EQ(of_the_flat_side, 6);
}

}  // namespace
}  // namespace photic
