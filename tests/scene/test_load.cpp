// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "bake/scene/mesh_file.h"
#include "tests/scene/scene_texts.h"
#include "tests/scene/surface_checks.h"

namespace photic {
namespace {

using test::SceneTest;
using test::SceneText;

TEST_F(SceneTest, ReadsTheWholeSchema) {
    const Scene scene = load(R"(photic = 1
[domain]
min = [-1.0, -1.0, -1.6]
max = [ 1.0,  1.0,  0.1]
voxel_size = 0.0078125
shear = [0.25, -0.5]
layer_height = 0.03125
[[light]]
name = "sun"
type = "sun"
direction = [0.866, 0.5, -1.732]
irradiance = [1000.0, 900, 800]
angular_diameter = 2
[[light]]
type = "sun"
direction = [0, 0, -7]
irradiance = [1, 200, 3]
[[surface]]
name = "water"
kind = "height_field"
waves = [{ amplitude = 0.1, wavelength = 2, direction = [0, 3], phase = 0.5 }, { amplitude = 0.05, wavelength = 1, direction = 90 }]
size = [4.0, 3.0]
center = [0.5, 0.25, -0.125]
outside = "none"
event = "both"
ior_above = 1.1
ior_below = 1.4
[medium]
absorption = [0.35, 0.07, 0.02]
scattering = 0.05
anisotropy = 0.8
[[object]]
name = "floor"
plane = { point = [0, 0, -1.5], normal = [0, 0, 2] }
[[object]]
name = "ball"
sphere = { center = [0, 0, -1], radius = 0.25 }
role = "movable"
[[object]]
box = { min = [-0.5, -0.5, -1.5], max = [0.5, 0, -1.25] }
role = "blocker"
[bake]
method = "photons"
grids = ["irradiance", "caustic"]
where = "receivers"
band = 3
paths = "all"
quadrature = 4
tolerance = 0.5
prefilter = true
[bake.photons]
paths = 1000
spacing = 0.5
sequence = "sobol"
random = false
)");
    EXPECT_EQ(scene.file, "s.toml");
    EXPECT_EQ(scene.domain.min, glm::dvec3(-1, -1, -1.6));
    EXPECT_EQ(scene.domain.max, glm::dvec3(1, 1, 0.1));
    EXPECT_EQ(scene.domain.voxel_size, 0.0078125);
    EXPECT_EQ(scene.domain.shear_mode, ShearMode::Explicit);
    EXPECT_EQ(scene.domain.shear, glm::dvec2(0.25, -0.5));
    EXPECT_EQ(scene.domain.layer_height, 0.03125);

    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_NEAR(glm::length(scene.lights[0].direction - glm::dvec3(0.4330127, 0.25, -0.8660254)), 0, 1e-4);
    EXPECT_EQ(scene.lights[0].irradiance, glm::dvec3(1000, 900, 800));
    EXPECT_EQ(scene.lights[0].angular_diameter_deg, 2);
    EXPECT_EQ(scene.lights[1].direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(scene.lights[1].angular_diameter_deg, 0.53);
    EXPECT_EQ(scene.lights[1].name, "light 2");
    EXPECT_TRUE(scene.coloured());
    EXPECT_EQ(scene.referenceIrradiance(), 1100);

    const Surface& water = scene.surfaces.at(0);
    EXPECT_EQ(water.where, "s.toml:18:1");
    EXPECT_EQ(water.outside, Outside::None);
    EXPECT_EQ(water.event, SurfaceEvent::Both);
    EXPECT_EQ(water.ior_above, 1.1);
    EXPECT_EQ(water.ior_below, 1.4);
    EXPECT_EQ(water.size, glm::dvec2(4, 3));
    const double z =
        -0.125 + 0.1 * std::sin(std::numbers::pi * 0.5 + 0.5) + 0.05 * std::sin(2 * std::numbers::pi * 0.5);
    EXPECT_NEAR(water.height_field->at({0.9, 0.75}).position.z, z, 1e-14);
    EXPECT_EQ(water.height_field->at({0.9, 1.8}).position.z, -0.125);

    EXPECT_EQ(scene.medium.absorption, glm::dvec3(0.35, 0.07, 0.02));
    EXPECT_EQ(scene.medium.scattering, glm::dvec3(0.05));
    EXPECT_EQ(scene.medium.anisotropy, 0.8);

    ASSERT_EQ(scene.objects.size(), 3u);
    EXPECT_EQ(std::get<Plane>(scene.objects[0].shape).normal, glm::dvec3(0, 0, 1));
    EXPECT_EQ(scene.objects[0].role, Role::Receiver);
    EXPECT_EQ(scene.objects[0].where.substr(0, 10), "s.toml:32:");
    EXPECT_EQ(scene.objects[1].role, Role::Movable);
    EXPECT_EQ(scene.objects[2].role, Role::Blocker);
    EXPECT_EQ(scene.objects[2].name, "object 3");
    EXPECT_EQ(std::get<std::shared_ptr<const TriangleMesh>>(scene.objects[2].shape)->triangles.size(), 12u);

    const BakeSettings& bake = scene.bake;
    EXPECT_EQ(bake.method, "photons");
    EXPECT_TRUE(bake.grids.irradiance && bake.grids.caustic && bake.grids.density);
    EXPECT_FALSE(bake.grids.direction || bake.grids.arrival_time);
    EXPECT_EQ(bake.where, Where::Receivers);
    EXPECT_EQ(bake.band, 3);
    EXPECT_EQ(bake.paths, Paths::All);
    EXPECT_EQ(bake.quadrature, 4);
    EXPECT_EQ(bake.tolerance, 0.5);
    EXPECT_TRUE(bake.prefilter);
    const GivenOptions& options = bake.method_options.at("photons");
    EXPECT_EQ(std::get<std::int64_t>(options.at("paths").value), 1000);
    EXPECT_EQ(std::get<double>(options.at("spacing").value), 0.5);
    EXPECT_EQ(std::get<std::string>(options.at("sequence").value), "sobol");
    EXPECT_EQ(std::get<bool>(options.at("random").value), false);
    EXPECT_EQ(options.at("paths").where, "s.toml:52:1");
    EXPECT_TRUE(warnings_.messages.empty());
}

TEST_F(SceneTest, DefaultsAreThoseOfTheDocument) {
    const Scene scene = load(SceneText());
    EXPECT_EQ(scene.lights[0].irradiance, glm::dvec3(1000));
    EXPECT_EQ(scene.lights[0].angular_diameter_deg, 0.53);
    EXPECT_EQ(scene.surfaces[0].ior_below, 1.333);
    EXPECT_EQ(scene.surfaces[0].outside, Outside::Flat);
    EXPECT_EQ(scene.surfaces[0].event, SurfaceEvent::Refract);
    EXPECT_EQ(scene.domain.shear_mode, ShearMode::None);
    EXPECT_FALSE(scene.coloured());
    EXPECT_FALSE(scene.medium.present());
    EXPECT_TRUE(scene.bake.grids.irradiance && scene.bake.grids.direction);
    EXPECT_FALSE(scene.bake.grids.density);
    EXPECT_EQ(scene.bake.method, "auto");
    EXPECT_EQ(scene.bake.quadrature, 0) << "chosen by the slant of the light";
    EXPECT_EQ(scene.bake.tolerance, 0.25);
}

TEST_F(SceneTest, ResolutionIsAlongTheLongestSide) {
    SceneText text;
    text.domain = "[domain]\nmin = [-1, -1, -2]\nmax = [1, 3, 0.5]\nresolution = 200\nshear = \"light\"\n";
    const Scene scene = load(text);
    EXPECT_DOUBLE_EQ(scene.domain.voxel_size, 0.02);
    EXPECT_EQ(scene.domain.shear_mode, ShearMode::Light);
}

TEST_F(SceneTest, AbsentDomainIsTheScenesBoundsAndTwoVoxels) {
    SceneText text;
    text.domain = "";
    text.surface = "[[surface]]\nsize = [4, 2]\nwaves = [{ amplitude = 0.25, wavelength = 1 }]\n";
    text.rest =
        "[[object]]\nplane = { point = [50, 60, -3] }\n"
        "[[object]]\nplane = { point = [3, 0, 0], normal = [-1, 0, 0] }\n"
        "[[object]]\nbox = { min = [0, 0, -1], max = [1, 1.5, -0.5] }\n"
        "[[object]]\nbox = { min = [8, 8, -9], max = [9, 9, 9] }\nrole = \"blocker\"\n";
    // Bounds: x -2..3 (the wall), y -1..1.5 (the box), z -3 (the floor)..0.25 (a crest); blockers do not count.
    const double h = 5.0 / 128;
    const Domain domain = load(text).domain;
    EXPECT_DOUBLE_EQ(domain.voxel_size, h);
    EXPECT_NEAR(glm::length(domain.min - glm::dvec3(-2 - 2 * h, -1 - 2 * h, -3 - 2 * h)), 0, 1e-12);
    EXPECT_NEAR(glm::length(domain.max - glm::dvec3(3 + 2 * h, 1.5 + 2 * h, 0.25 + 2 * h)), 0, 1e-12);

    // With a size of its own, and a tilted floor: z = -3 + x reaches from -5 to -1 over x in -2..2.
    text.domain = "[domain]\nvoxel_size = 0.1\n";
    text.rest = "[[object]]\nplane = { point = [0, 0, -3], normal = [-0.5, 0, 0.5] }\n";
    EXPECT_NEAR(load(text).domain.min.z, -3 - 2 - 0.2, 1e-12);
    EXPECT_NEAR(load(text).domain.max.x, 2.2, 1e-12);
}

TEST_F(SceneTest, ADomainThatFitsTheLight) {
    SceneText text;
    const auto box = [&](const std::string& surface, const std::string& rest) {
        text.domain = "[domain]\nresolution = 100\nfit = \"light\"\n";
        text.surface = surface, text.rest = rest;
        const Domain domain = load(text).domain;
        // Without its margin of three voxels.
        return std::pair(domain.min + 3 * domain.voxel_size, domain.max - 3 * domain.voxel_size);
    };
    const auto is = [](const std::pair<glm::dvec3, glm::dvec3>& found, const glm::dvec3& min, const glm::dvec3& max) {
        EXPECT_NEAR(glm::length(found.first - min), 0, 1e-9)
            << found.first.x << " " << found.first.y << " " << found.first.z;
        EXPECT_NEAR(glm::length(found.second - max), 0, 1e-9)
            << found.second.x << " " << found.second.y << " " << found.second.z;
    };
    // Wide water over a pool: the pool. A fish in it does not crop, and light goes down to it; a blocker is nothing.
    const std::string water = "[[surface]]\nsize = [8, 8]\nwaves = [{ amplitude = 0.25, wavelength = 1 }]\n";
    const std::string pool = "[[object]]\nbox = { min = [-1, -2, -3], max = [1, 2, -2.5] }\n",
                      fish = "[[object]]\nbox = { min = [8, 8, -9], max = [9, 9, 9] }\nrole = ",
                      floor = "[[object]]\nplane = { point = [0, 0, -3] }\n";
    is(box(water, pool), {-1, -2, -3}, {1, 2, 0.25});
    is(box(water, pool + fish + "\"blocker\"\n"), {-1, -2, -3}, {1, 2, 0.25});
    is(box(water, pool + fish + "\"movable\"\n"), {-1, -2, -9}, {1, 2, 0.25});
    is(box(water, fish + "\"movable\"\n"), {-4, -4, -9}, {4, 4, 0.25});
    is(box(water, pool + floor), {-4, -4, -3}, {4, 4, 0.25});
    is(box(water, pool + "[medium]\nabsorption = 0.1\n"), {-4, -4, -3}, {4, 4, 0.25});  // it is seen from beside
    // Glass over a wide floor: as far as its shadow, of a sun and of a lamp.
    const std::string glass = "[[surface]]\nkind = \"sphere\"\nposition = [0, 0, 0]\nradius = 1\ninside = \"glass\"\n",
                      medium = "[[medium]]\nname = \"glass\"\nior = 1.5\n";
    text.light = "[[light]]\ntype = \"sun\"\ndirection = [1, 0, -2]\n";
    is(box(glass, floor + medium), {-1, -1, -3}, {1 + 2, 1, 1});
    text.light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 3]\npower = 1\n";
    is(box(glass, floor + medium), {-1 - 2, -1 - 2, -3}, {1 + 2, 1 + 2, 1});
    // A mirror's light goes anywhere, up to twice its size.
    const std::string room = "[[object]]\nbox = { min = [-2, -30, -1.5], max = [3, 30, 9] }\n";
    is(box("[[surface]]\nkind = \"sphere\"\nposition = [0, 0, 0]\nradius = 1\nevent = \"mirror\"\n", room),
       {-2.25, -5, -1.5}, {3, 5, 5});
    // So does that of a lamp in the water: to the ceiling, where there is one, and not to one out of reach.
    const std::string ceiling = "[[object]]\nplane = { point = [0, 0, 5], normal = [0, 0, -1] }\n",
                      sky = "[[object]]\nplane = { point = [0, 0, 50], normal = [0, 0, -1] }\n";
    text.light = "[[light]]\ntype = \"point\"\nposition = [0, 0, -2]\npower = 1\n";
    is(box(water, floor + ceiling), {-4, -4, -3}, {4, 4, 5});
    is(box(water, floor + sky), {-4, -4, -3}, {4, 4, 0.25 + 2 * 8});
    text.light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 2]\npower = 1\n";
    is(box(water, floor + ceiling), {-4, -4, -3}, {4, 4, 0.25});
    text.domain = "[domain]\nresolution = 100\nfit = \"light\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n";
    EXPECT_THROW(load(text), Error);
}

TEST_F(SceneTest, SurfacesWithoutSizeCoverTheDomain) {
    const Scene scene = loadSurfaceKeys("waves = [{ amplitude = 0.1, wavelength = 1 }]\ncenter = [0.5, 0, 0]");
    EXPECT_EQ(scene.surfaces[0].outside, Outside::Periodic);
    EXPECT_EQ(scene.surfaces[0].size, glm::dvec2(3, 2));
    EXPECT_NEAR(scene.surfaces[0].height_field->at({1000.75, 0}).position.z, 0.1, 1e-9);
    EXPECT_EQ(loadSurfaceKeys("height = -0.25").surfaces[0].height_field->minZ(), -0.25);
    EXPECT_EQ(loadSurfaceKeys("flat = true\nheight = 0.5\ncenter = [0, 0, 1]").surfaces[0].center.z, 1.5);
}

TEST_F(SceneTest, WavesMoveOnlyWhenAsked) {
    const std::string still = "size = [4, 4]\nwaves = [{ amplitude = 0.1, wavelength = 2 }]";
    EXPECT_EQ(loadSurfaceKeys(still, 0).surfaces[0].height_field->at({0.3, 0}).position.z,
              loadSurfaceKeys(still, 9).surfaces[0].height_field->at({0.3, 0}).position.z);
    EXPECT_EQ(loadSurfaceKeys(still, 0).hash, loadSurfaceKeys(still, 9).hash);

    // 0.5 m/s along +x: after 24 frames of 1/24 s the pattern is 0.5 m further.
    const std::string moving = "size = [4, 4]\nwaves = [{ amplitude = 0.1, wavelength = 2, speed = 0.5 }]";
    const auto z = [](const Scene& scene, double x) { return scene.surfaces[0].height_field->at({x, 0}).position.z; };
    EXPECT_NEAR(z(loadSurfaceKeys(moving, 24), 0.8), z(loadSurfaceKeys(moving, 0), 0.3), 1e-14);
    EXPECT_NEAR(z(loadSurfaceKeys(moving + "\nframe_rate = 12", 24), 1.3), z(loadSurfaceKeys(moving, 0), 0.3), 1e-14);
    EXPECT_NE(loadSurfaceKeys(moving, 0).hash, loadSurfaceKeys(moving, 24).hash);

    // Deep water: speed sqrt(g / k).
    const std::string deep = "size = [4, 4]\nanimate = \"deep_water\"\nwaves = [{ amplitude = 0.1, wavelength = 2 }]";
    const double speed = std::sqrt(9.81 / std::numbers::pi);
    EXPECT_NEAR(z(loadSurfaceKeys(deep, 12), 0.3 + 0.5 * speed), z(loadSurfaceKeys(deep, 0), 0.3), 1e-13);
}

TEST_F(SceneTest, MediumAsExtinctionAndAlbedo) {
    SceneText text;
    text.rest = "[medium]\nextinction = [0.5, 1, 2]\nalbedo = 0.25\n";
    const Medium medium = load(text).medium;
    EXPECT_EQ(medium.scattering, glm::dvec3(0.125, 0.25, 0.5));
    EXPECT_EQ(medium.extinction(), glm::dvec3(0.5, 1, 2));
    text.rest = "[medium]\nabsorption = 1\nanisotropy = 0.5\n";
    EXPECT_EQ(load(text).medium.absorption, glm::dvec3(1));
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("no effect without scattering"), std::string::npos);
}

