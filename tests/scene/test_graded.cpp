// SPDX-License-Identifier: Apache-2.0
// Media whose index varies in space, as scenes write them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "bake/libraries/openvdb.h"
#include "bake/report/error.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/not_built.h"

namespace photic {
namespace {

Scene load(const std::string& medium, const std::string& rest = "") {
    Monitor monitor;
    return parseScene("photic = 1\n[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\n" + rest +
                          "[[medium]]\nname = \"lens\"\n" + medium,
                      "s.toml", ::testing::TempDir(), 0, monitor);
}

GradedObject object(const std::string& medium, const std::string& rest = "") {
    return load(medium, rest).index->objects().at(0);
}

void refused(const std::string& medium, const std::vector<std::string>& words, const std::string& rest = "") {
    try {
        load(medium, rest);
        FAIL() << medium;
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Input);
        EXPECT_NE(error.where().find("s.toml"), std::string::npos);
        for (const std::string& word : words)
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
}

const std::string kBox = "[domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nresolution = 8\n";

TEST(GradedMedia, EveryKindIsWhatItsKeysSay) {
    const auto indexOf = [](const std::string& text) { return object("index = " + text + "\n", kBox).index[0]; };
    EXPECT_NEAR(indexOf("{ kind = \"luneburg\", center = [0.1, 0, 0], radius = 0.5 }")->indexAt({0.1, 0.25, 0}),
                std::sqrt(1.75), 1e-12);
    EXPECT_NEAR(indexOf("{ kind = \"fish_eye\", n0 = 2, scale = 0.5 }")->indexAt({0, 0, 0.5}), 1, 1e-12);
    const auto rod = indexOf("{ kind = \"selfoc\", axis = [2, 0, 0], n0 = 1.6, g = 1, radius = 0.5, length = 1 }");
    EXPECT_NEAR(rod->indexAt({0.4, 0, 0.3}), 1.6 * std::sqrt(1 - 0.09), 1e-12);
    EXPECT_EQ(rod->indexAt({0.6, 0, 0}), 1);
    EXPECT_NEAR(indexOf("{ kind = \"linear\", n0 = 1.5, slope = [0, 0.5, 0] }")->indexAt({9, 1, 9}), std::sqrt(2.75),
                1e-12);
    EXPECT_NEAR(indexOf("{ kind = \"hot_air\", height = 0.5, n = 1.0003, drop = 2e-5 }")->indexAt({0, 0, 0}),
                1.0003 - 2e-5, 1e-12);
    EXPECT_NEAR(indexOf("{ kind = \"salt\", thickness = 0.01, level = -0.5 }")->indexAt({0, 0, -0.8}), 1.36, 1e-9);
}

TEST(GradedMedia, GiveTheSceneItsBoundsAndChannels) {
    const Scene lens = load("index = { kind = \"luneburg\", center = [0, 0, 1], radius = 0.5 }\nabsorption = 0.2\n");
    ASSERT_EQ(lens.index->objects().size(), 1u);
    EXPECT_EQ(lens.index->objects()[0].name, "lens");
    EXPECT_EQ(lens.index->objects()[0].extinction(), glm::dvec3(0.2));
    EXPECT_FALSE(lens.coloured());
    EXPECT_NEAR(lens.domain.max.z, 1.5 + 2 * lens.domain.voxel_size, 1e-9);
    const Scene prism = load(
        "index = [{ kind = \"luneburg\", radius = 0.5 }, { kind = \"luneburg\", radius = 0.5 }, "
        "{ kind = \"luneburg\", radius = 0.49 }]\n");
    EXPECT_EQ(prism.index->objects()[0].index.size(), 3u);
    EXPECT_TRUE(prism.coloured());
    refused("index = { kind = \"salt\", thickness = 0.1 }\n", {"no bounds", "[domain]"});
}

TEST(GradedMedia, ALightWithAPlaceIsAimedAtThem) {
    Monitor monitor;
    const Scene scene = parseScene(
        "photic = 1\n[[light]]\ntype = \"point\"\nposition = [0, 0, 3]\npower = 10\n"
        "[[medium]]\nname = \"lens\"\nindex = { kind = \"luneburg\", center = [0, 0, 1], radius = 0.5 }\n",
        "s.toml", "", 0, monitor);
    EXPECT_EQ(scene.lights[0].direction, glm::dvec3(0, 0, -1));
    EXPECT_NEAR(scene.lights[0].irradiance.x, 10 / (4 * 3.14159265358979 * 4), 1e-9);
}

TEST(GradedMedia, AFileLiesWhereItIsPut) {
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(1.0f);
    grid->setName("ior");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) grid->tree().setValueOn({x, y, z}, 1.2f + 0.02f * float(x));
    const std::string path = ::testing::TempDir() + "/graded_lens.vdb";
    openvdb::io::File file(path);
    file.write({grid});
    file.close();
    const auto here = object("index = \"graded_lens.vdb\"\n").index[0];
    EXPECT_NEAR(here->indexAt({0.35, 0.4, 0.4}), 1.27, 1e-6);
    EXPECT_NEAR(here->at({0.35, 0.4, 0.4}).gradient.x, 1.27 * 0.2, 1e-5);
    EXPECT_EQ(here->indexAt({0.9, 0.4, 0.4}), 1);
    // A quarter turn about z sends the file's x to the world's y.
    const auto moved =
        object("index = { file = \"graded_lens.vdb\", position = [0, 1, 0], rotation = [0, 0, 90], scale = 2 }\n")
            .index[0];
    EXPECT_NEAR(moved->indexAt({-0.8, 1.7, 0.8}), 1.27, 1e-6);
    EXPECT_NEAR(moved->bounds()->max.y, 1 + 2 * 0.75, 1e-9);
    std::filesystem::remove(path);
}

TEST(GradedMedia, EachHasVolumesOfItsOwn) {
    // What absorbs, what shines and how light is scattered, per place; a second object has others, elsewhere.
    openvdb::initialize();
    const std::string path = ::testing::TempDir() + "/graded_volumes.vdb";
    const auto write = [&](float absorption, float emission, float g) {
        openvdb::GridPtrVec grids;
        for (const auto& [name, value] :
             {std::pair{"absorption", absorption}, std::pair{"emission", emission}, std::pair{"anisotropy", g}}) {
            auto grid = openvdb::FloatGrid::create(0.0f);
            grid->setName(name);
            grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
            for (int x = 0; x < 4; ++x)
                for (int y = 0; y < 4; ++y)
                    for (int z = 0; z < 4; ++z) grid->tree().setValueOn({x, y, z}, value * float(1 + x));
            grids.push_back(grid);
        }
        openvdb::io::File file(path);
        file.write(grids);
        file.close();
    };
    write(2, 5, -0.2f);
    const std::string lens = "index = { kind = \"luneburg\", radius = 0.5 }\nscattering = 0.1\n",
                      file = "\"graded_volumes.vdb\"\n",
                      moved = "{ file = \"graded_volumes.vdb\", position = [1, 0, 0] }\n";
    const Scene scene =
        load(lens + "absorption_volume = " + file + "emission_volume = " + file + "anisotropy_volume = " + file +
             "[[medium]]\nname = \"other\"\n" + lens + "emission_volume = " + moved + "anisotropy = 0.4\n");
    const GradedObject &a = scene.index->objects().at(0), &b = scene.index->objects().at(1);
    const glm::dvec3 at(0.15, 0.1, 0.1);
    EXPECT_NEAR(a.absorption_volume->at(at).x, 5, 1e-5);
    EXPECT_NEAR(a.emission_volume->at(at).y, 12.5, 1e-5);
    EXPECT_NEAR(a.anisotropy_volume->at(at).x, -0.5, 1e-5);
    EXPECT_FALSE(b.absorption_volume || b.anisotropy_volume);
    EXPECT_NEAR(b.emission_volume->at(at + glm::dvec3(1, 0, 0)).x, 12.5, 1e-5);
    EXPECT_EQ(b.emission_volume->at(at).x, 0);
    EXPECT_EQ(b.anisotropy, 0.4);
    refused(lens + "anisotropy = 0.4\nanisotropy_volume = " + file, {"anisotropy", "anisotropy_volume"});
    write(1, -1, 0.3f);
    refused(lens + "anisotropy_volume = " + file, {"anisotropy", "1.2", "between"});
    refused(lens + "emission_volume = " + file, {"emission", "-1", "0 or more"});
    refused("ior = 1.5\nemission_volume = " + file, {"emission_volume", "'index'"});
    refused("ior = 1.5\nanisotropy_volume = " + file, {"anisotropy_volume", "'anisotropy'"});
    std::filesystem::remove(path);
}

TEST(GradedMedia, AFaceMayReflect) {
    openvdb::initialize();
    const std::string path = ::testing::TempDir() + "/graded_faces.vdb",
                      lens = "index = { kind = \"luneburg\", radius = 0.5 }\n";
    const auto write = [&](float albedo) {
        auto grid = openvdb::FloatGrid::create(0.0f);
        grid->setName("albedo");
        grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
        for (int x = 0; x < 4; ++x) grid->tree().setValueOn({x, 0, 0}, albedo * float(x));
        openvdb::io::File file(path);
        file.write({grid});
        file.close();
    };
    EXPECT_FALSE(object(lens).face.reflects());
    const FaceReflection plain = object(lens + "face = { albedo = [0.1, 0.2, 1], roughness = 0.4 }\n").face;
    EXPECT_TRUE(plain.reflects());
    EXPECT_EQ(plain.albedo, glm::dvec3(0.1, 0.2, 1));
    EXPECT_EQ(plain.roughness, 0.4);
    write(0.25f);
    const FaceReflection painted = object(lens + "face = { albedo_volume = \"graded_faces.vdb\" }\n").face;
    ASSERT_TRUE(painted.albedo_volume);
    EXPECT_NEAR(painted.albedo_volume->at({0.15, 0, 0}).y, 0.375, 1e-6);
    write(0.5f);
    refused(lens + "face = { albedo_volume = \"graded_faces.vdb\" }\n", {"albedo", "1.5", "between 0 and 1"});
    refused(lens + "face = { albedo = 1.2 }\n", {"albedo", "1.2"});
    refused(lens + "face = { roughness = -0.1 }\n", {"roughness", "-0.1"});
    refused(lens + "face = { rouhgness = 0.1 }\n", {"roughness"});
    refused(lens + "face = { albedo = 0.1, albedo_volume = \"graded_faces.vdb\" }\n", {"albedo_volume"});
    refused(lens + "face = 0.5\n", {"'face'", "table"});
    refused("ior = 1.5\nface = { albedo = 0.5 }\n", {"'face'", "'index'"});
    std::filesystem::remove(path);
}

TEST(GradedMedia, AFileMustHoldAnIndex) {
    openvdb::initialize();
    const std::string path = ::testing::TempDir() + "/graded_bad.vdb";
    const auto write = [&](const std::vector<float>& values) {
        auto grid = openvdb::FloatGrid::create(1.0f);
        grid->setName("n");
        int x = 0;
        for (const float value : values) grid->tree().setValueOn({x++, 0, 0}, value);
        openvdb::io::File file(path);
        file.write({grid});
        file.close();
    };
    const std::string medium = "index = \"graded_bad.vdb\"\n";
    write({});
    refused(medium, {"graded_bad.vdb"});
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 0.0f, -1.5f}) {
        write({1.3f, bad, 1.4f});
        refused(medium, {"graded_bad.vdb"});
    }
    std::filesystem::remove(path);
}

