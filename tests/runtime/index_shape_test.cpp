// SPDX-License-Identifier: Apache-2.0
// Shapes with sharp faces in files of index volumes: read as written, damaged ones refused, their trees sound, and
// their texels as docs/index_volumes.md says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <random>

#include "bake/file/index_volume_file.h"
#include "bake/scene/mesh_file.h"
#include "photic/index_volume.h"
#include "photic/index_volume_bytes.h"
#include "runtime/format/index_volume_format.h"
#include "runtime/src/index_volume_data.h"
#include "runtime/src/shape_tree.h"

namespace photic::runtime {
namespace {

IndexVolumeObject shaped(const TriangleMesh& mesh) {
    IndexVolumeObject object;
    object.name = "glass";
    object.world_from_node = glm::dmat3(0.5);
    object.shape.emplace();
    object.shape->index = {1.5, 1.51, 1.52};
    object.shape->absorption = {1, 2, 3};
    object.shape->rank = 7;
    for (const glm::dvec3& p : mesh.positions) object.shape->positions.emplace_back(p);
    for (const glm::dvec3& n : mesh.normals) object.shape->normals.emplace_back(n);
    object.shape->triangles = mesh.triangles;
    return object;
}
IndexVolumeObject ball() {
    IndexVolumeObject object = shaped({});
    object.shape->ball = {1, 2, 3, 4};
    return object;
}
/// With samples of its inside, and a mesh in their box.
IndexVolumeObject filled() {
    IndexVolumeObject object = shaped(sphereMesh({5, 5, 5}, 3, 6));
    object.count = {11, 11, 11};
    object.box_low = glm::vec3(1), object.box_high = glm::vec3(9);
    object.spline = {std::vector<float>(11 * 11 * 11, 0.4F)};
    return object;
}

Result<std::vector<IndexVolume>> readCopy(const std::string& bytes, std::size_t size) {
    // A block of just this size, so that a sanitizer sees the first byte beyond.
    const std::unique_ptr<char[]> copy(new char[size]);
    std::copy_n(bytes.begin(), size, copy.get());
    LoadOptions modest;
    modest.largest_memory = 1 << 20;
    return readIndexVolumes(copy.get(), size, modest);
}

TEST(IndexShapes, AreReadAsTheyWereWritten) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 2, 6);
    const std::string bytes = indexVolumeBytes({shaped(mesh), ball(), filled()});
    EXPECT_EQ(bytes[8], 3);
    const auto volumes = readCopy(bytes, bytes.size());
    ASSERT_TRUE(volumes.ok()) << volumes.error().message;
    const IndexVolume& glass = (*volumes)[0];
    EXPECT_EQ(glass.shape(), IndexShape::Mesh);
    EXPECT_EQ(glass.triangles(), mesh.triangles.size());
    EXPECT_EQ(glass.nodes(), (std::array<int, 3>{0, 0, 0}));
    EXPECT_TRUE(glass.disperses());
    EXPECT_EQ(glass.bytes(), 12 * (2 * mesh.positions.size() + mesh.triangles.size()));
    EXPECT_EQ(glass.at({0, 0, 0}).half_square, 0.5);
    Vec3 low, high;
    glass.box(low, high);
    EXPECT_NEAR(low.z, -2, 1e-6);
    EXPECT_NEAR(high.z, 2, 1e-6);
    const auto& shape = glass.data().shape;
    EXPECT_EQ(shape->absorption[2], 3);
    EXPECT_EQ(shape->rank, 7U);
    EXPECT_EQ(shape->triangles, mesh.triangles);
    EXPECT_EQ((*volumes)[1].shape(), IndexShape::Ball);
    EXPECT_EQ((*volumes)[1].data().shape->ball[3], 4);
    EXPECT_EQ((*volumes)[2].shape(), IndexShape::Mesh);
    EXPECT_NEAR((*volumes)[2].at({2.5, 2.5, 2.5}).half_square, 0.9, 1e-6);
    EXPECT_FALSE((*volumes)[2].disperses());
}