TEST_F(SceneTest, HashFollowsEveryFile) {
    write("a.obj", "v 0 0 -1\nv 1 0 -1\nv 0 1 -1\nf 1 2 3\n");
    SceneText text;
    text.rest = "[[object]]\nfile = \"a.obj\"\n";
    const std::uint64_t before = load(text).hash;
    EXPECT_EQ(load(text, 5).hash, before);
    write("a.obj", "v 0 0 -1\nv 1 0 -1\nv 0 1 -1.5\nf 1 2 3\n");
    EXPECT_NE(load(text).hash, before);
}

TEST_F(SceneTest, HashIsOfWhatTheFileMeans) {
    const auto hash = [&](const std::string& head, const std::string& rest) {
        SceneText text;
        text.head = head, text.rest = rest;
        return load(text).hash;
    };
    const std::string head = "photic = 1\n";
    const std::uint64_t before = hash(head, "[medium]\nabsorption = 1\nscattering = 2\n");
    EXPECT_EQ(hash("photic = 1 # a comment\r\n", "[medium]\r\nscattering   = 2.0\r\nabsorption = 1e0\r\n"), before);
    EXPECT_EQ(hash(head, "[medium]\nabsorption = 1\nscattering = 2\n[bake]\nband = 3\n"), before)
        << "what is used of [bake] is hashed with the settings of the bake";
    EXPECT_NE(hash(head, "[medium]\nabsorption = 1\nscattering = 2.5\n"), before);
    EXPECT_NE(hash(head, "[medium]\nabsorption = 2\nscattering = 1\n"), before);
    EXPECT_NE(hash(head, "[medium]\nabsorption = 1\nscattering = 2\nanisotropy = 0.5\n"), before);
}

