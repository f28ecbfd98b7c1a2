// SPDX-License-Identifier: Apache-2.0
// A scene's surfaces as bodies with their own faces, for eye rays.
#include "bake/graded/sharp_bodies.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <string>

#include "bake/report/monitor.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

Scene sceneWith(const std::string& text) {
    Monitor monitor;
    return parseScene(
        "photic = 1\n[domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nvoxel_size = 0.05\n"
        "[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\n"
        "[[medium]]\nname = \"glass\"\nior = 1.52\nabsorption = [1, 2, 3]\n"
        "[[medium]]\nname = \"wine\"\nior = 1.345\npriority = 1\n" +
            text,
        "s.toml", "", 0, monitor);
}
std::string ball(const std::string& name, const std::string& inside, double radius, const std::string& more = "") {
    return fmt::format(
        "[[surface]]\nname = \"{}\"\nkind = \"sphere\"\nposition = [0.1, 0, -0.2]\nradius = {}\ninside = \"{}\"\n{}",
        name, radius, inside, more);
}
SharpScene sharpOf(const Scene& scene) {
    Monitor monitor;
    return sharpBodiesOf(scene, {scene.domain.voxel_size, {scene.domain.min, scene.domain.max}}, monitor);
}
const SharpBody* named(const SharpScene& scene, const std::string& name) {
    const auto at = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                 [&](const SharpBody& body) { return body.name == name; });
    return at == scene.bodies.end() ? nullptr : &*at;
}

TEST(SharpBodies, OfHigherPriorityAndSmallerOnesAreWhatIsThere) {
    const SharpScene sharp =
        sharpOf(sceneWith(ball("core", "glass", 0.1) + ball("drop", "wine", 0.3) + ball("shell", "glass", 0.2)));
    ASSERT_EQ(sharp.bodies.size(), 3U);
    const SharpBody &core = *named(sharp, "core"), &drop = *named(sharp, "drop"), &shell = *named(sharp, "shell");
    EXPECT_GT(drop.rank, core.rank);
    EXPECT_GT(core.rank, shell.rank);
    EXPECT_EQ(shell.index, glm::dvec3(1.52));
    EXPECT_EQ(shell.absorption, glm::dvec3(1, 2, 3));
    ASSERT_TRUE(shell.ball && !shell.samples);
    const glm::dvec3 centre = shell.origin_world + shell.world_from_node * glm::dvec3(*shell.ball);
    EXPECT_LT(glm::distance(centre, glm::dvec3(0.1, 0, -0.2)), 1e-6);
    EXPECT_NEAR(double(shell.ball->w) * shell.world_from_node[0][0], 0.2, 1e-6);
    EXPECT_TRUE(sharp.others.empty() && sharp.notes.empty());
}

TEST(SharpBodies, HaveTheirTrianglesAndNormals) {
    Scene scene = sceneWith(ball("body", "glass", 0.1));
    Surface& surface = scene.surfaces.front();
    const TriangleMesh mesh = sphereMesh({0.3, 0.2, 0.1}, 0.25, 12);
    surface.sphere.reset(), surface.mesh = std::make_shared<const TriangleMesh>(mesh);
    const SharpScene smooth = sharpOf(scene);
    const SharpBody& body = smooth.bodies.at(0);
    EXPECT_EQ(body.triangles, mesh.triangles);
    ASSERT_EQ(body.positions.size(), mesh.positions.size());
    ASSERT_EQ(body.normals.size(), mesh.normals.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::dvec3 at = body.origin_world + body.world_from_node * glm::dvec3(body.positions[i]);
        EXPECT_LT(glm::distance(at, mesh.positions[i]), 1e-6);
        EXPECT_LT(glm::distance(glm::dvec3(body.normals[i]), mesh.normals[i]), 1e-6);
    }
    surface.smooth = false;
    EXPECT_TRUE(sharpOf(scene).bodies.at(0).normals.empty());
    surface.thin = true;
    EXPECT_EQ(sharpOf(scene).bodies.at(0).faces, SharpFaces::Thin);
    surface.event = SurfaceEvent::Mirror, surface.thin = false;
    EXPECT_EQ(sharpOf(scene).bodies.at(0).faces, SharpFaces::Mirror);
    surface.event = SurfaceEvent::Both, surface.closed = false;
    const SharpScene open = sharpOf(scene);
    EXPECT_TRUE(open.bodies.empty());
    ASSERT_EQ(open.notes.size(), 1U);
    EXPECT_NE(open.notes[0].find("open"), std::string::npos) << open.notes[0];
}