TEST(IndexShapes, EveryTruncatedLengthIsRefused) {
    const std::string bytes = indexVolumeBytes({filled(), ball()});
    for (std::size_t size = 0; size < bytes.size(); size += size < 1000 ? 1 : 7) {
        const auto volumes = readCopy(bytes, size);
        ASSERT_FALSE(volumes.ok()) << size;
        ASSERT_EQ(volumes.error().code, ErrorCode::Format) << volumes.error().message;
        // Nor does it help to say the size that is left.
        if (size < 32) continue;
        std::string told = bytes.substr(0, size);
        const std::uint64_t says = size;
        std::memcpy(told.data() + format::kIndexFileSizeAt, &says, sizeof(says));
        ASSERT_FALSE(readCopy(told, size).ok()) << size;
    }
}

TEST(IndexShapes, MutationsDoNoHarm) {
    const std::vector<std::string> files = {indexVolumeBytes({shaped(sphereMesh({0, 0, 0}, 2, 5))}),
                                            indexVolumeBytes({filled()}), indexVolumeBytes({ball()})};
    std::mt19937_64 random(5);
    int loaded = 0, refused = 0;
    for (int n = 0; n < 3000; ++n) {
        const std::string& file = files[static_cast<std::size_t>(n) % files.size()];
        std::string damaged = file;
        for (std::uint64_t k = 0; k < 1 + random() % 3; ++k) {
            const std::size_t at =
                random() % 3 ? random() % std::min<std::size_t>(448, file.size()) : random() % file.size();
            static constexpr std::uint64_t kNasty[] = {0, 1, 0x80, 0xffffffff, 0x7f800000, ~0ULL, 1ULL << 63, 4096};
            const std::uint64_t value = random() % 2 ? random() : kNasty[random() % std::size(kNasty)];
            std::memcpy(damaged.data() + at, &value, std::min<std::size_t>(1U << random() % 4, file.size() - at));
        }
        const auto volumes = readCopy(damaged, damaged.size());
        if (!volumes) {
            ++refused;
            continue;
        }
        ++loaded;
        EXPECT_TRUE(packIndexVolumes(*volumes).ok());
    }
    EXPECT_GT(loaded, 100);
    EXPECT_GT(refused, 100);
}

struct Damage {
    const char *name, *word;
    void (*apply)(IndexVolumeObject&);
};
class ShapeDamages : public testing::TestWithParam<Damage> {};
TEST_P(ShapeDamages, IsRefusedInWords) {
    IndexVolumeObject object = filled();
    GetParam().apply(object);
    const std::string file = indexVolumeBytes({object});
    const auto volumes = readCopy(file, file.size());
    ASSERT_FALSE(volumes.ok());
    EXPECT_NE(volumes.error().message.find(GetParam().word), std::string::npos) << volumes.error().message;
    EXPECT_NE(volumes.error().message.find("'glass'"), std::string::npos) << volumes.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    All, ShapeDamages,
    testing::Values(
        Damage{"index", "index", [](IndexVolumeObject& o) { o.shape->index.y = 0; }},
        Damage{"absorption", "absorption", [](IndexVolumeObject& o) { o.shape->absorption.x = -1; }},
        Damage{"colour", "colour", [](IndexVolumeObject& o) { o.shape->colour.z = std::nan(""); }},
        Damage{"rank", "rank", [](IndexVolumeObject& o) { o.shape->rank = 256; }},
        Damage{"place", "no place", [](IndexVolumeObject& o) { o.shape->positions[3].x = std::nanf(""); }},
        Damage{"box", "out of the box", [](IndexVolumeObject& o) { o.shape->positions[3].x = 9.5F; }},
        Damage{"normal", "length 1", [](IndexVolumeObject& o) { o.shape->normals[2] = glm::vec3(0); }},
        Damage{"vertex", "a triangle of vertex", [](IndexVolumeObject& o) { o.shape->triangles[4][1] = 9999; }},
        Damage{"few", "vertices for", [](IndexVolumeObject& o) { o.shape->triangles.resize(2); }},
        Damage{"faces", "later version",
               [](IndexVolumeObject& o) { o.shape->faces = static_cast<photic::SharpShape::Faces>(9); }},
        Damage{"sides", "sharp sides", [](IndexVolumeObject& o) { o.sharp_sides = true; }},
        Damage{"radius", "radius", [](IndexVolumeObject& o) { o.shape->triangles.clear(), o.shape->ball.w = 0; }},
        Damage{
            "pane", "pane",
            [](IndexVolumeObject& o) { o.shape->triangles.clear(), o.shape->faces = photic::SharpShape::Faces::Thin; }},
        Damage{"arrays", "no nodes", [](IndexVolumeObject& o) { o.count = glm::ivec3(0); }},
        Damage{"axes", "along some axes",
               [](IndexVolumeObject& o) {
                   o.count = {0, 4, 4};
               }}),
    [](const auto& param_info) { return std::string(param_info.param.name); });

