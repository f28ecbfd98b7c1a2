// SPDX-License-Identifier: Apache-2.0
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;
using test::SceneText;

// SceneText: photic 1, [domain] 2..5, [[light]] 6..8, [[surface]] 9..12, the rest from 13.

class Refusals : public SceneTest {
protected:
    void refusedDomain(const std::string& keys, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.domain = "[domain]\n" + keys + "\n";
        refused(text, where, words);
    }
    void refusedLight(const std::string& keys, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.light = "[[light]]\n" + keys + "\n";
        refused(text, where, words);
    }
    void refusedRest(const std::string& rest, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.rest = rest;
        refused(text, where, words);
    }
};

TEST_F(Refusals, SyntaxAndVersion) {
    refused("photic = 1\n[domain\n", "s.toml:2:", {"not valid TOML"});
    refused("photic = 1\na = 1\na = 2\n", "s.toml:3:", {"not valid TOML"});
    refused("[domain]\n", "s.toml:1:1", {"'photic = 1'", "first line"});
    refused("photic = 2\nnew_key = 1\n", "s.toml:1:1", {"'photic' is 2", "version 1"});
    refused("photic = \"1\"\n", "s.toml:1:1", {"a string"});
    refused("photic = 1\n", "s.toml", {"no light", "[[light]]"});
    refused("photic = 1\n[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\n", "s.toml", {"no surface", "[[surface]]"});
}

TEST_F(Refusals, UnknownKeysEverywhere) {
    SceneText text;
    text.head = "photic = 1\nligth = 3\n";
    refused(text, "s.toml:2:1", {"unknown key 'ligth' in the scene", "did you mean 'light'?"});
    refusedDomain("voxel_sise = 0.1", "s.toml:3:1", {"'voxel_sise' in [domain]", "'voxel_size'"});
    refusedLight("type = \"sun\"\n  irradience = 3", "s.toml:8:3", {"'irradience' in [[light]]", "'irradiance'"});
    refusedSurface("flat = true\nior_bellow = 1.3", "s.toml:11:1", {"'ior_bellow' in [[surface]]", "'ior_below'"});
    refusedRest("[medium]\nabsorbtion = 1\n", "s.toml:14:1", {"'absorbtion' in [medium]", "'absorption'"});
    refusedRest("[[object]]\nplain = 1\n", "s.toml:14:1", {"'plain' in [[object]]", "'plane'"});
    refusedRest("[[object]]\nplane = { point = [0,0,0], norml = [0,0,1] }\n", "s.toml:14:28", {"'norml'", "'normal'"});
    refusedRest("[bake]\ntolerence = 1\n", "s.toml:14:1", {"'tolerence' in [bake]", "'tolerance'"});
    refusedRest("[bake]\nxyzzy = 1\n", "s.toml:14:1", {"known: method, grids"});
    refusedLight("type = \"sun\"\nxyzzy = 3", "s.toml:8:1",
                 {"known: name, type, direction, irradiance, angular_diameter, position, power, angle, blend, center, "
                  "size, tangent, samples"});
    refusedSurface("size = [4, 4]\nwaves = [{ amplitude = 1, wavelenght = 2 }]", "s.toml:11:27",
                   {"'wavelenght' in a wave", "'wavelength'"});
    refusedSurface("size = [4, 4]\nbump = { hight = 1 }", "s.toml:11:10", {"'hight' in 'bump'", "'height'"});
    refusedSurface("size = [4, 4]\nsea = { wind = 1 }", "s.toml:11:9", {"'wind' in 'sea'", "known: wind_speed"});
}

TEST_F(Refusals, NotBuiltYet) {
    refusedSurface("flat = true\ndispersion = 1", "s.toml:11:1", {"'dispersion' in [[surface]] is not built yet"});
    refusedRest("[bake]\nseconds = 2\n", "s.toml:14:1", {"'seconds' in [bake] is not built yet"});
    refusedSurface("file = \"a.vdb\"\nsize = [4, 4]", "s.toml:10:1", {"a.vdb' is a volume", "[[index]]"});
}

