// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <glm/vec3.hpp>

#include "bake/libraries/openvdb.h"
#include "bake/scene/crest_warnings.h"
#include "bake/scene/plausibility.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;
using test::SceneText;

/// Each warning has a scene that must bring it about, and the same one mended, which must not.
class Plausibility : public SceneTest {
protected:
    void warned(const Scene& scene, const std::vector<std::string>& words) { warned(sceneWarnings(scene), words); }
    void warned(const std::vector<std::string>& all, const std::vector<std::string>& words) {
        ASSERT_EQ(all.size(), 1u) << (all.size() > 1 ? all[1] : "nothing");
        for (const std::string& word : words)
            EXPECT_NE(all[0].find(word), std::string::npos) << word << " in: " << all[0];
    }
    void quiet(const Scene& scene) { quiet(sceneWarnings(scene)); }
    void quiet(const std::vector<std::string>& all) {
        for (const std::string& warning : all) ADD_FAILURE() << warning;
    }
    Scene loadMesh(const std::string& obj, const std::string& more = "") {
        write("m.obj", obj);
        return loadSurfaceKeys("name = \"water\"\nkind = \"mesh\"\nfile = \"m.obj\"\n" + more);
    }
};

const std::string kCorners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0.1\nv -1 1 0\n";

TEST_F(Plausibility, OrdinaryScenesAreQuiet) {
    quiet(load(SceneText{}));
    SceneText text;
    text.surface =
        "[[surface]]\nsize = [4, 4]\nwaves = [{ amplitude = 0.02, wavelength = 1.1, direction = 20 }, "
        "{ amplitude = 0.01, wavelength = 0.7, direction = 100 }]\n";
    text.rest = "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5] }\n[medium]\nabsorption = 0.1\n";
    quiet(load(text));
    quiet(loadMesh(kCorners + "f 1 2 3\nf 1 3 4\n"));
}

TEST_F(Plausibility, WaterUpsideDown) {
    // All of the mesh's 4 m2 across the beam, at 1000 W/m2.
    warned(loadMesh(kCorners + "f 3 2 1\nf 4 3 1\n"), {"100 % of the light of 'light 1' that falls on 'water' (4000 W)",
                                                       "ior_below (1.333)", "upside down", "normals up"});
    quiet(loadMesh(kCorners + "f 3 2 1\nf 4 3 1\n", "event = \"reflect\""));
    SceneText text;  // light from the water up through its surface comes from below as it should
    text.light = "[[light]]\ntype = \"sun\"\ndirection = [0, 0.1, 1]\n";
    text.surface = "[[surface]]\nkind = \"mesh\"\nfile = \"m.obj\"\n";
    write("m.obj", kCorners + "f 1 2 3\nf 1 3 4\n");
    quiet(load(text));
}

TEST_F(Plausibility, YUpFilesWithoutUp) {
    const std::string sheet = "v -1 0 1\nv 1 0 1\nv 1 0.1 -1\nv -1 0 -1\nf 1 2 3\nf 1 3 4\n";
    SceneText text;
    text.light = "[[light]]\ntype = \"sun\"\ndirection = [0, -1, -1]\n";
    text.surface = "[[surface]]\nname = \"water\"\nkind = \"mesh\"\nfile = \"m.obj\"\n";
    write("m.obj", sheet);
    warned(load(text), {"'water' stands upright", "99.9 % of its area faces along y", "up = \"y\""});
    text.surface += "up = \"y\"\n";
    quiet(load(text));
}

