// SPDX-License-Identifier: Apache-2.0
// OBJ and PLY as programs write them: read whole, or refused by name.
#include <algorithm>
#include <cstring>
#include <glm/geometric.hpp>

#include "bake/scene/mesh_file.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;

const std::string kObjSquare = "v -1 -1 0\nv 1 -1 0\nv 1 1 0.1\nv -1 1 0\nf 1 2 3\nf 1 3 4\n";

class Containers : public SceneTest {
protected:
    TriangleMesh read(const std::string& name, const std::string& bytes) {
        write(name, bytes);
        return loadMesh(path(name), std::nullopt, warnings_, [](std::string_view) {});
    }
    void refusedFile(const std::string& name, const std::string& bytes, const std::vector<std::string>& words) {
        write(name, bytes);
        refused("photic = 1\n[[object]]\nfile = \"" + name + "\"\n", "s.toml:3:1", words);
    }
};

std::string utf16(const std::string& text, bool mark, bool big) {
    std::string out = mark ? (big ? "\xfe\xff" : "\xff\xfe") : "";
    for (const char c : text) out += big ? std::string{'\0', c} : std::string{c, '\0'};
    return out;
}

TEST_F(Containers, AByteOrderMarkIsNoVertex) {
    const TriangleMesh plain = read("a.obj", kObjSquare), marked = read("b.obj", "\xef\xbb\xbf" + kObjSquare);
    EXPECT_EQ(marked.positions, plain.positions);
    EXPECT_EQ(marked.triangles, plain.triangles);
    for (const bool big : {false, true})
        for (const bool mark : {false, true}) {
            refusedFile("u.obj", utf16(kObjSquare, mark, big), {"u.obj", "UTF-16", "save it as UTF-8"});
            refusedFile("u.ply", utf16("ply\nformat ascii 1.0\n", mark, big), {"u.ply", "UTF-16"});
            refusedFile("u.gltf", utf16("{\"asset\": 2}", mark, big), {"u.gltf", "UTF-16"});
        }
}

TEST_F(Containers, ObjLinesEndAndGoOnInEveryWay) {
    const TriangleMesh plain = read("a.obj", kObjSquare);
    std::string mac = kObjSquare, dos;
    std::replace(mac.begin(), mac.end(), '\n', '\r');
    for (const char c : kObjSquare) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
    EXPECT_EQ(read("b.obj", mac).positions, plain.positions);
    EXPECT_EQ(read("c.obj", dos).triangles, plain.triangles);
    EXPECT_EQ(read("d.obj", "v -1 -1 0\nv 1 \\\n -1 \\\r\n0\nv 1 1 0.1\nv -1 1 0\nf 1 2 \\\n3\nf 1 3 4\n").positions,
              plain.positions);
    EXPECT_EQ(read("e.obj", "# from C:\\\n" + kObjSquare).positions, plain.positions);  // no continuation
    EXPECT_EQ(read("f.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0.1\nv -1 1 0\nf -4 -3 -2\nf -4 -2 -1").triangles,
              plain.triangles);
    refusedFile("g.obj", "v 0 0 0\nv 1 \\\n0 \\\n0\nv 0 x 0\n", {"line 5", "'x' is no number"});
}

TEST_F(Containers, ObjFacesMayBeOfTheFirstVersionAndEndInComments) {
    const TriangleMesh plain = read("a.obj", kObjSquare);
    EXPECT_EQ(
        read("b.obj", "v -1 -1 0\nv 1 -1 0 # corner\nv 1 1 0.1\nv -1 1 0\nfo 1 2 3 # one\nf 1 3 4 #two\n").triangles,
        plain.triangles);
    EXPECT_EQ(read("c.obj", "v -1 -1 0 1\nv 1 -1 0 1\nv 1 1 0.1 0.2 0.3 0.4\nv -1 1 0\nf 1/9 2/9 3/9\nf 1// 3// 4//\n")
                  .triangles,
              plain.triangles);  // weights, colours, texture places
    refusedFile("d.obj", kObjSquare + "call rest.obj\n", {"line 7", "'call' takes in the file 'rest.obj'", "one file"});
    refusedFile("e.obj", kObjSquare + "f 1 2 # 3\n", {"line 7", "2 corners"});
}

TEST_F(Containers, AnObjWithoutFacesSaysWhatItHolds) {
    refusedFile("s.obj", "solid cube\nfacet normal 0 0 1\n", {"no triangles", "it begins with 'solid cube'"});
    refusedFile("g.obj", "version https://git-lfs.github.com/spec/v1\n", {"g.obj", "git lfs pull"});

    refusedFile("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", {"has no triangles", "2 vertices, 1 lines"});
    refusedFile("b.obj", "v 0 0 0\ncstype bezier\n", {"line 2", "'cstype'", "export triangles"});
    refusedFile("c.obj", std::string("v 0 0 0\nq\0\x01\n", 12), {"line 2", "no text"});
}