TEST_F(Refusals, Domain) {
    refusedDomain("min = [-1, -1, -1]\nmax = [1, 1, 1]\nvoxel_size = 0", "s.toml:5:1",
                  {"'voxel_size' is 0", "greater than 0 m"});
    refusedDomain("min = [-1, -1, -1]\nmax = [1, 1, 1]\nvoxel_size = -0.1", "s.toml:5:1", {"-0.1", "greater than 0"});
    refusedDomain("min = [-1, -1, -1]\nmax = [1, 1, 1]\nvoxel_size = nan", "s.toml:5:1", {"nan", "finite"});
    refusedDomain("min = [-1, -1, -1]\nmax = [1, 1, inf]\nvoxel_size = 0.1", "s.toml:4:", {"inf", "finite"});
    refusedDomain("min = [-1, -1, 0]\nmax = [1, 1, 0.3]\nvoxel_size = 0.5", "s.toml:5:1",
                  {"voxel_size 0.5 m exceeds the 0.3 m domain; use 0.15 or less"});
    refusedDomain("min = [-1, -1, 0]\nmax = [1, 1, 0.3]\nvoxel_size = 0.1\nlayer_height = 0.4", "s.toml:2:1",
                  {"0.4 m high", "0.3 m domain"});
    refusedDomain("min = [-1, 1, -1]\nmax = [1, 1, 1]", "s.toml:4:1", {"max.y is 1, min.y is 1", "empty"});
    refusedDomain("min = [-1, -1, -1]", "s.toml:2:1", {"'min' without 'max'"});
    refusedDomain("min = [-1, -1]\nmax = [1, 1, 1]", "s.toml:3:1", {"2 numbers", "must have 3"});
    refusedDomain("min = \"low\"\nmax = [1, 1, 1]", "s.toml:3:1", {"a string", "array of 3 numbers"});
    refusedDomain("voxel_size = 0.1\nresolution = 10", "s.toml:4:1", {"'voxel_size' and 'resolution'"});
    refusedDomain("resolution = 0", "s.toml:3:1", {"'resolution' is 0", "1 to"});
    refusedDomain("resolution = 12.5", "s.toml:3:1", {"a number", "an integer"});
    refusedDomain("shear = \"lights\"", "s.toml:3:1", {"unknown shear \"lights\"", "did you mean 'light'?"});
    refusedDomain("shear = [1, 2, 3]", "s.toml:3:1", {"3 numbers", "must have 2"});
    // 10^4 a side: 10^12 voxels.
    refusedDomain("min = [-1, -1, -1]\nmax = [1, 1, 1]\nvoxel_size = 0.0002", "s.toml:2:1",
                  {"10000 x 10000 x 10000", "2^38", "use voxels of 0.000308 m"});
}

