// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "bake/image/atomic_file.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/mesh_shape.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;

class Meshes : public SceneTest {
protected:
    TriangleMesh mesh(const std::string& name, std::optional<UpAxis> up = std::nullopt) {
        return loadMesh(path(name), up, warnings_, [](std::string_view) {});
    }
    void refusedFile(const std::string& name, const std::vector<std::string>& words) {
        SCOPED_TRACE(name);
        refused("photic = 1\n[[object]]\nfile = \"" + name + "\"\n", "s.toml:3:1", words);
    }
};

// A unit square in the plane z = 0 as two triangles with vertices of their own, facing up.
const char* kSplitSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0.0000000001\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";

TEST_F(Meshes, ObjWithSplitVerticesIsWelded) {
    write("a.obj", std::string("# comment\r\no square\nmtllib x.mtl\nvt 0 0\n") + kSplitSquare);
    const TriangleMesh square = mesh("a.obj");
    EXPECT_EQ(square.positions.size(), 4u);
    ASSERT_EQ(square.triangles.size(), 2u);
    for (const glm::dvec3& n : square.normals) EXPECT_NEAR(glm::length(n - glm::dvec3(0, 0, 1)), 0, 1e-9);
    EXPECT_EQ(mesh("a.obj", UpAxis::Y).positions[2], glm::dvec3(1, 0, 1));  // (1, 1, 0) -> (1, -0, 1)
    EXPECT_TRUE(warnings_.messages.empty());
}

TEST_F(Meshes, ObjIndicesOfEveryForm) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0.6 0.8\nf 1//1 2//1 3/7/1 -1//-1\n");
    const TriangleMesh square = mesh("a.obj");
    ASSERT_EQ(square.triangles.size(), 2u);  // a polygon becomes a fan
    EXPECT_NEAR(glm::length(square.normals[3] - glm::dvec3(0, 0.6, 0.8)), 0, 1e-12);
}

TEST_F(Meshes, FileNormalsAreAveragedOverWeldedVertices) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
    const TriangleMesh square = mesh("a.obj");
    EXPECT_EQ(square.positions.size(), 4u);
    EXPECT_NEAR(glm::length(square.normals[0] - glm::normalize(glm::dvec3(0, 1, 1))), 0, 1e-12);
    EXPECT_NEAR(glm::length(square.normals[1] - glm::dvec3(0, 0, 1)), 0, 1e-12);
}

TEST_F(Meshes, DegenerateTrianglesAreCountedOnce) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 9 9 9\nf 1 2 3\nf 1 2 4\nf 1 1 2\n");
    const TriangleMesh m = mesh("a.obj");
    EXPECT_EQ(m.triangles.size(), 1u);
    EXPECT_EQ(m.positions.size(), 3u);  // unused vertices are gone
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("2 triangles without area were skipped, 1 kept"), std::string::npos);
}

TEST_F(Meshes, BadObjFilesAreRefusedByLine) {
    write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    refusedFile("index.obj", {"line 4", "vertex 4 is out of range; 3 are defined"});
    write("zero.obj", "v 0 0 0\nf 0 1 2\n");
    refusedFile("zero.obj", {"line 2", "vertex 0 is out of range"});
    write("number.obj", "v 0 0 zero\n");
    refusedFile("number.obj", {"line 1", "'zero' is no number"});
    write("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    refusedFile("nan.obj", {"vertex 1 is at (1, nan, 0)", "finite"});
    write("few.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n");
    refusedFile("few.obj", {"line 3", "2 corners"});
    write("empty.obj", "");
    refusedFile("empty.obj", {"no triangles"});
    write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    refusedFile("flat.obj", {"1 triangles, all without area"});
}

std::string plyHeader(const std::string& format, int vertices, int faces) {
    return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\nelement face " +
           std::to_string(faces) + "\nproperty list uchar int vertex_indices\nproperty short flags\nend_header\n";
}

std::string binarySquare() {
    std::string bytes = plyHeader("binary_little_endian", 4, 1);
    const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (int i = 0; i < 4; ++i) put(float(i == 1 || i == 2)), put(float(i >= 2)), put(0.25), put(std::uint8_t(7));
    put(std::uint8_t(4));
    for (int i = 0; i < 4; ++i) put(i);
    put(std::int16_t(-1));
    return bytes;
}

TEST_F(Meshes, PlyAsciiAndBinaryAgree) {
    write("a.ply", plyHeader("ascii", 4, 1) + "0 0 0.25 7\n1 0 0.25 7\n1 1 0.25 7\n0 1 0.25 7\n4 0 1 2 3 -1\n");
    write("b.ply", binarySquare());
    const TriangleMesh a = mesh("a.ply"), b = mesh("b.ply");
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.triangles, b.triangles);
    ASSERT_EQ(a.triangles.size(), 2u);
    EXPECT_EQ(a.positions[2], glm::dvec3(1, 1, 0.25));
    EXPECT_EQ(a.normals[0], glm::dvec3(0, 0, 1));
}