TEST_F(Plausibility, AnIndexBesideTheWater) {
    openvdb::initialize();
    const auto withIndexAt = [&](const openvdb::Vec3d& place) {
        auto grid = openvdb::FloatGrid::create(1.333f);
        grid->setName("n");
        grid->fill(openvdb::CoordBBox({0, 0, 0}, {9, 9, 9}), 1.4f, true);
        auto transform = openvdb::math::Transform::createLinearTransform(0.1);
        transform->postTranslate(place);
        grid->setTransform(transform);
        openvdb::io::File file(path("n.vdb"));
        file.write({grid});
        file.close();
        SceneText text;
        text.rest = "[[index]]\nfile = \"n.vdb\"\n";
        return load(text);
    };
    quiet(withIndexAt({-0.5, -0.5, -1.5}));
    warned(withIndexAt({-0.5, 5, -1.5}),
           {"nothing of the [[index]] lies in the water", "(-0.5, 5, -1.5) to (0.4, 5.9, -0.6)"});
    warned(withIndexAt({-0.5, -0.5, 0.05}), {"nothing of the [[index]]"});
    warned(withIndexAt({0.95, 0.55, -1.5}), {"only 5 %"});
    SceneText text;
    text.rest = "[[index]]\nlayers = [{ z = 0, n = 1.333 }, { z = -1.5, n = 1.36 }]\n";
    quiet(load(text));
}

TEST_F(Plausibility, ADomainThatHoldsNothing) {
    SceneText text;
    text.domain = "[domain]\nmin = [-1, -1, 0.5]\nmax = [1, 1, 2]\nvoxel_size = 0.1\n";
    warned(load(text), {"0 % of the domain lies below 'water'", "z = 0.5 m", "lower min.z"});
    text.surface += "event = \"reflect\"\n";
    quiet(load(text));
    text.domain = "[domain]\nmin = [-1, -1, -2]\nmax = [1, 1, -0.5]\nvoxel_size = 0.1\n";
    warned(load(text), {"0 % of the domain lies above 'water'", "raise max.z"});

    SceneText pool;
    pool.rest = "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -2.5] }\n";
    warned(load(pool), {"0 % of the receiver 'floor' lies in the domain", "(-1, -1, -2) to (1, 1, 0.5)"});
    pool.rest = "[[object]]\nname = \"ball\"\nsphere = { center = [3, 0, -1], radius = 0.5 }\n";
    warned(load(pool), {"0 % of the receiver 'ball'"});
    pool.rest += "role = \"blocker\"\n";
    quiet(load(pool));
}

TEST_F(Plausibility, WavesFinerThanVoxels) {
    const auto waves = [&](double wavelength) {
        return loadSurfaceKeys("size = [4, 4]\nname = \"water\"\nwaves = [{ amplitude = 0.002, wavelength = " +
                               std::to_string(wavelength) + ", direction = 30 }]");
    };
    warned(waves(0.3), {"slopes of 'water'", "voxels of 0.1 m", "use voxel_size = 0.025"});
    warned(waves(0.05), {"voxels of 0.1 m"});
    quiet(waves(0.8));
}

TEST_F(Plausibility, LightThatIsReflectedTotally) {
    SceneText text;
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [1, 0, -1]\n";
    text.surface = "[[surface]]\nname = \"pane\"\nflat = true\nsize = [4, 4]\nior_above = 1.5\nior_below = 1\n";
    warned(load(text), {"100 % of the light of 'low'", "reflected totally at 'pane'", "from 1.5 to 1"});
    text.light = "[[light]]\ntype = \"sun\"\ndirection = [0.5, 0, -1]\n";
    quiet(load(text));
}

// A sine whose slope is 1.7 times the light's own: over whole waves, what falls on faces that look at the light exceeds
// what the beam holds by 1.1378, and that part, 12.1 %, lies in shadow.
TEST_F(Plausibility, WavesThatShadeEachOther) {
    SceneText text;
    text.domain = "[domain]\nmin = [-1.4, -1, -2]\nmax = [1.4, 1, 0.5]\nvoxel_size = 0.05\n";
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [3.382, 0, -1]\n";
    text.surface =
        "[[surface]]\nname = \"water\"\nsize = [9, 9]\nwaves = [{ amplitude = 0.056, wavelength = 0.7, "
        "direction = 0 }]\n";
    warned(crestWarnings(load(text)), {" % of the light of 'low' on 'water'", "falls behind a crest", "follows rays"});
    quiet(load(text));  // only some methods do not know such shadows
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [1.9, 0, -1]\n";
    quiet(crestWarnings(load(text)));
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [0, 3.382, -1]\n";  // along the crests
    quiet(crestWarnings(load(text)));
}