runtime::SharpShape shapeOf(const TriangleMesh& mesh) {
    runtime::SharpShape shape;
    for (const glm::dvec3& p : mesh.positions) shape.positions.push_back({float(p.x), float(p.y), float(p.z)});
    shape.triangles = mesh.triangles;
    return shape;
}

/// Every triangle is in one leaf, within all boxes on the way to it. @return how deep the deepest leaf lies
int checked(const runtime::SharpShape& shape) {
    const ShapeTree tree(shape);
    std::vector<int> met(shape.triangles.size(), 0);
    int deepest = 0;
    struct Entry {
        ShapeTree::Child child;
        ShapeTree::Box within;
        int depth;
    };
    std::vector<Entry> waiting;
    for (const auto& child : tree.nodes.at(0)) waiting.push_back({child, child.box, 1});
    while (!waiting.empty()) {
        const Entry at = waiting.back();
        waiting.pop_back();
        deepest = std::max(deepest, at.depth);
        if (at.child.to >= 0) {
            for (const auto& child : tree.nodes.at(static_cast<std::size_t>(at.child.to)))
                waiting.push_back({child, child.box, at.depth + 1});
            continue;
        }
        const auto code = static_cast<std::uint32_t>(~at.child.to);
        EXPECT_LE(code & 7, ShapeTree::kMostInLeaf);
        for (std::uint32_t k = 0; k < (code & 7); ++k) {
            const std::uint32_t t = tree.order.at((code >> 3) + k);
            ++met.at(t);
            for (const std::uint32_t v : shape.triangles[t])
                for (std::size_t a = 0; a < 3; ++a) {
                    EXPECT_GE(shape.positions[v][a], at.within.low[a]);
                    EXPECT_LE(shape.positions[v][a], at.within.high[a]);
                }
        }
    }
    for (const int times : met) EXPECT_EQ(times, 1);
    return deepest;
}