TEST_F(Meshes, BadPlyFilesAreRefused) {
    const std::string whole = binarySquare();
    for (std::size_t length = 0; length < whole.size(); length += 3) {
        write("cut.ply", whole.substr(0, length));
        refusedFile("cut.ply", {"cut.ply"});
    }
    write("huge.ply", plyHeader("ascii", 2000000000, 1) + "0 0 0 0\n");
    refusedFile("huge.ply", {"2000000000", "truncated"});
    write("index.ply", plyHeader("ascii", 3, 1) + "0 0 0 0\n1 0 0 0\n0 1 0 0\n3 0 1 3 0\n");
    refusedFile("index.ply", {"face 0 uses vertex 3", "the file has 3"});
    write("list.ply", plyHeader("ascii", 3, 1) + "0 0 0 0\n1 0 0 0\n0 1 0 0\n1e30 0 1 2 0\n");
    refusedFile("list.ply", {"face 0 claims a list of"});
    write("none.ply", "plywood");
    refusedFile("none.ply", {"no end_header"});
}

/// A glTF of one triangle (0,0,0) (1,0,0) (0,0,-1), facing up in its own Y-up axes, under a node with `node` keys.
std::string gltfTriangle(const std::string& node, const std::string& extra = "", int count = 3) {
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 0, -1};
    const std::uint16_t indices[] = {0, 1, 2, 0};
    unsigned char bytes[44];
    std::memcpy(bytes, positions, 36), std::memcpy(bytes + 36, indices, 8);
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string base64;
    for (int i = 0; i < 44; i += 3) {
        const unsigned v = bytes[i] << 16 | (i + 1 < 44 ? bytes[i + 1] : 0) << 8 | (i + 2 < 44 ? bytes[i + 2] : 0);
        for (int s = 18; s >= 0; s -= 6) base64 += digits[v >> s & 63];
    }
    base64.back() = '=';
    return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"name": "up", "children": [1], "translation": [0, 2, 0]}, {"name": "leaf", "mesh": 0)" +
           node + R"(}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
"images": [{"uri": "not_there.png"}],)" +
           extra + R"(