TEST_F(Plausibility, WallsWithoutAnEnd) {
    SceneText text;
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [1, 0, -1]\n";
    const auto wall = [](const std::string& name, const std::string& rest) {
        return "[[object]]\nname = \"" + name + "\"\nplane = " + rest + "\n";
    };
    const std::string floor = wall("floor", "{ point = [0, 0, -1.5] }"),
                      east = wall("east", "{ point = [0.5, 0, 0], normal = [-1, 0, 0] }"),
                      west = wall("west", "{ point = [-0.5, 0, 0], normal = [1, 0, 0] }"),
                      south = wall("south", "{ point = [0, -0.5, 0], normal = [0, 1, 0] }"),
                      movable = "role = \"movable\"\n";
    // Behind the western wall, as the sun sees it, lie three quarters of the 4 m2, which take 2828 W.
    text.rest = floor + east + west;
    warned(load(text), {"75.1 % of the light of 'low' on 'water' (2124 W", "by 'west'", "walls that end"});
    text.rest = floor + east + movable + west + movable;
    quiet(load(text));
    text.rest = floor + east;  // which the light falls on: what lies behind it is dark, as it should be
    quiet(load(text));
    text.rest = floor + east + west + south;
    text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [1, 1, -1]\n";
    warned(load(text), {"'west'", "'south'"});
}

/// A sheet of waves 4 m wide times `scale`, of 16 x 16 quads, with the normals that `normal` gives for its slope.
std::string wavySheet(double scale, const std::function<glm::dvec3(double)>& normal = nullptr) {
    constexpr int kSide = 16;
    std::string text;
    for (int j = 0; j <= kSide; ++j)
        for (int i = 0; i <= kSide; ++i) {
            const double x = 4.0 * i / kSide - 2, y = 4.0 * j / kSide - 2;
            text += fmt::format("v {} {} {}\n", scale * x, scale * y, scale * 0.05 * std::sin(2 * x));
            const glm::dvec3 n = normal ? normal(0.1 * std::cos(2 * x)) : glm::dvec3(0);
            if (normal) text += fmt::format("vn {} {} {}\n", n.x, n.y, n.z);
        }
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
            const int a = j * (kSide + 1) + i + 1, b = a + kSide + 1;
            text += normal ? fmt::format("f {0}//{0} {1}//{1} {2}//{2} {3}//{3}\n", a, a + 1, b + 1, b)
                           : fmt::format("f {} {} {} {}\n", a, a + 1, b + 1, b);
        }
    return text;
}

TEST_F(Plausibility, WaterInOtherUnits) {
    quiet(loadMesh(wavySheet(1)));
    warned(loadMesh(wavySheet(100)),
           {"the water 'water' is 400 x 400 x 9.97 m large", "a domain of 2 x 2 x 2.5 m", "centimetres: 0.01"});
    quiet(loadMesh(wavySheet(100), "scale = 0.01\n"));
    quiet(loadMesh(wavySheet(20)));  // a large sea
    warned(loadMesh(wavySheet(0.001)), {"the water 'water' is 0.004 x 0.004", "next to no light", "larger scale"});
    quiet(loadMesh(wavySheet(0.001), "event = \"mirror\"\n"));  // a small mirror
}