TEST(GradedMedia, RefusalsNameThePlaceAndTheRemedy) {
    refused("index = { kind = \"luneberg\", radius = 0.5 }\n", {"luneburg"});
    refused("index = { kind = \"luneburg\" }\n", {"radius"});
    refused("index = { kind = \"luneburg\", radius = 0.5, n0 = 2 }\n", {"n0", "luneburg"});
    refused("index = { kind = \"selfoc\", n0 = 1.5, g = 3, radius = 0.5, length = 1 }\n", {"rim", "less than 1"});
    refused("index = { kind = \"selfoc\", n0 = 1.5, g = 1, radius = 0.5 }\n", {"length"});
    refused("index = { kind = \"linear\", n0 = 1.5, slope = [0, 0, 1], min = [0, 0, 0] }\n", {"max"});
    refused("index = 3\n", {"luneburg"});
    refused("index = [\"a.vdb\", \"b.vdb\"]\n", {"three"});
    refused("index = \"nowhere.vdb\"\n", {"nowhere.vdb"});
    refused("priority = 2\nindex = { kind = \"luneburg\", radius = 0.5 }\n", {"priority", "by itself"});
    refused("ior = 1.5\nindex = { kind = \"luneburg\", radius = 0.5 }\n", {"ior", "index"});
}