TEST_F(Refusals, Lights) {
    refusedLight("direction = [0, 0, -1]", "s.toml:6:1", {"needs 'type'"});
    refusedLight("type = \"moon\"\ndirection = [0, 0, -1]", "s.toml:7:1", {"unknown type \"moon\""});
    refusedLight("type = \"sun\"", "s.toml:6:1", {"needs 'direction'"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, 0]", "s.toml:8:1", {"'direction' has no length"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, 1]", "s.toml:8:1", {"direction.z is 1", "'water'", "below 0"});
    refusedLight("type = \"sun\"\ndirection = [1, 0, 0]", "s.toml:8:1", {"upwards or level"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = -3", "s.toml:9:1",
                 {"'irradiance' is -3", "at least 0 W/m2"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = [1, 2]", "s.toml:9:1", {"2 numbers"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 0", "s.toml:9:1", {"'irradiance' is 0"});
    refusedLight("type = \"sun\"\ndirection = [0, 0, -1]\nangular_diameter = 11", "s.toml:9:1",
                 {"'angular_diameter' is 11", "0 to 10 degrees"});
    SceneText text;
    text.light = "[light]\ntype = \"sun\"\n";
    refused(text, "s.toml:6:", {"[[light]]", "two brackets"});
}

TEST_F(Refusals, SurfaceSources) {
    refusedSurface("size = [4, 4]", "s.toml:9:1", {"no source", "waves"});
    refusedSurface("size = [4, 4]\nflat = true\nwaves = []", "s.toml:", {"'waves' and 'flat'", "contradict"});
    refusedSurface("size = [4, 4]\nfile = \"a.exr\"\nbump = {}", "s.toml:12:1", {"'file' and 'bump'", "keep one"});
    refusedSurface("size = [4, 4]\nsea = { wind_speed = 5, fetch = 1 }\nheight = 1", "s.toml:", {"'sea' and 'height'"});
    refusedSurface("size = [4, 4]\nflat = false", "s.toml:11:1", {"'flat' is false"});
    refusedSurface("size = [4, 4]\nflat = true\nscale = 2", "s.toml:12:1", {"'scale'", "from a file"});
    refusedSurface("size = [4, 4]\nflat = true\ninterpolation = \"bilinear\"", "s.toml:12:1",
                   {"'interpolation'", "sampled"});
    refusedSurface("size = [4, 4]\nflat = true\nup = \"y\"", "s.toml:12:1", {"'up'", "mesh"});
    refusedSurface("size = [4, 0]\nflat = true", "s.toml:10:12", {"'size' is 0"});
    refusedSurface("flat = true\noutside = \"none\"", "s.toml:9:1", {"needs 'size'"});
    refusedSurface("waves = [{ amplitude = 1, wavelength = 1 }]\noutside = \"flat\"", "s.toml:9:1", {"needs 'size'"});
    refusedSurface("kind = \"heightfield\"", "s.toml:10:1", {"unknown kind \"heightfield\"", "height_field"});
    refusedSurface("kind = \"mesh\"", "s.toml:9:1", {"needs 'file'"});
    refusedSurface("kind = \"mesh\"\nfile = \"a.obj\"\nsize = [4, 4]", "s.toml:12:1", {"'size'", "height_field"});
    refusedSurface("flat = true\nior_below = 0", "s.toml:11:1", {"'ior_below' is 0", "0.01 to 100"});
    refusedSurface("flat = true\nior_above = inf", "s.toml:11:1", {"inf", "finite"});
    refusedSurface("flat = true\nevent = \"refracts\"", "s.toml:11:1", {"unknown event", "did you mean 'refract'?"});
    SceneText text;
    text.domain = "";
    text.surface = "[[surface]]\nflat = true\n";
    refused(text, "s.toml:5:1", {"needs 'size'", "[domain]"});
    refusedRest("[[surface]]\nname = \"water\"\nflat = true\n", "s.toml:13:1",
                {"the name 'water' is taken by s.toml:9:1"});
}

TEST_F(Refusals, WavesBumpAndSea) {
    refusedSurface("size = [4, 4]\nwaves = []", "s.toml:11:1", {"at least one"});
    refusedSurface("size = [4, 4]\nwaves = [{ wavelength = 1 }]", "s.toml:11:", {"needs 'amplitude'"});
    refusedSurface("size = [4, 4]\nwaves = [{ amplitude = 1, wavelength = 0 }]", "s.toml:11:27", {"'wavelength' is 0"});
    refusedSurface("size = [4, 4]\nwaves = [{ amplitude = 1, wavelength = 1, direction = [0, 0] }]",
                   "s.toml:11:", {"'direction' has no length", "degrees"});
    refusedSurface("size = [4, 4]\nanimate = \"shallow\"\nwaves = [{ amplitude = 1, wavelength = 1 }]", "s.toml:11:1",
                   {"unknown animate"});
    refusedSurface("bump = { height = 1, radius = 1 }", "s.toml:9:1", {"needs 'size'"});
    refusedSurface("size = [4, 4]\nbump = { radius = 1 }", "s.toml:11:1", {"needs 'height'"});
    refusedSurface("size = [4, 4]\nbump = { height = 1, radius = 0 }", "s.toml:11:22", {"'radius' is 0"});
    refusedSurface("size = [4, 4]\nbump = { height = 1, radius = 1, speed = 1, depth = 1 }",
                   "s.toml:11:", {"'speed' and 'depth'"});
    refusedSurface("size = [4, 4]\nbump = { height = 1, radius = 0.001 }",
                   "s.toml:11:", {"radius 0.001 m is too small for a pool of 4 m", "use 0.00466"});
    refusedSurface("size = [4, 4]\nbump = { height = 1, radius = 1, center = [0, 3] }",
                   "s.toml:11:", {"center.y is 3", "+-2 m"});
    refusedSurface("size = [4, 4]\noutside = \"periodic\"\nbump = { height = 1, radius = 1 }", "s.toml:11:1",
                   {"walls"});
    refusedSurface("size = [4, 4]\nsea = { fetch = 100 }", "s.toml:11:1", {"needs 'wind_speed'"});
    refusedSurface("size = [4, 4]\nsea = { wind_speed = 5, fetch = 100, shortest_wavelength = 0.01 }",
                   "s.toml:11:", {"0.01 m", "resolution of 800"});
    refusedSurface("size = [4, 4]\nsea = { wind_speed = 5, fetch = 100, resolution = 8 }",
                   "s.toml:11:", {"'resolution' is 8", "16 to 2048"});
}

TEST_F(Refusals, Media) {
    refusedRest("[medium]\nabsorption = -1\n", "s.toml:14:1", {"'absorption' is -1", "at least 0 1/m"});
    refusedRest("[medium]\nscattering = [1, nan, 1]\n", "s.toml:14:", {"nan"});
    for (const char* g : {"1", "-1", "1.5"})
        refusedRest(std::string("[medium]\nscattering = 1\nanisotropy = ") + g + "\n", "s.toml:15:1",
                    {"'anisotropy' is", "between -1 and 1"});
    refusedRest("[medium]\nabsorption = 1\nextinction = 2\n", "s.toml:15:1",
                {"'absorption' and 'extinction'", "contradict"});
    refusedRest("[medium]\nextinction = 1\nalbedo = 1.5\n", "s.toml:15:1", {"'albedo' is 1.5", "0 to 1"});
    refusedRest("[medium]\nalbedo = 0.5\n", "s.toml:13:1", {"needs 'extinction'"});
    refusedRest("[[medium]]\nabsorption = 1\n", "s.toml:13:1", {"[[medium]] needs 'name'", "[medium] for the water"});
    refusedRest("[[surface]]\nname = \"oil\"\nflat = true\nior_below = 1.5\n[medium]\nabsorption = 1\n", "s.toml:13:1",
                {"'water' (ior_below 1.333)", "'oil' (ior_below 1.5)"});
    SceneText text;
    text.surface = "[[surface]]\nflat = true\nevent = \"reflect\"\n";
    text.rest = "[medium]\nabsorption = 1\n";
    refused(text, "s.toml:12:1", {"[medium]", "reflect"});
}

TEST_F(Refusals, Objects) {
    refusedRest("[[object]]\nname = \"a\"\n", "s.toml:13:1", {"no shape", "plane"});
    refusedRest("[[object]]\nplane = { normal = [0, 0, 1] }\n", "s.toml:14:1", {"needs 'point'"});
    refusedRest("[[object]]\nplane = { point = [0, 0, 0], normal = [0, 0, 0] }\n",
                "s.toml:14:", {"'normal' has no length"});
    refusedRest("[[object]]\nplane = [0, 0, 1]\n", "s.toml:14:1", {"an array", "must be a table"});
    refusedRest("[[object]]\nbox = { min = [0, 0, 0], max = [1, 0, 1] }\n", "s.toml:14:", {"max.y is 0, min.y is 0"});
    refusedRest("[[object]]\nsphere = { center = [0, 0, 0], radius = -1 }\n", "s.toml:14:", {"'radius' is -1"});
    refusedRest("[[object]]\nsphere = { center = [0, 0, 0], radius = 1 }\nfile = \"a.obj\"\n",
                "s.toml:", {"'file' and 'sphere'"});
    refusedRest("[[object]]\nplane = { point = [0, 0, 0] }\nrole = \"reciever\"\n", "s.toml:15:1",
                {"unknown role", "did you mean 'receiver'?"});
    refusedRest("[[object]]\nplane = { point = [0, 0, 0] }\nup = \"y\"\n", "s.toml:15:1", {"'up'", "meshes"});
    refusedRest("[[object]]\nfile = \"gone.obj\"\n", "s.toml:14:1", {"gone.obj", "No such file"});
    refusedRest("[[object]]\nfile = \"a.stl\"\n", "s.toml:14:1", {"a.stl", ".obj, .ply, .gltf and .glb"});
    refusedRest(
        "[[object]]\nname = \"a\"\nplane = { point = [0, 0, 0] }\n[[object]]\nname = \"a\"\nplane = { point = [0, 0, "
        "1] }\n",
        "s.toml:16:1", {"'a' is taken by s.toml:13:1"});
}

TEST_F(Refusals, Bake) {
    refusedRest("[bake]\ngrids = []\n", "s.toml:14:1", {"'grids' is empty"});
    refusedRest("[bake]\ngrids = [\"iradiance\"]\n", "s.toml:14:1",
                {"unknown grid \"iradiance\"", "did you mean \"irradiance\"?"});
    refusedRest("[bake]\ngrids = [1]\n", "s.toml:14:", {"an integer", "array of strings"});
    refusedRest("[bake]\ngrids = [\"direction\"]\n", "s.toml:14:1", {"ask for both"});
    refusedRest("[bake]\nwhere = \"nowhere\"\n", "s.toml:14:1", {"unknown where"});
    refusedRest("[bake]\nwhere = \"media\"\n", "s.toml:14:1", {"needs a [medium]"});
    refusedRest("[bake]\nwhere = \"receivers\"\n", "s.toml:14:1", {"needs an [[object]]"});
    refusedRest("[bake]\nquadrature = 3\n", "s.toml:14:1", {"1, 2, 4, 6, 8 or 12"});
    refusedRest("[bake]\nquadrature = 13\n", "s.toml:14:1", {"'quadrature' is 13"});
    refusedRest("[bake]\ntolerance = 0\n", "s.toml:14:1", {"'tolerance' is 0"});
    refusedRest("[bake]\nband = -1\n", "s.toml:14:1", {"'band' is -1", "0 to"});
    refusedRest("[bake]\nprefilter = 1\n", "s.toml:14:1", {"true or false"});
    refusedRest("[bake]\nmethod = \"\"\n", "s.toml:14:1", {"'method' is empty"});
    refusedRest("[bake.beams]\nlist = [1]\n", "s.toml:14:1", {"'list' in [bake.beams]", "an array"});
    refusedRest("bake = 3\n", "s.toml:13:1", {"unknown key 'bake' in [[surface]]"});
    SceneText text;
    text.head = "photic = 1\nbake = 3\n";
    refused(text, "s.toml:2:1", {"[bake] is an integer", "must be a table"});
    // Options of methods that nobody has heard of are the catalogue's business.
    text = {};
    text.rest = "[bake.no_such_method]\nx = 1\n";
    EXPECT_EQ(load(text).bake.method_options.count("no_such_method"), 1u);
}

TEST_F(Refusals, SceneFile) {
    try {
        loadScene(path("gone.toml"), 0, warnings_);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Input);
        EXPECT_NE(std::string(error.what()).find("gone.toml': No such file"), std::string::npos) << error.what();
    }
    // Whatever is cut off or overwritten, the answer is a scene or an input error.
    SceneText text;
    text.surface = "[[surface]]\nsize = [2, 2]\nbump = { height = 0.1, radius = 0.3, resolution = 16 }\n";
    text.rest =
        "[medium]\nabsorption = [1, 2, 3]\n[[object]]\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] "
        "}\n[bake]\nmethod = \"beams\"\n";
    const std::string whole = text.all();
    int errors = 0;
    for (std::size_t i = 0; i < whole.size(); ++i)
        for (const char c : {'\0', '[', '"', '9', '\n'}) {
            std::string changed = c ? whole : whole.substr(0, i);
            if (c) changed[i] = c;
            try {
                load(changed);
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ErrorCode::Input);
                EXPECT_FALSE(error.where().empty()) << error.what();
                ++errors;
            }
        }
    EXPECT_GT(errors, 500);
}

