// SPDX-License-Identifier: Apache-2.0
// A scene's text with its lights elsewhere is that scene with its lights elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/moved_light.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"(photic = 1
# Grün ist das Wasser: columns count letters, not bytes.
[domain]
min = [-1, -1, -1]
max = [1, 1, 0.1]
voxel_size = 0.1
[[light]]
name = "Sonne über dem Meer"
type = "sun"
direction = [
    0.3, # east
    0.2,
    -1,
] # behind
irradiance = 500
[[light]]
type = "spot"
position = [0, 0, 2]
direction = [0, 0, -1]
power = 40
[[surface]]
kind = "height_field"
waves = [{ amplitude = 0.01, wavelength = 1.0, direction = 0, phase = 0 }]
size = [4, 4]
)";

Scene parse(const std::string& text) {
    Monitor monitor;
    return parseScene(text, "made_up.toml", ".", 1, monitor);
}

std::ptrdiff_t lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

// The paths in quotes of a scene's text, comments left out, known by how they end.
std::vector<fs::path> namedFiles(const std::string& text) {
    static const std::set<fs::path> kEndings = {".vdb", ".ply", ".obj", ".exr", ".png", ".glb", ".csv", ".pfm"};
    std::vector<fs::path> files;
    std::istringstream all(text);
    for (std::string line; std::getline(all, line);) {
        std::istringstream parts(line.substr(0, line.find('#')));
        std::string between, quoted;
        while (std::getline(parts, between, '"') && std::getline(parts, quoted, '"'))
            if (kEndings.contains(fs::path(quoted).extension())) files.emplace_back(quoted);
    }
    return files;
}

// The text is written elsewhere: whatever names a file, under keys of today or of later, must name it from there.
TEST(MovedLight, ScenesOfTheExamplesKeepTheirFiles) {
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PHOTIC_SOURCE_DIR) / "examples")) {
        if (entry.path().extension() != ".toml" || entry.path().stem().string().ends_with("_bodies")) continue;
        std::ifstream in(entry.path());
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        const std::string edited =
            withMovedLights(text, entry.path().string(), entry.path().parent_path().string(), {});
        for (const fs::path& file : namedFiles(edited)) {
            EXPECT_TRUE(file.is_absolute()) << entry.path() << ": " << file;
            ++files;
        }
    }
    EXPECT_GT(files, 20);
    const std::string colours = withMovedLights(std::string(kScene) + R"([[medium]]
name = "glass"
index = ["red.vdb", "green.vdb", "blue.vdb"]
)",
                                                "made_up.toml", "/scenes", {});
    for (const char* name : {"red", "green", "blue"})
        EXPECT_NE(colours.find(std::string("\"/scenes/") + name + ".vdb\""), std::string::npos) << colours;
}

TEST(MovedLight, IsWhereItWasMovedTo) {
    MovedLight sun, spot;
    sun.direction = glm::dvec3(-0.125, 0, -2);
    spot.number = 1, spot.position = glm::dvec3(0.1, -0.7, 1.5), spot.direction = glm::dvec3(0, 0.5, -1);
    const std::string moved = withMovedLights(kScene, "made_up.toml", ".", {sun, spot});
    const Scene before = parse(kScene), after = parse(moved);
    EXPECT_EQ(after.lights[0].direction, glm::normalize(*sun.direction));
    EXPECT_EQ(after.lights[0].irradiance, before.lights[0].irradiance);
    EXPECT_EQ(after.lights[0].name, before.lights[0].name);
    EXPECT_EQ(*after.lights[1].position, *spot.position);
    EXPECT_EQ(after.lights[1].direction, glm::normalize(*spot.direction));
    EXPECT_EQ(lines(moved), lines(kScene)) << moved;
    EXPECT_EQ(after.surfaces[0].where, before.surfaces[0].where);
    EXPECT_NE(moved.find("# behind"), std::string::npos);
    EXPECT_EQ(withMovedLights(kScene, "made_up.toml", ".", {}), kScene);
}

TEST(MovedLight, OfARectangleIsItsCentreAndInOneLineToo) {
    const std::string text =
        "photic = 1\nlight = [{ type = \"rectangle\", center = [0, 0, 2], size = [1, 1], direction = [0, 0, -1], power "
        "= "
        "3 }]\n";
    MovedLight moved;
    moved.position = glm::dvec3(1, 2, 3);
    EXPECT_NE(withMovedLights(text, "a.toml", ".", {moved}).find("center = [1, 2, 3], size"), std::string::npos);
}

TEST(MovedLight, FindsItsFilesFromElsewhere) {
    const std::string text =
        "a = { file = \"water.####.exr\", channel = \"G\" }\n[[medium]]\nindex = 'n \"1\".vdb'\nname = "
        "\"index\"\nabsorption_volume = \"/abs.vdb\"\n";
    EXPECT_EQ(withMovedLights(text, "a.toml", "/place", {}),
              "a = { file = \"/place/water.####.exr\", channel = \"G\" }\n[[medium]]\nindex = \"/place/n "
              "\\\"1\\\".vdb\"\nname = \"index\"\nabsorption_volume = \"/abs.vdb\"\n");
}

// A key for files that is added to the schema must be added to kFileKeys too.
TEST(MovedLight, LeavesNoExampleWithAFileThatItCannotFind) {
    int scenes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(PHOTIC_EXAMPLES)) {
        if (entry.path().extension() != ".toml") continue;
        std::ifstream file(entry.path());
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        if (text.find("photic = 1") == std::string::npos) continue;
        const fs::path folder = entry.path().parent_path();
        const std::string moved = withMovedLights(text, entry.path().string(), folder.string(), {});
        for (const auto& neighbour : fs::directory_iterator(folder)) {
            const std::string name = neighbour.path().filename().string();
            EXPECT_EQ(moved.find('"' + name + '"'), std::string::npos) << entry.path() << " still names " << name;
        }
        ++scenes;
    }
    EXPECT_GT(scenes, 10);
}

TEST(MovedLight, SaysWhatItCannotMove) {
    const auto why = [](const std::string& text, const MovedLight& moved) {
        try {
            withMovedLights(text, "made_up.toml", ".", {moved});
        } catch (const Error& error) {
            return error.where() + ": " + error.what();
        }
        return std::string("nothing");
    };
    MovedLight third;
    third.number = 2;
    EXPECT_NE(why(kScene, third).find("the scene has 2"), std::string::npos);
    MovedLight sun;
    sun.position = glm::dvec3(0);
    EXPECT_NE(why(kScene, sun).find("made_up.toml:7:1: light 1 has no 'position'"), std::string::npos)
        << why(kScene, sun);
    const std::string animated = "[[light]]\ntype = \"point\"\nkeyframes = [{ frame = 1, position = [0, 0, 1] }]\n";
    EXPECT_NE(why(animated, {}).find("keyframes"), std::string::npos);
    EXPECT_NE(why("photic = ", {}).find("made_up.toml:1"), std::string::npos);
}

}  // namespace
}  // namespace photic