TEST(GradedMedia, SurfacesMayNameThem) {
    // The surface holds it, and the number that stands for it is that of the surface's middle.
    const std::string slope = "index = { kind = \"linear\", n0 = 1.5, slope = [0, 0, 1] }\n",
                      ball =
                          "[[surface]]\nkind = \"sphere\"\nradius = 0.1\nposition = [0, 0, 0.5]\ninside = \"lens\"\n";
    const Scene held = load(slope + "priority = 2\n", ball);
    EXPECT_TRUE(held.index->objects().at(0).enclosed);
    ASSERT_EQ(held.surfaces.at(0).medium_below, 0);
    EXPECT_EQ(held.media.at(0).priority, 2);
    EXPECT_NEAR(held.surfaces.at(0).ior_below, std::sqrt(2.75), 1e-12);
    EXPECT_NEAR(held.media.at(0).ior.mean(), std::sqrt(2.75), 1e-12);
    EXPECT_FALSE(object("index = { kind = \"luneburg\", radius = 0.5 }\n").enclosed);
    // What is called "water" is below height fields without being named; below a ball it is not.
    Monitor monitor;
    const auto water = [&](const std::string& surface) {
        return parseScene(
            "photic = 1\n[domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 0]\n[[light]]\ntype = \"sun\"\n"
            "direction = [0, 0, -1]\n[[medium]]\nname = \"water\"\nabsorption = 0.1\n" +
                slope + surface,
            "s.toml", "", 0, monitor);
    };
    const Scene pool = water("[[surface]]\nkind = \"height_field\"\nflat = true\n");
    EXPECT_TRUE(pool.index->objects().at(0).enclosed);
    EXPECT_EQ(pool.surfaces.at(0).medium_below, 0);
    EXPECT_TRUE(pool.medium.present()) << "its density is a grid";
    const Scene drop = water("[[surface]]\nkind = \"sphere\"\nradius = 0.1\nior_below = 1.5\n");
    EXPECT_FALSE(drop.index->objects().at(0).enclosed);
    EXPECT_FALSE(water("").medium.present());
}

TEST(GradedMedia, AreRefusedByNameWhereRaysAreStraight) {
    const Scene lens = load("index = { kind = \"luneburg\", radius = 0.5 }\n");
    EXPECT_NE(gradedRefusal(lens).find("'lens'"), std::string::npos);
    EXPECT_NE(notBuiltYet(lens).find("rays go straight"), std::string::npos);
    const Scene plain = load("ior = 1.5\n", "[[surface]]\nkind = \"sphere\"\nradius = 0.1\ninside = \"lens\"\n");
    EXPECT_EQ(gradedRefusal(plain), "");
}

}  // namespace
}  // namespace photic
