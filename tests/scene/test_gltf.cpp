// SPDX-License-Identifier: Apache-2.0
// What a glTF can hold besides plain triangles: read, or refused by name.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/scene/mesh_file.h"
#include "tests/scene/gltf_text.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::GltfText;
using test::SceneTest;

class Gltf : public SceneTest {
protected:
    TriangleMesh read(const std::string& bytes, const std::string& name = "a.gltf") {
        write(name, bytes);
        return loadMesh(path(name), std::nullopt, warnings_,
                        [this](std::string_view seen) { bytes_seen_ += seen.size(); });
    }
    void refusedFile(const std::string& bytes, const std::vector<std::string>& words,
                     const std::string& name = "a.gltf") {
        write(name, bytes);
        refused("photic = 1\n[[object]]\nfile = \"" + name + "\"\n", "s.toml:3:1", words);
    }
    std::size_t bytes_seen_ = 0;
};

double meanHeight(const TriangleMesh& mesh) {
    double sum = 0;
    for (const glm::dvec3& p : mesh.positions) sum += p.z;
    return sum / static_cast<double>(mesh.positions.size());
}

TEST_F(Gltf, APlainSquareIsReadFromTextAndFromBinary) {
    const GltfText square;
    const TriangleMesh text = read(square.text()), binary = read(square.binary(), "a.glb");
    EXPECT_EQ(text.positions, binary.positions);
    EXPECT_EQ(text.triangles.size(), 2u);
    EXPECT_EQ(text.normals[0], glm::dvec3(0, 0, 1));
    EXPECT_TRUE(warnings_.messages.empty());
    EXPECT_EQ(read("\xef\xbb\xbf" + square.text()).positions, text.positions);  // a byte order mark
    refusedFile(square.binary().substr(0, 200), {"a.glb", "truncated"}, "a.glb");
}

TEST_F(Gltf, MorphTargetsMoveTheMeshByTheirWeights) {
    GltfText square;
    const int by = square.add<float>({0, -0.5f, 0, 0, -0.5f, 0, 0, -0.5f, 0, 0, -0.5f, 0}, 5126, "VEC3");
    square.primitive()["targets"] = {{{"POSITION", by}}};
    EXPECT_EQ(meanHeight(read(square.text())), 0);  // without weights they are 0
    square.mesh()["weights"] = {1.0};
    EXPECT_EQ(meanHeight(read(square.text())), -0.5);
    square.node()["weights"] = {0.5};  // a node's own come first
    EXPECT_EQ(meanHeight(read(square.text())), -0.25);
}

