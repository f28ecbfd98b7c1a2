// SPDX-License-Identifier: Apache-2.0
// Our writer's bytes against those of OpenVDB's.
#include "bake/volume/vdb_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "bake/volume/pack.h"
#include "tests/volume/vdb_files.h"

namespace photic {
namespace {

/// A grid's tree and values, from behind its transform to its end.
std::string treeBytes(const std::string& file) {
    const std::size_t map = file.find("AffineMap");
    return map == std::string::npos ? "" : file.substr(map + 9 + 16 * sizeof(double));
}

template <class Grid>
std::string ours(const Grid& grid, std::uint32_t compression, bool half) {
    VdbGridLayout layout;
    layout.name = grid.getName();
    layout.components = static_cast<int>(sizeof(typename Grid::ValueType) / sizeof(float));
    layout.half = half, layout.compression = compression;
    layout.transform = {glm::dmat3(0.5, 0, 0, 0, 0.25, 0, 0.1, 0, 0.5), {3, -4, 5}};  // gridOfLeaves()'
    std::vector<VdbTopology> leaves;
    std::vector<std::vector<float>> values;
    std::vector<std::pair<glm::ivec3, const typename Grid::TreeType::LeafNodeType*>> nodes;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        nodes.push_back({{leaf->origin().x(), leaf->origin().y(), leaf->origin().z()}, leaf.getLeaf()});
    std::reverse(nodes.begin(), nodes.end());
    std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return beforeInTree(a.first, b.first); });
    std::string tail;
    for (const auto& [origin, node] : nodes) {
        VdbTopology leaf{origin, {}};
        for (std::size_t w = 0; w < 8; ++w)
            leaf.mask[w] = node->getValueMask().template getWord<std::uint64_t>(static_cast<openvdb::Index>(w));
        leaves.push_back(leaf);
        std::string bytes(mostBytesOfLeaf(layout), 0);
        bytes.resize(encodeLeaf(layout, halfConversion(), leaf.mask,
                                reinterpret_cast<const float*>(node->buffer().data()), bytes.data()));
        tail += bytes;
    }
    return vdbGridHead(layout, leaves).bytes + tail;
}

template <class Grid>
void writesWhatOpenVdbWrites() {
    for (const unsigned seed : {1u, 2u, 3u})
        for (const bool half : {true, false})
            for (const std::uint32_t compression :
                 {0u, kPackedActive, kPackedActive | kPackedBlosc, kPackedActive | kPackedZip}) {
                auto grid = gridOfLeaves<Grid>(seed);
                grid->setSaveFloatAsHalf(half);
                grid->setGridClass(openvdb::GRID_UNKNOWN);  // OpenVDB zips no fog
                const std::string theirs = treeBytes(OpenVdbArchive().bytesOf({grid}, compression));
                ASSERT_GT(theirs.size(), 20000u);
                EXPECT_TRUE(theirs == treeBytes(ours(*grid, compression, half))) << half << ' ' << compression;
            }
}

TEST(VdbLayout, TreesOfFloatsAreThoseOfOpenVdb) { writesWhatOpenVdbWrites<openvdb::FloatGrid>(); }
TEST(VdbLayout, TreesOfVectorsAreThoseOfOpenVdb) { writesWhatOpenVdbWrites<openvdb::Vec3SGrid>(); }

/// Along the axes OpenVDB writes its simplest map: name and numbers are the same, where its own arithmetic is exact.
TEST(VdbLayout, TransformsAreThoseOfOpenVdb) {
    for (const glm::dvec3 scale : {glm::dvec3(0.25), glm::dvec3(0.25, 0.25, 0.5), glm::dvec3(0.125, 0.5, 4)}) {
        auto grid = openvdb::FloatGrid::create();
        grid->setTransform(openvdb::math::Transform::createLinearTransform(openvdb::math::Mat4d(
            scale.x, 0.0, 0.0, 0.0, 0.0, scale.y, 0.0, 0.0, 0.0, 0.0, scale.z, 0.0, 3.0, -4.0, 5.0, 1.0)));
        const std::string theirs = OpenVdbArchive().bytesOf({grid}, kPackedActive);
        VdbGridLayout layout;
        layout.name = "a";
        layout.transform = {glm::dmat3(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z), {3, -4, 5}};
        const std::string bytes = vdbGridHead(layout, {}).bytes;
        const std::string name = grid->transform().mapType();
        const std::size_t size = name.size() + 6 * 3 * sizeof(double);
        ASSERT_NE(theirs.find(name), std::string::npos);
        ASSERT_NE(bytes.find(name), std::string::npos) << name;
        EXPECT_EQ(bytes.substr(bytes.find(name), size), theirs.substr(theirs.find(name), size)) << name;
    }
}

TEST(VdbLayout, HalvesAreThoseOfOpenVdb) {
    std::vector<float> values;
    for (std::uint32_t bits = 0; bits < 0x7f800000u; bits += 40961)
        for (const float sign : {1.0f, -1.0f}) values.push_back(sign * std::bit_cast<float>(bits));
    std::vector<std::uint16_t> halves(values.size());
    std::vector<float> back(values.size());
    const HalfConversion convert = halfConversion();
    convert.toHalf(values.data(), values.size(), halves.data());
    convert.toFloat(reinterpret_cast<const char*>(halves.data()), halves.size(), back.data());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const openvdb::math::half theirs(values[i]);
        ASSERT_EQ(halves[i], theirs.bits()) << values[i];
        ASSERT_EQ(back[i], float(theirs));
    }
}

}  // namespace
}  // namespace photic