"buffers": [{"byteLength": 44, "uri": "data:application/octet-stream;base64,)" +
           base64 + R"("}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": )" +
           std::to_string(count) + R"(, "type": "VEC3"},
{"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]})";
}

TEST_F(Meshes, GltfIsTurnedToZUpThroughItsNodes) {
    write("a.gltf", gltfTriangle(", \"scale\": [3, 1, 1]"));
    const TriangleMesh m = mesh("a.gltf");
    ASSERT_EQ(m.triangles.size(), 1u);
    // (x, y, z) -> (x, -z, y), two metres up.
    EXPECT_EQ(m.positions[0], glm::dvec3(0, 0, 2));
    EXPECT_EQ(m.positions[1], glm::dvec3(3, 0, 2));
    EXPECT_EQ(m.positions[2], glm::dvec3(0, 1, 2));
    EXPECT_NEAR(glm::length(m.normals[0] - glm::dvec3(0, 0, 1)), 0, 1e-12);

    // A quarter turn about the glTF's Y axis, and a mirror: the normal stays up though the winding turned.
    write("b.gltf", gltfTriangle(", \"rotation\": [0, 0.7071067811865476, 0, 0.7071067811865476]"));
    EXPECT_NEAR(glm::length(mesh("b.gltf").positions[1] - glm::dvec3(0, 1, 2)), 0, 1e-12);
    write("c.gltf", gltfTriangle(", \"scale\": [-1, 1, 1]"));
    EXPECT_NEAR(glm::length(mesh("c.gltf").normals[0] - glm::dvec3(0, 0, 1)), 0, 1e-12);
    EXPECT_EQ(mesh("a.gltf", UpAxis::Z).positions[2], glm::dvec3(0, 2, -1));
}

TEST_F(Meshes, BadGltfFilesAreRefused) {
    write("count.gltf", gltfTriangle("", "", 400));
    refusedFile("count.gltf", {"accessor 0 (400 elements) reaches beyond its buffer"});
    write("draco.gltf", gltfTriangle("", "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"],"));
    refusedFile("draco.gltf", {"KHR_draco_mesh_compression", "without mesh compression"});
    write("index.gltf", gltfTriangle("", "", 2));
    refusedFile("index.gltf", {"triangle 0 uses vertex 2", "there are 2"});
    write("loop.gltf", gltfTriangle(", \"children\": [0]"));
    refusedFile("loop.gltf", {"node 0 ('up') has more than one parent"});
    write("mesh.gltf", gltfTriangle(", \"mesh\": 7"));
    refusedFile("mesh.gltf", {"mesh.gltf"});
    write("text.gltf", "no json");
    refusedFile("text.gltf", {"text.gltf", "no glTF 2.0"});
    write("text.glb", "glTF no more");
    refusedFile("text.glb", {"text.glb"});
    const std::string whole = gltfTriangle("");
    for (std::size_t length = 0; length < whole.size(); length += 17) {
        write("cut.gltf", whole.substr(0, length));
        refusedFile("cut.gltf", {"cut.gltf"});
    }
    // Damage anywhere is refused or read, never more.
    for (std::size_t i = 0; i < whole.size(); i += 7) {
        std::string damaged = whole;
        damaged[i] = damaged[i] == '9' ? '1' : '9';
        write("damaged.gltf", damaged);
        try {
            mesh("damaged.gltf");
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
        }
    }
}

const char* kDroplet = "v 0 0 .1\nv .1 0 .1\nv 0 .1 .1\nv 0 0 .2\nf -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -2 -4 -1\n";

TEST_F(Meshes, ClosedMeshesSayWhatIsInThem) {
    write("closed.obj", kDroplet);
    const std::string keys = "kind = \"mesh\"\nfile = \"closed.obj\"";
    refusedSurface(keys, "s.toml:11:1", {"closed.obj", "is closed", "inside = \"glass\"", "event = \"mirror\""});
    for (const char* what :
         {"\nior_below = 1.5", "\ninside = \"water\"", "\nevent = \"reflect\"", "\nevent = \"mirror\""}) {
        const Surface surface = loadSurfaceKeys(keys + what).surfaces[0];
        EXPECT_TRUE(surface.closed);
        EXPECT_EQ(surface.closed_part, "");
        EXPECT_NEAR(glm::length(surface.center - glm::dvec3(0.05, 0.05, 0.15)), 0, 1e-12);
    }
    EXPECT_TRUE(warnings_.messages.empty());
    write("inward.obj", "v 0 0 .1\nv .1 0 .1\nv 0 .1 .1\nv 0 0 .2\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n");
    loadSurfaceKeys("kind = \"mesh\"\nfile = \"inward.obj\"\nior_below = 1.5");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("wound inwards"), std::string::npos);

    write("open.obj", kSplitSquare);
    const Scene scene = loadSurfaceKeys("kind = \"mesh\"\nfile = \"open.obj\"");
    ASSERT_TRUE(scene.surfaces[0].mesh);
    EXPECT_FALSE(scene.surfaces[0].height_field);
    EXPECT_FALSE(scene.surfaces[0].closed);
    EXPECT_EQ(scene.surfaces[0].mesh->positions.size(), 4u);
    EXPECT_EQ(
        loadSurfaceKeys("kind = \"mesh\"\nsmooth = false\nfile = \"open.obj\"").surfaces[0].mesh->positions.size(), 6u);
}

TEST_F(Meshes, AnOpenSheetIsNotCalledClosed) {
    // With a droplet over it, as splashes are; and with all faces there twice, as some programs write front and back.
    write("spray.obj", std::string(kSplitSquare) + kDroplet);
    const Surface spray = loadSurfaceKeys("kind = \"mesh\"\nfile = \"spray.obj\"").surfaces[0];
    EXPECT_FALSE(spray.closed);
    EXPECT_EQ(spray.closed_part, "4 vertices around (0.025, 0.025, 0.125)");
    const std::string corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n";
    write("double.obj", corners + "f 3 2 1\nf 4 3 1\n");
    refusedSurface("kind = \"mesh\"\nfile = \"double.obj\"", "s.toml:11:1", {"each face is there twice", "keep one"});
    write("some.obj", corners + "f 2 3 1\n");
    refusedSurface("kind = \"mesh\"\nfile = \"some.obj\"", "s.toml:11:1", {"1 of 3 faces are there twice"});
}

TEST_F(Meshes, WindingAgainstTheNeighboursIsSaid) {
    const std::string corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0.1\nv -1 1 0\nv 3 -1 0\nv 3 1 0\n";
    write("mixed.obj", corners + "f 1 2 3\nf 4 3 1\nf 2 5 6 3\n");
    loadSurfaceKeys("kind = \"mesh\"\nfile = \"mixed.obj\"");
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("1 of 4 faces, 25 % of the area, are wound against"), std::string::npos)
        << warnings_.messages[0];
    write("even.obj", corners + "f 1 2 3\nf 1 3 4\nf 2 5 6 3\n");
    loadSurfaceKeys("kind = \"mesh\"\nfile = \"even.obj\"");
    write("down.obj", corners + "f 3 2 1\nf 4 3 1\nf 3 6 5 2\n");  // all alike
    loadSurfaceKeys("kind = \"mesh\"\nfile = \"down.obj\"");
    EXPECT_EQ(warnings_.messages.size(), 1u);
}