TEST_F(SceneTest, LoadsFromAPathAndLooksBesideIt) {
    write("floor.obj", "v 0 0 -1\nv 1 0 -1\nv 0 1 -1\nf 1 2 3\n");
    SceneText text;
    text.rest = "[[object]]\nfile = \"floor.obj\"\n";
    write("scene.toml", text.all());
    const Scene scene = loadScene(path("scene.toml"), 3, warnings_);
    EXPECT_EQ(scene.file, path("scene.toml"));
    EXPECT_EQ(scene.frame, 3);
    EXPECT_EQ(scene.objects[0].where, path("scene.toml") + ":13:1");
}

TEST(NearestName, FindsTyposAndLeavesStrangersAlone) {
    const std::vector<std::string> known{"voxel_size", "resolution", "shear", "min", "max"};
    EXPECT_EQ(nearestName("voxelsize", known), "voxel_size");
    EXPECT_EQ(nearestName("resolutoin", known), "resolution");
    EXPECT_EQ(nearestName("mim", known), "min");
    EXPECT_EQ(nearestName("temperature", known), "");
    EXPECT_EQ(nearestName("", known), "");
}

TEST(Scene, ReferenceIrradianceIsThatOfTheStrongestChannel) {
    Scene scene;
    EXPECT_EQ(scene.referenceIrradiance(), 1);
    scene.lights.resize(2);
    scene.lights[0].irradiance = {1, 5, 2}, scene.lights[1].irradiance = {4, 0.5, 2};
    EXPECT_EQ(scene.referenceIrradiance(), 5.5);
    EXPECT_TRUE(scene.coloured());
}

}  // namespace
}  // namespace photic