TEST_F(Refusals, NumbersBeyondReach) {
    refusedDomain("min = [-1e308, 0, 0]\nmax = [1e308, 1, 1]", "s.toml:3:", {"-1e+308", "-1000000000 to 1000000000 m"});
    refusedDomain("min = [0, 0, 0]\nmax = [1, 1, 1]\nvoxel_size = 1e-5\nlayer_height = 1e-320", "s.toml:2:1",
                  {"2^38", "larger voxel_size or layer_height"});
    refusedDomain("min = [0, 0, 0]\nmax = [1, 1, 1]\nvoxel_size = 1e-5", "s.toml:2:1", {"use voxels of 0.000154 m"});
    SceneText text;
    text.domain.clear();
    text.rest = "[[object]]\nsphere = { center = [1e300, 0, 0], radius = 1 }\n";
    refused(text, "s.toml", {"the scene reaches from", "1e+300 m along x", "give [domain] min and max"});
    const std::string waves = "size = [4, 4]\nwaves = [{ amplitude = 0.01, ";
    refusedSurface(waves + "wavelength = 1e-308 }]", "s.toml:11:", {"'wavelength' is 1e-308", "1e-06"});
    refusedSurface("size = [4, 4]\nwaves = [{ amplitude = 1e308, wavelength = 0.001 }]", "s.toml:9:1",
                   {"no height or slope", "use smaller ones"});
    text = {};
    text.head = "photic = 1\nframe_rate = 1e-300\n";
    refused(text, "s.toml:2:1", {"'frame_rate' is 1e-300"});
}