TEST(MeshShapes, BoxAndSphereFaceOutwards) {
    const auto volume = [](const TriangleMesh& m) {
        double sum = 0;
        for (const auto& t : m.triangles)
            sum += glm::dot(m.positions[t[0]], glm::cross(m.positions[t[1]], m.positions[t[2]])) / 6;
        return sum;
    };
    const TriangleMesh box = boxMesh({1, 2, 3}, {2, 4, 6});
    EXPECT_NEAR(volume(box), 6, 1e-12);
    EXPECT_EQ(box.positions.size(), 36u);
    for (std::size_t i = 0; i < box.positions.size(); ++i)
        EXPECT_GT(glm::dot(box.normals[i], box.positions[i] - glm::dvec3(1.5, 3, 4.5)), 0.4);
    EXPECT_NEAR(volume(sphereMesh({1, 1, 1}, 2, 64)) / (4.0 / 3 * 3.14159265358979 * 8), 1, 2e-3);
}

TEST(MeshShapes, PartsAreCountedOpenAndClosed) {
    TriangleMesh mesh = sphereMesh({5, 0, 0}, 1, 8);
    EXPECT_TRUE(shapeOf(mesh).closed());
    EXPECT_NEAR(shapeOf(mesh).volume / (4.0 / 3 * 3.14159265358979), 1, 0.1);
    EXPECT_EQ(shapeOf(mesh).turned, 0u);
    EXPECT_EQ(shapeOf(mesh).doubled, 0u);
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    EXPECT_EQ(shapeOf(mesh).turned, 1u);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int i = 0; i < 3; ++i) mesh.positions.emplace_back(i, i * i, -3), mesh.normals.emplace_back(0, 0, 1);
    mesh.triangles.push_back({first, first + 1, first + 2});
    const MeshShape shape = shapeOf(mesh);
    EXPECT_EQ(shape.parts, 2u);
    EXPECT_EQ(shape.closed_parts, 1u);
    EXPECT_FALSE(shape.closed());
}

}  // namespace
}  // namespace photic