TEST(ShapeTrees, HoldEachTriangleOnceAndAreShallow) {
    EXPECT_LE(checked(shapeOf(sphereMesh({0, 0, 0}, 1, 2))), 4);
    EXPECT_LE(checked(shapeOf(boxMesh({0, 0, 0}, {1, 2, 3}))), 4);
    EXPECT_LE(checked(shapeOf(sphereMesh({0, 0, 0}, 1, 64))), 18);
    // All in one place, and each twice as far out as the one before: what splits badly.
    runtime::SharpShape same, far;
    same.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    same.triangles.assign(5000, {0, 1, 2});
    float place = 1e-30F;
    for (std::uint32_t t = 0; t < 160; ++t, place *= 1.6F) {
        for (const float y : {0.0F, place, -place}) far.positions.push_back({place, y, 0});
        far.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    EXPECT_LE(checked(same), 12);
    EXPECT_LE(checked(far), ShapeTree::kMostDeep);
    // One triangle: a root with a leaf and nothing.
    runtime::SharpShape one = same;
    one.triangles.resize(1);
    EXPECT_EQ(checked(one), 1);
}

// What lies where, by the page alone: header, nodes, corners, normals.
TEST(IndexShapes, TexelsAreAsThePageSays) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 2, 6);
    const std::string file = indexVolumeBytes({ball(), shaped(mesh)});
    const auto volumes = readCopy(file, file.size());
    ASSERT_TRUE(volumes.ok());
    const auto bytes = packIndexVolumes(*volumes);
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    EXPECT_EQ(bytes->shapes.format, TexelFormat::Rgba32Uint);
    EXPECT_EQ(bytes->shapes.size[0], 2048U);
    const auto number = [&](std::size_t texel, std::size_t c, auto as) {
        std::memcpy(&as, bytes->shapes.texels.data() + 16 * texel + 4 * c, 4);
        return as;
    };
    const float origin[3] = {0, 0, 0};
    const auto block = packBentParameters(origin, *bytes, {{1}, {0}});
    ASSERT_TRUE(block.ok());
    const auto placed = [&](std::size_t object, std::size_t c) {
        std::int32_t value;
        std::memcpy(&value, block->data() + 2768 + 16 * object + 4 * c, 4);
        return value;
    };
    EXPECT_EQ(placed(1, 0), 0);
    EXPECT_EQ(placed(0, 1), 7);
    EXPECT_EQ(placed(0, 2), 0);        // of glass, smooth, without samples
    EXPECT_EQ(placed(1, 2), 256 * 2);  // a ball
    EXPECT_EQ(placed(0, 3), 3);        // both lie in one place
    EXPECT_NEAR(number(0, 1, 0.0F), 0.5 * (1.51 * 1.51 - 1), 1e-6);
    EXPECT_EQ(number(3, 3, 0.0F), 4);  // the ball's radius
    const auto at = static_cast<std::size_t>(placed(0, 0));
    EXPECT_EQ(number(at + 1, 1, 0.0F), 2);  // absorption
    const std::size_t corners = number(at + 3, 1, 0U), normals = number(at + 3, 2, 0U), count = number(at + 3, 3, 0U);
    ASSERT_EQ(count, mesh.triangles.size());
    EXPECT_EQ(number(at + 3, 0, 0U), at + 4);
    double area = 0;
    for (std::size_t t = 0; t < count; ++t) {
        glm::dvec3 p[3], n[3];
        for (std::size_t k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c) {
                p[k][c] = double(number(corners + 3 * t + k, static_cast<std::size_t>(c), 0.0F));
                n[k][c] = double(number(normals + 3 * t + k, static_cast<std::size_t>(c), 0.0F));
            }
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(glm::length(p[k] - 2.0 * n[k]), 0, 1e-5);
        area += 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
    }
    EXPECT_NEAR(area, 16 * M_PI, 5);
    // The root's boxes hold the ball.
    EXPECT_NEAR(std::min(number(at + 4, 2, 0.0F), number(at + 6, 2, 0.0F)), -2, 1e-6);
    EXPECT_NEAR(std::max(number(at + 5, 2, 0.0F), number(at + 7, 2, 0.0F)), 2, 1e-6);
}

TEST(IndexShapes, TooManyForATextureAreRefused) {
    const std::string file = indexVolumeBytes({shaped(sphereMesh({0, 0, 0}, 2, 64))});
    const auto volumes = readIndexVolumes(file.data(), file.size());
    ASSERT_TRUE(volumes.ok());
    const auto bytes = packIndexVolumes(*volumes, 16);
    ASSERT_FALSE(bytes.ok());
    EXPECT_EQ(bytes.error().code, ErrorCode::Limit);
    EXPECT_NE(bytes.error().message.find("fewer triangles"), std::string::npos) << bytes.error().message;
}

}  // namespace
}  // namespace photic::runtime