TEST_F(Plausibility, ObjectsInOtherUnits) {
    const auto ball = [&](double radius, const std::string& role) {
        SceneText text;
        text.rest = fmt::format(
            "[[object]]\nname = \"ball\"\nrole = \"{}\"\nsphere = {{ center = [0, 0, -1], "
            "radius = {} }}\n",
            role, radius);
        return load(text);
    };
    quiet(ball(0.3, "receiver"));
    warned(ball(0.04, "receiver"), {"the receiver 'ball' is 0.08 x 0.08 x 0.08 m", "a voxel of 0.1 m"});
    quiet(ball(0.04, "blocker"));
    warned(ball(30, "receiver"), {"the object 'ball' is 60 x 60 x 60 m", "a domain of 2 x 2 x 2.5 m", "centimetres"});
    SceneText wide;  // a floor
    wide.rest = "[[object]]\nname = \"floor\"\nbox = { min = [-90, -90, -1.7], max = [90, 90, -1.5] }\n";
    quiet(load(wide));
}

TEST_F(Plausibility, NormalsOfAnotherShape) {
    quiet(loadMesh(wavySheet(1, [](double slope) { return glm::dvec3(-slope, 0, 1); })));
    // As they were before the waves: off by the slopes, 0.1 / sqrt(2) on the whole, which is 4 degrees.
    warned(loadMesh(wavySheet(1, [](double) { return glm::dvec3(0, 0, 1); })),
           {"the normals in the file of 'water'", "lean by 4.", "without normals"});
    warned(loadMesh(wavySheet(1, [](double slope) { return glm::dvec3(slope, 0, -1); })), {"degrees"});
    quiet(loadMesh(wavySheet(1, [](double) { return glm::dvec3(0, 0, 1); }), "smooth = false\n"));
}

TEST_F(Plausibility, WaterThatBendsNothing) {
    warned(loadSurfaceKeys("name = \"water\"\nsize = [4, 4]\nflat = true\nior_below = 1\n"),
           {"'water' bends no light", "its index is 1 on both sides", "1.333"});
    quiet(loadSurfaceKeys("size = [4, 4]\nflat = true\nior_below = 1.0001\n"));
    quiet(loadSurfaceKeys("size = [4, 4]\nflat = true\nior_below = 1\nevent = \"mirror\"\n"));
}

TEST_F(Plausibility, TwoSurfacesInOnePlace) {
    write("m.obj", wavySheet(1));
    SceneText text;
    text.surface =
        "[[surface]]\nname = \"water\"\nkind = \"mesh\"\nfile = \"m.obj\"\n"
        "[[surface]]\nname = \"again\"\nkind = \"mesh\"\nfile = \"m.obj\"\n";
    warned(load(text), {"'again' lies exactly where 'water' does", "512 triangles", "bent twice"});
    text.surface += "position = [0, 0, -0.1]\n";
    quiet(load(text));
}

// A sun at 45 degrees runs 0.6253 m for each metre in water; the patch covers the domain and no more. Of the water in
// the domain, 2 m deep, the light of the part 0.6253 z / 2 on the average comes in beside it: 0.3127.
TEST_F(Plausibility, WavesThatEndBeforeTheLight) {
    const auto waves = [&](const std::string& size, const std::string& more) {
        SceneText text;
        text.light = "[[light]]\nname = \"low\"\ntype = \"sun\"\ndirection = [1, 0, -1]\n";
        text.surface = "[[surface]]\nname = \"water\"\nsize = " + size + "\n" + more;
        return load(text);
    };
    const std::string sine = "waves = [{ amplitude = 0.02, wavelength = 1.1, direction = 20 }]\n";
    warned(waves("[2, 2]", sine),
           {"31.3 % of the water in the domain", "'low'", "patch of 'water'", "2 x 2 m", "make the patch 4.7 x 2.1 m"});
    quiet(waves("[4.7, 2.1]", sine));
    warned(waves("[2, 2]", sine + "center = [500000, 4649776, 0]\n"),
           {"no light that comes into the domain passes the waves of 'water'", "(500000, 4.64978e+06)", "move it"});
    quiet(waves("[2, 2]", sine + "outside = \"periodic\"\n"));
    quiet(waves("[2, 2]", "flat = true\n"));
    quiet(waves("[2, 2]", "bump = { height = 0.02, radius = 0.22 }\n"));  // at rest at its rim
}

}  // namespace
}  // namespace photic