// Exporters may leave the normals of shape keys out. Those of the shape at rest would bend light as flat water does.
TEST_F(Gltf, AMorphThatSaysNothingOfNormalsGetsThemFromItsFaces) {
    GltfText square;
    square.primitive()["attributes"]["NORMAL"] = square.add<float>({0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, 5126, "VEC3");
    const int tilt = square.add<float>({0, 0, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0}, 5126, "VEC3");  // by 45 degrees about y
    square.primitive()["targets"] = {{{"POSITION", tilt}}};
    EXPECT_EQ(read(square.text()).normals[0], glm::dvec3(0, 0, 1));  // not moved: as the file says
    square.mesh()["weights"] = {1.0};
    for (const glm::dvec3& n : read(square.text()).normals) {
        EXPECT_NEAR(n.x, -std::sqrt(0.5), 1e-7);
        EXPECT_NEAR(n.z, std::sqrt(0.5), 1e-7);
    }
    // Where it says them, they are taken.
    square.primitive()["targets"][0]["NORMAL"] =
        square.add<float>({-3, -1, 0, -3, -1, 0, -3, -1, 0, -3, -1, 0}, 5126, "VEC3");
    EXPECT_EQ(read(square.text()).normals[0], glm::dvec3(-1, 0, 0));
}

TEST_F(Gltf, WhatIsHiddenIsNotThere) {
    GltfText square;
    square.root["extensionsRequired"] = {"KHR_node_visibility"};
    square.root["nodes"] = {{{"mesh", 0}, {"children", {1}}, {"name", "lower"}},
                            {{"name", "group"}, {"children", {2}}},
                            {{"mesh", 0}, {"name", "upper"}, {"translation", {0, 3, 0}}}};
    EXPECT_EQ(read(square.text()).triangles.size(), 4u);
    auto& visible = square.root["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"];
    visible = true;
    EXPECT_EQ(read(square.text()).triangles.size(), 4u);
    visible = false;  // and all that hangs on it
    EXPECT_EQ(read(square.text()).triangles.size(), 2u);
    EXPECT_EQ(meanHeight(read(square.text())), 0);
    square.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
    refusedFile(square.text(), {"has no triangles", "1 nodes are hidden (KHR_node_visibility)"});
}

TEST_F(Gltf, SparseAccessorsReplaceWhatTheySay) {
    GltfText square;
    const int where = square.addView<std::uint16_t>({1, 3}), what = square.addView<float>({1, 2, 1, -1, 4, -1});
    auto& accessor = square.root["accessors"][0];
    accessor["sparse"] = {{"count", 2},
                          {"indices", {{"bufferView", where}, {"componentType", 5123}}},
                          {"values", {{"bufferView", what}}}};
    const TriangleMesh mesh = read(square.text());
    EXPECT_EQ(mesh.positions[1].z, 2);
    EXPECT_EQ(mesh.positions[3].z, 4);
    EXPECT_EQ(mesh.positions[0].z, 0);
    accessor["count"] = 3;
    refusedFile(square.text(), {"replaces element 3 of 3"});
}

TEST_F(Gltf, InstancesAreCopies) {
    GltfText square;
    const int places = square.add<float>({0, 0, 0, 0, -0.7f, 0}, 5126, "VEC3"),
              sizes = square.add<float>({1, 1, 1, 2, 2, 2}, 5126, "VEC3");
    square.root["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    auto& attributes = square.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes = {{"TRANSLATION", places}};
    EXPECT_EQ(read(square.text()).triangles.size(), 4u);
    EXPECT_NEAR(meanHeight(read(square.text())), -0.35, 1e-7);
    attributes["SCALE"] = sizes;
    glm::dvec3 high(-9);
    for (const glm::dvec3& p : read(square.text()).positions) high = glm::max(high, p);
    EXPECT_EQ(high.x, 2);
    attributes["SCALE"] = square.add<float>({1, 1, 1}, 5126, "VEC3");
    refusedFile(square.text(), {"1 instances by one attribute and 2 by TRANSLATION"});
}

TEST_F(Gltf, QuantisedPositionsAreRead) {
    GltfText square;
    square.root["extensionsRequired"] = {"KHR_mesh_quantization"};
    const int small =
        square.add<std::int8_t>({-127, 0, 127, 0, 127, 0, 127, 0, 127, 0, -127, 0, -127, 0, -127, 0}, 5120, "VEC4");
    auto& accessor = square.root["accessors"][static_cast<std::size_t>(small)];
    accessor["type"] = "VEC3", accessor["normalized"] = true;
    square.root["bufferViews"].back()["byteStride"] = 4;
    square.primitive()["attributes"]["POSITION"] = small;
    EXPECT_EQ(read(square.text()).positions[1], glm::dvec3(1, -1, 0));
}

TEST_F(Gltf, WhatChangesTheShapeIsRefusedByName) {
    GltfText square;
    square.root["extensionsRequired"] = {"ACME_shape"};
    refusedFile(square.text(), {"needs the extension ACME_shape", "export without it"});
    square.root["extensionsRequired"] = {"KHR_materials_transmission", "KHR_texture_transform"};  // looks
    EXPECT_EQ(read(square.text()).triangles.size(), 2u);

    GltfText skinned;
    skinned.node()["skin"] = 0;
    skinned.root["skins"] = {{{"joints", {0}}}};
    refusedFile(skinned.text(), {"node 'sheet'", "bones", "apply the armature"});

    GltfText moving;
    moving.root["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                                  {"samplers", {{{"input", 0}, {"output", 0}}}}}};
    read(moving.text());
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("1 animated channels are not read"), std::string::npos);
    // KHR_animation_pointer moves what it points to.
    moving.root["animations"][0]["channels"][0]["target"] = {{"path", "pointer"}};
    read(moving.text());
    EXPECT_EQ(warnings_.messages.size(), 2u);

    GltfText later;
    later.root["asset"]["minVersion"] = "2.1";
    refusedFile(later.text(), {"asks for readers of glTF '2.1'", "export as 2.0"});
}

TEST_F(Gltf, TurnsNeedNotBeUnit) {
    GltfText square;
    square.node()["rotation"] = {1, 0, 0, 1};  // a quarter about x
    for (const glm::dvec3& p : read(square.text()).positions) {
        EXPECT_NEAR(p.y, 0, 1e-12);
        EXPECT_NEAR(std::fabs(p.z), 1, 1e-12);
    }
}

TEST_F(Gltf, CompressedBuffersAreNotCalledDamaged) {
    GltfText draco;
    draco.root["extensionsUsed"] = draco.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    draco.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                     {"attributes", {{"POSITION", 0}}}};
    for (auto& accessor : draco.root["accessors"]) accessor.erase("bufferView");
    refusedFile(draco.text(), {"needs the extension KHR_draco_mesh_compression, which is not read"});
    draco.root.erase("extensionsRequired");  // though it does need it
    refusedFile(draco.text(), {"needs the extension KHR_draco_mesh_compression, which is not read"});

    GltfText meshopt;
    meshopt.root["extensionsUsed"] = {"EXT_meshopt_compression"};
    auto whole = nlohmann::json::parse(meshopt.text());
    whole["buffers"].push_back(
        {{"byteLength", 100}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
    refusedFile(whole.dump(), {"needs the extension EXT_meshopt_compression, which is not read"});
    whole["extensionsUsed"] = nlohmann::json::array();
    refusedFile(whole.dump(), {"buffer 1 has no uri"});
}

TEST_F(Gltf, BuffersLieBesideTheFile) {
    const GltfText square;
    write("a+b c.bin", square.buffer + "padding");
    EXPECT_EQ(read(square.text("a+b%20c.bin")).triangles.size(), 2u);
    EXPECT_GT(bytes_seen_, square.buffer.size());  // it is part of what the scene is made of
    refusedFile(square.text(path("a+b c.bin")), {"only files beside it are read, by a relative name"});
    refusedFile(square.text("https://example.com/a.bin"), {"https://example.com/a.bin", "only files beside it"});
    refusedFile(square.text("C:\\a.bin"), {"only files beside it"});
    refusedFile(square.text("gone.bin"), {"gone.bin", "No such file"});
    refusedFile(square.text("data:;base64," + test::base64(square.buffer)), {"'data:;base64'", "media type"});
    refusedFile(square.text("data:text/plain," + std::string(9000, 'x')), {"'data:text/plain'", "media type"});
    EXPECT_EQ(read(square.text("data:application/gltf-buffer;base64," + test::base64(square.buffer))).triangles.size(),
              2u);
    write("short.bin", square.buffer.substr(0, 40));
    refusedFile(square.text("short.bin"), {"buffer 0 claims 60 bytes and has 40"});
    try {
        loadMesh(path("a.gltf"), std::nullopt, warnings_, [](std::string_view) {});
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_LT(std::string(error.what()).size(), 400u);
    }
}

TEST_F(Gltf, NegativeAndEndlessNumbersAreRefused) {
    for (const char* key : {"byteOffset", "count"}) {
        GltfText square;
        square.root["accessors"][0][key] = -12;
        refusedFile(square.text(), {std::string("'") + key + "' of accessors 0 is -12"});
    }
    GltfText square;
    square.root["bufferViews"][1]["byteLength"] = -1;
    refusedFile(square.text(), {"'byteLength' of bufferViews 1 is -1"});
    GltfText endless;
    endless.root["accessors"][0].erase("bufferView");
    endless.root["accessors"][0]["count"] = 4000000000u;
    refusedFile(endless.text(), {"4000000000 elements"});

    std::string deep = GltfText().text();
    const std::string nest(20000, '['), close(20000, ']');
    deep.insert(1, "\"extras\":" + nest + close + ",");
    refusedFile(deep, {"nested more than 64 deep"});
    deep = GltfText().text();
    deep.insert(1, "\"extras\":\"" + nest + "\\\"\",");  // brackets in a string are none
    EXPECT_EQ(read(deep).triangles.size(), 2u);
}

TEST_F(Gltf, AFileWithoutTrianglesSaysWhatItHolds) {
    GltfText square;
    square.primitive()["mode"] = 1;
    refusedFile(square.text(), {"has no triangles", "points or lines"});
    square.primitive()["mode"] = 5;
    refusedFile(square.text(), {"strips or fans (mode 5)"});
    GltfText two;
    two.root["scenes"].push_back({{"nodes", nlohmann::json::array()}});
    two.root["scenes"][0]["name"] = "pool";
    read(two.text());
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("of its 2 scenes only the default one, 'pool', is read"), std::string::npos);
}

}  // namespace
}  // namespace photic
