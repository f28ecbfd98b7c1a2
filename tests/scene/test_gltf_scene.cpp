// SPDX-License-Identifier: Apache-2.0
// A glTF that stands for a whole scene: what it is taken for.
#include "bake/scene/gltf_scene.h"

#include <glm/geometric.hpp>
#include <numbers>

#include "tests/scene/gltf_room.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using nlohmann::json;
using test::GltfText;
using Room = test::GltfRoom;

using GltfSceneTest = test::GltfFileTest;

TEST_F(GltfSceneTest, AClosedBlockOfGlassStandsOverATable) {
    const Scene scene = open(Room());
    ASSERT_EQ(scene.surfaces.size(), 1u);
    const Surface& block = scene.surfaces[0];
    EXPECT_EQ(block.name, "block");
    EXPECT_TRUE(block.closed);
    EXPECT_EQ(block.event, SurfaceEvent::Both);
    EXPECT_EQ(sideOf(scene, block, Side::Below).ior.mean(), 1.5);  // the standard's
    // (x, y, z) of the file is (x, -z, y) here.
    EXPECT_NEAR(glm::length(block.center - glm::dvec3(0.1, -0.2, 1)), 0, 1e-6);
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "table");
    ASSERT_EQ(scene.lights.size(), 1u);
    noted("a sun of 1000 W/m2");
    noted("'block' is a body of index 1.5");
    noted("1 other parts receive light");
    // The box holds both, and is cut to what is there.
    EXPECT_LT(scene.domain.min.z, 0);
    EXPECT_GT(scene.domain.min.z, -0.1);
    EXPECT_GT(scene.domain.max.z, 1.5);
    EXPECT_NEAR(scene.domain.max.x, 1, 0.05);
}

TEST_F(GltfSceneTest, MaterialsSayIndexColourAndDispersion) {
    Room room;
    auto& extensions = room.material()["extensions"];
    extensions["KHR_materials_ior"]["ior"] = 1.6;
    extensions["KHR_materials_dispersion"]["dispersion"] = 0.5;
    extensions["KHR_materials_volume"] = {
        {"thicknessFactor", 1}, {"attenuationDistance", 0.5}, {"attenuationColor", {1, 0.5, 0.25}}};
    const Scene scene = open(room);
    const Medium inside = sideOf(scene, scene.surfaces[0], Side::Below);
    EXPECT_NEAR(inside.ior.at(RefractiveIndex::kD_nm), 1.6, 1e-9);
    const double abbe = 0.6 / (inside.ior.at(RefractiveIndex::kF_nm) - inside.ior.at(RefractiveIndex::kC_nm));
    EXPECT_NEAR(abbe, 40, 1e-6);  // 20 over the dispersion
    EXPECT_NEAR(inside.absorption.x, 0, 1e-9);
    EXPECT_NEAR(inside.absorption.y, 2 * std::numbers::ln2, 1e-6);
    EXPECT_NEAR(inside.absorption.z, 4 * std::numbers::ln2, 1e-6);
}