TEST_F(Refusals, SunsAtTheHorizonAndLightsThatDrown) {
    refusedLight("type = \"sun\"\ndirection = [0.9, 0.3, -0.002]", "s.toml:8:1",
                 {"0.121 degrees above the horizon", "the limit is 0.25", "use a mesh"});
    refusedLight("type = \"sun\"\ndirection = [1, 0, -0.0002]", "s.toml:8:1", {"the limit is 0.25"});
    SceneText text;
    text.light = "[[light]]\ntype = \"sun\"\ndirection = [1, 0, -0.0045]\n";
    EXPECT_EQ(load(text).lights.size(), 1u);
    text.light =
        "[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1e9\n"
        "[[light]]\nname = \"moon\"\ntype = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 100\n";
    refused(text, "s.toml:10:1", {"'moon' has 1e-07 of the irradiance", "a volume of its own"});
}

// Comments and strings may hold any letter, however the strings end.
TEST_F(Refusals, LettersBeyondAsciiOutsideOfQuotes) {
    SceneText text;
    text.head =
        "photic = 1  # \u03c3 \u00e9\n\"gr\u00f6\u00dfe\" = \"\"\"a \\\"\"\" \n\u03b2\"\"\"\"\"\n'\u00f6' = "
        "'''\u03b2''\n'''\n"
        "\"x\" = \"\\\\\" # \u03b2\n";
    refused(text, "s.toml:2:1", {"unknown key 'gr\u00f6\u00dfe'"});
    refusedRest("gr\u00f6\u00dfe = 3\n", "s.toml:13:3", {"'\u00f6\u00df'", "quotes"});
    refusedRest("[bake]\nmethod = \u03b2\n", "s.toml:14:10", {"'\u03b2'", "quotes"});
    refusedRest("[[object]]\nname = \"\u00e9\", \u00fc = 1\n", "s.toml:14:13", {"'\u00fc'", "quotes"});
    refusedRest("[bake]\nmethod = \"\u00e9\n\u03b2 = 1\n", "s.toml:15:1", {"'\u03b2'"});
}