TEST_F(Containers, HollowFacesAreCutWhereTheyFit) {
    // A quad with a dent at its third corner, and an L of six corners: fans from the first corner would overlap.
    const auto area = [](const TriangleMesh& mesh) {
        double sum = 0;
        for (const auto& t : mesh.triangles)
            sum += 0.5 * glm::length(glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                                mesh.positions[t[2]] - mesh.positions[t[0]]));
        return sum;
    };
    EXPECT_NEAR(area(read("a.obj", "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n")), 4, 1e-12);
    EXPECT_NEAR(area(read("b.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n")), 3, 1e-12);
    // A comb has no corner that sees all of it.
    refusedFile(
        "c.obj",
        "v 0 0 0\nv 5 0 0\nv 5 3 0\nv 4 3 0\nv 4 1 0\nv 3 1 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"
        "f 1 2 3 4 5 6 7 8 9 10 11 12\n",
        {"line 13", "12 corners", "triangulate"});
}

const std::string kVertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kPoints = "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n";

TEST_F(Containers, PlyElementsComeInAnyOrder) {
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
    const TriangleMesh usual =
        read("a.ply", "ply\nformat ascii 1.0\n" + kVertices + faces + "end_header\n" + kPoints + "4 0 1 2 3\n");
    const TriangleMesh turned = read("b.ply", "ply\nformat ascii 1.0\n" + faces + "element edge 1\nproperty int v\n" +
                                                  kVertices + "end_header\n4 0 1 2 3\n7\n" + kPoints);
    EXPECT_EQ(turned.positions, usual.positions);
    EXPECT_EQ(turned.triangles, usual.triangles);
    refusedFile("c.ply", "ply\nformat ascii 1.0\n" + faces + kVertices + "end_header\n4 0 1 2 9\n" + kPoints,
                {"face 0 uses vertex 9", "the file has 4"});
    refusedFile("d.ply", "ply\nformat ascii 1.0\n" + kVertices + kVertices + "end_header\n",
                {"'vertex' is there twice"});
}

TEST_F(Containers, PlyInEveryByteOrderAndWithEveryLineEnd) {
    const auto body = [](bool big) {
        std::string bytes;
        const auto put = [&](auto value) {
            char raw[sizeof value];
            std::memcpy(raw, &value, sizeof value);
            if (big) std::reverse(raw, raw + sizeof value);
            bytes.append(raw, sizeof value);
        };
        for (int i = 0; i < 4; ++i) put(float(i == 1 || i == 2)), put(float(i >= 2)), put(0.25f);
        put(std::uint8_t(4));
        for (int i = 0; i < 4; ++i) put(i);
        return bytes;
    };
    std::vector<TriangleMesh> meshes;
    for (const bool big : {false, true})
        for (const std::string end : {"\n", "\r\n", "\r"}) {
            std::string header = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" +
                                 kVertices + "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
            for (std::size_t at = 0; (at = header.find('\n', at)) != header.npos; at += end.size())
                header.replace(at, 1, end);
            meshes.push_back(read("a.ply", header + body(big)));
        }
    for (const TriangleMesh& mesh : meshes) {
        EXPECT_EQ(mesh.positions, meshes[0].positions);
        EXPECT_EQ(mesh.positions[2], glm::dvec3(1, 1, 0.25));
        EXPECT_EQ(mesh.triangles.size(), 2u);
    }
    refusedFile("b.ply", "ply\nformat binary_middle_endian 1.0\n", {"binary_middle_endian", "save as ascii"});
}

TEST_F(Containers, PlyStripsAreRead) {
    const TriangleMesh mesh =
        read("a.ply", "ply\nformat ascii 1.0\n" + kVertices +
                          "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                          "-1 -1 0\n1 -1 0\n-1 1 0\n1 1 0\n8 0 1 2 3 -1 1 3 2\n");
    ASSERT_EQ(mesh.triangles.size(), 3u);
    for (const auto& t : mesh.triangles)  // all turn the same way
        EXPECT_GT(
            glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]).z, 0);
}

TEST_F(Containers, APlyWithoutFacesSaysWhatItHolds) {
    refusedFile("a.ply", "ply\nformat ascii 1.0\n" + kVertices + "end_header\n" + kPoints,
                {"has no triangles", "4 of 'vertex'"});
    refusedFile("b.ply",
                "ply\nformat ascii 1.0\n" + kVertices +
                    "element face 1\nproperty list uchar int corners\nend_header\n" + kPoints + "4 0 1 2 3\n",
                {"1 of 'face'", "not called vertex_indices"});
}

}  // namespace
}  // namespace photic