TEST_F(GltfSceneTest, SmoothMetalIsAMirrorAndRoughGlassReceives) {
    Room room;
    room.material().erase("extensions");
    room.material()["pbrMetallicRoughness"] = {
        {"metallicFactor", 1}, {"roughnessFactor", 0.1}, {"baseColorFactor", {1, 0.8, 0.3, 1}}};
    const Scene scene = open(room);
    EXPECT_EQ(scene.surfaces[0].event, SurfaceEvent::Mirror);
    EXPECT_NEAR(scene.surfaces[0].colour.y, 0.8, 1e-6);
    room.material()["pbrMetallicRoughness"]["roughnessFactor"] = 0.6;
    refusedRoom(room, {"nothing that bends or mirrors light", "KHR_materials_transmission",
                       "'block' would do, but for its roughness"});

    Room rough;
    rough.material()["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
    rough.root["nodes"].push_back({{"mesh", 1}, {"name", "smooth"}, {"extras", {{"photic_role", "refractor"}}}});
    rough.root["scenes"][0]["nodes"].push_back(2);
    EXPECT_EQ(open(rough).surfaces.size(), 1u);
    noted("'block' lets light through, but with roughness 0.5");
}

TEST_F(GltfSceneTest, LightsKeepTheirUnits) {
    Room room;
    // A sun that shines down the file's -Y: its node turns -Z there.
    const double half = std::sqrt(0.5);
    room.light({{"type", "directional"}, {"intensity", 683 * 3}, {"color", {1, 0.5, 0.5}}},
               {{"name", "sun"}, {"rotation", {-half, 0, 0, half}}});
    room.light({{"type", "point"}, {"intensity", 683}}, {{"name", "bulb"}, {"translation", {1, 2, 3}}});
    room.light({{"type", "spot"}, {"intensity", 683}, {"spot", {{"outerConeAngle", 0.5}, {"innerConeAngle", 0.3}}}},
               {{"name", "spot"}, {"translation", {0, 3, 0}}, {"rotation", {-half, 0, 0, half}}});
    const Scene scene = open(room);
    ASSERT_EQ(scene.lights.size(), 3u);
    for (const Light& light : scene.lights) {
        if (light.type == LightType::Sun) {
            EXPECT_NEAR(glm::length(light.direction - glm::dvec3(0, 0, -1)), 0, 1e-6);
            EXPECT_NEAR(light.irradiance.x, 3, 1e-6);
            EXPECT_NEAR(light.irradiance.y, 1.5, 1e-6);
        } else if (light.type == LightType::Point) {
            EXPECT_NEAR(glm::length(*light.position - glm::dvec3(1, -3, 2)), 0, 1e-6);
            EXPECT_NEAR(light.power.x, 4 * std::numbers::pi, 1e-5);  // 1 W/sr
        } else {
            EXPECT_NEAR(light.cone_angle_deg, 2 * 0.5 * 180 / std::numbers::pi, 1e-5);
            // Full strength up to the inner cone, none at the outer one.
            EXPECT_NEAR(light.spotFalloff(std::cos(0.299)), 1, 1e-4);
            EXPECT_LT(light.spotFalloff(std::cos(0.31)), 1);
            EXPECT_EQ(light.spotFalloff(std::cos(0.501)), 0);
        }
    }
}

TEST_F(GltfSceneTest, PartsOfANodeGoByTheirMaterials) {
    Room room;
    room.root["materials"].push_back({{"name", "plaster"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
    auto twin = room.root["meshes"][1]["primitives"][0];
    twin["material"] = 1;
    twin["attributes"]["POSITION"] = 0, twin["indices"] = 1;
    room.root["meshes"][1]["primitives"].push_back(twin);
    const Scene scene = open(room);
    ASSERT_EQ(scene.surfaces.size(), 1u);
    EXPECT_EQ(scene.surfaces[0].name, "block, clear");
    EXPECT_EQ(scene.surfaces[0].mesh->triangles.size(), 12u);
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[1].name, "block, plaster");

    // The same parts by hand.
    const std::string by_hand =
        "photic = 1\n[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\n[[surface]]\nkind = "
        "\"mesh\"\nfile = \"room.glb\"\nior_below = 1.5\nnode = \"block\"\nmaterial = ";
    EXPECT_EQ(load(by_hand + "\"clear\"\n").surfaces[0].mesh->triangles.size(), 12u);
    refused(by_hand + "\"brass\"\n", "s.toml:7:1",
            {"no triangle of the node 'block' with the material 'brass'", "'clear'"});
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    refused("photic = 1\n[[object]]\nfile = \"a.obj\"\nnode = \"x\"\n", "s.toml:4:1", {".gltf and .glb"});
}

TEST_F(GltfSceneTest, ExtrasSayWhatAFileCannot) {
    Room room;
    room.root["scenes"][0]["extras"] = {{"photic", {{"voxel_size", 0.05}, {"bounces", 4}, {"method", "beams"}}}};
    room.block()["extras"] = {{"photic", {{"ior", 1.7}, {"absorption", {1, 2, 3}}}}};
    room.node()["extras"] = {{"photic_role", "movable"}, {"other", 1}};
    const Scene scene = open(room);
    EXPECT_EQ(scene.domain.voxel_size, 0.05);
    EXPECT_EQ(scene.bake.bounces, 4);
    EXPECT_EQ(scene.objects[0].role, Role::Movable);
    EXPECT_EQ(sideOf(scene, scene.surfaces[0], Side::Below).ior.mean(), 1.7);
    EXPECT_EQ(sideOf(scene, scene.surfaces[0], Side::Below).absorption, glm::dvec3(1, 2, 3));

    room.block()["extras"] = {{"photic", {{"rolle", "mirror"}}}};
    refusedRoom(room, {"'block'", "photic.rolle", "not known"});
    room.block()["extras"] = {{"photic", {{"role", "lens"}}}};
    refusedRoom(room, {"photic.role", "\"lens\"", "refractor, mirror"});
    room.block()["extras"] = {{"photic", {{"ior", "high"}}}};
    refusedRoom(room, {"photic.ior", "a number of at least"});
    room.block().erase("extras");
    room.root["scenes"][0]["extras"] = {{"photic", {{"voxel_sise", 0.05}}}};
    refusedRoom(room, {"voxel_sise"});
}

TEST_F(GltfSceneTest, CamerasLookWhereTheFileSays) {
    Room room;
    room.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}}}}};
    room.root["nodes"].push_back({{"camera", 0}, {"name", "front"}, {"translation", {0, 1, 5}}});
    room.root["scenes"][0]["nodes"].push_back(2);
    const Scene scene = open(room);
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_NEAR(glm::length(scene.cameras[0].position - glm::dvec3(0, -5, 1)), 0, 1e-9);
    EXPECT_NEAR(glm::length(scene.cameras[0].target - glm::dvec3(0, -4, 1)), 0, 1e-9);
    EXPECT_NEAR(scene.cameras[0].field_of_view_deg, 0.5 * 180 / std::numbers::pi, 1e-6);
}

TEST_F(GltfSceneTest, DamagedScenesAreRefused) {
    Room room;
    room.block()["extensions"]["KHR_lights_punctual"]["light"] = 7;
    refusedRoom(room, {"light 7"});
    room.block()["extensions"] = {{"KHR_lights_punctual", 3}};
    EXPECT_EQ(open(room).surfaces.size(), 1u);
    room.material()["extensions"]["KHR_materials_volume"] = {{"attenuationDistance", 1},
                                                             {"attenuationColor", {"red", 1, 1}}};
    refusedRoom(room, {"damaged"});
    room.material()["extensions"].erase("KHR_materials_volume");
    room.root["scene"] = 9;
    refusedRoom(room, {"room.glb"});
}

}  // namespace
}  // namespace photic