TEST(SharpBodies, AreFilledWithWhatVariesOrScatters) {
    const std::string media =
        "[[medium]]\nname = \"core\"\nindex = { kind = \"fish_eye\", n0 = 1.6, scale = 0.8, center = [0.1, 0, -0.2] }\n"
        "[[medium]]\nname = \"milk\"\nior = 1.35\nscattering = 20\n";
    const SharpScene sharp = sharpOf(sceneWith(media + ball("lens", "core", 0.4) + ball("drop", "milk", 0.2)));
    ASSERT_EQ(sharp.bodies.size(), 2U);
    EXPECT_TRUE(sharp.others.empty()) << "what fills a body is not beside it once more";
    const SharpBody &lens = *named(sharp, "lens"), &drop = *named(sharp, "drop");
    ASSERT_TRUE(lens.samples && lens.ball && drop.samples);
    EXPECT_TRUE(lens.samples->faces.empty() && !lens.samples->sharp_sides);
    // The index goes on beyond the ball: (n^2 - 1) / 2 in its middle and a node beyond its face.
    const glm::ivec3 count = lens.samples->count, middle = count / 2;
    const auto at = [&](const glm::ivec3& p) {
        return double(lens.samples->spline[0][static_cast<std::size_t>((p.z * count.y + p.y) * count.x + p.x)]);
    };
    const auto truth = [&](const glm::ivec3& p) {
        const glm::dvec3 place = lens.origin_world + lens.world_from_node * glm::dvec3(p);
        const double r = glm::distance(place, glm::dvec3(0.1, 0, -0.2)), n = 1.6 / (1 + r * r / 0.64);
        return (n * n - 1) / 2;
    };
    const glm::ivec3 beyond = middle + glm::ivec3(9, 0, 0);  // 0.45 m off
    EXPECT_NEAR(at(middle), truth(middle), 0.02);
    EXPECT_NEAR(at(beyond), truth(beyond), 0.03);
    for (int a = 0; a < 3; ++a) {
        EXPECT_LE(lens.samples->box_low[a], (*lens.ball)[a] - lens.ball->w);
        EXPECT_GE(lens.samples->box_high[a], (*lens.ball)[a] + lens.ball->w);
    }
    EXPECT_EQ(drop.filling->scattering, glm::dvec3(20));
    EXPECT_NEAR(double(drop.samples->spline[0][0]), (1.35 * 1.35 - 1) / 2, 1e-6);
}

TEST(SharpBodies, SayWhatEyeRaysSeeOtherwise) {
    const Scene scene = sceneWith(ball("ball", "glass", 0.2, "outside = \"wine\"\n"));
    const SharpScene sharp = sharpOf(scene);
    ASSERT_EQ(sharp.notes.size(), 1U);
    EXPECT_NE(sharp.notes[0].find("in air"), std::string::npos) << sharp.notes[0];
    // Within a body of that medium all is well.
    const SharpScene within =
        sharpOf(sceneWith(ball("ball", "glass", 0.2, "outside = \"wine\"\n") + ball("sea", "wine", 0.6)));
    EXPECT_TRUE(within.notes.empty());
}

TEST(SharpBodies, AreSamplesWhereThatIsAskedFor) {
    const Scene scene = withSampledBodies(sceneWith(ball("ball", "glass", 0.2)));
    ASSERT_TRUE(scene.index);
    ASSERT_EQ(scene.index->objects().size(), 1U);
    EXPECT_EQ(scene.index->objects()[0].name, "glass");
    EXPECT_TRUE(scene.index->objects()[0].enclosed);
    EXPECT_NEAR(scene.index->objects()[0].index[0]->indexAt({0.1, 0, -0.2}), 1.52, 1e-9);
}

}  // namespace
}  // namespace photic