TEST_F(Refusals, TextThatIsNone) {
    refused(std::string("\xff\xfep\0h\0", 6), "", {"UTF-16", "save it as UTF-8"});
    EXPECT_EQ(load("\xef\xbb\xbf" + SceneText{}.all()).lights.size(), 1u);
    refusedRest("[[object]]\nname = \"a\\u0000b\"\nplane = { point = [0, 0, 0] }\n", "s.toml:14:1",
                {"control character \\x00 at its character 2"});
    refusedRest("[[object]]\nfile = \"a\\u001b[31m.obj\"\n", "s.toml:14:1", {"control character \\x1b"});
    refusedRest("[bake]\n\"tolerance\\u0000\" = 1\n", "s.toml:14:1",
                {"'tolerance\\x00' in [bake]", "did you mean 'tolerance'?"});
}

TEST_F(Refusals, SizesBeforeTheyAreRead) {
    std::string objects;
    for (int i = 0; i < 10001; ++i) objects += "[[object]]\nfile = \"not_there.obj\"\n";
    refusedRest(objects, "s.toml:13:", {"10001 [[object]]", "up to 10000", "one mesh"});
    write("large.toml", "photic = 1\n" + std::string(17 << 20, '#'));
    try {
        loadScene(path("large.toml"), 0, warnings_);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("a scene may have up to 16777216"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace photic
