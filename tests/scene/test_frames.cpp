// SPDX-License-Identifier: Apache-2.0
// What frames of a sequence share.
#include "bake/scene/kept_meshes.h"
#include "bake/scene/wave_field.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

class SharedFrames : public test::SceneTest {
protected:
    static const TriangleMesh* meshOf(const Scene& scene) {
        return std::get<std::shared_ptr<const TriangleMesh>>(scene.objects.front().shape).get();
    }
    Scene withMesh(const std::string& keys = "") {
        test::SceneText text;
        text.rest = "[[object]]\nname = \"rock\"\nfile = \"a.obj\"\n" + keys;
        return load(text);
    }
};

constexpr const char* kRock = "v 0 0 -1\nv 0.3 0 -1\nv 0 0.3 -1\nv 0 0 -0.8\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST_F(SharedFrames, MeshesAreReadOnceWhileTheyAreKept) {
    write("a.obj", kRock);
    const Scene alone = withMesh();
    const KeptMeshes kept;
    const Scene first = withMesh(), second = withMesh();
    EXPECT_EQ(meshOf(first), meshOf(second));
    EXPECT_NE(meshOf(first), meshOf(alone));
    // Of scenes that were read otherwise, nothing differs but that.
    EXPECT_EQ(first.hash, alone.hash);
    EXPECT_EQ(second.hash, alone.hash);
    EXPECT_EQ(meshOf(first)->positions, meshOf(alone)->positions);
    // Other keys, and other bytes under the name.
    EXPECT_EQ(meshOf(withMesh()), meshOf(first));
    EXPECT_NE(meshOf(withMesh("position = [0.1, 0, 0]\n")), meshOf(first));
    write("a.obj", std::string(kRock) + "v 0 0 -0.7\nf 1 3 5\n");
    const Scene changed = withMesh();
    EXPECT_EQ(meshOf(changed)->triangles.size(), 5U);
    EXPECT_NE(changed.hash, first.hash);
}

TEST_F(SharedFrames, MeshesThatNobodyAsksForGo) {
    write("a.obj", kRock);
    const KeptMeshes kept;
    std::weak_ptr<const TriangleMesh> mesh;
    {
        const Scene scene = withMesh();
        mesh = std::get<std::shared_ptr<const TriangleMesh>>(scene.objects.front().shape);
    }
    EXPECT_FALSE(mesh.expired());
    load(test::SceneText{});
    EXPECT_FALSE(mesh.expired());
    load(test::SceneText{});
    load(test::SceneText{});
    EXPECT_TRUE(mesh.expired());
}

TEST_F(SharedFrames, WhatIsSaidOfAMeshIsSaidOfEachFrame) {
    write("a.obj", std::string(kRock) + "f 1 1 2\n");  // a triangle without an area
    const KeptMeshes kept;
    withMesh();
    const auto first = warnings_.messages;
    ASSERT_FALSE(first.empty());
    warnings_.messages.clear();
    withMesh();
    EXPECT_EQ(warnings_.messages, first);
}

TEST_F(SharedFrames, ASeaThatRepeatsIsTheSameSceneAgain) {
    const auto at = [&](int frame, const std::string& period, const std::string& more = "") {
        test::SceneText text;
        text.surface = "[[surface]]\nname = \"water\"\nsize = [4, 4]\nsea = { wind_speed = 3, fetch = 300" + period +
                       ", resolution = 32 }\n" + more;
        return load(text, frame);
    };
    const auto height = [](const Scene& scene) {
        SurfaceRow row;
        scene.surfaces.front().height_field->row({0.3, 0.2}, 0.1, 4, row);
        return row.pz;
    };
    // Half a second is 12 frames of 24.
    const Scene first = at(5, ", period = 0.5"), again = at(29, ", period = 0.5"), other = at(28, ", period = 0.5");
    EXPECT_EQ(first.hash, again.hash);
    EXPECT_EQ(height(first), height(again));
    EXPECT_NE(first.hash, other.hash);
    EXPECT_NE(height(first), height(other));
    // Between two frames, never, and with something beside it that goes on.
    EXPECT_NE(at(5, ", period = 0.51").hash, at(29, ", period = 0.51").hash);
    EXPECT_NE(at(5, "").hash, at(29, "").hash);
    const std::string pond =
        "[[surface]]\nname = \"pond\"\ncenter = [9, 9, 0]\nsize = [1, 1]\nanimate = \"deep_water\"\n"
        "waves = [{ amplitude = 0.01, wavelength = 0.5, direction = 0, phase = 0 }]\n";
    EXPECT_NE(at(5, ", period = 0.5", pond).hash, at(29, ", period = 0.5", pond).hash);
}

}  // namespace
}  // namespace photic
