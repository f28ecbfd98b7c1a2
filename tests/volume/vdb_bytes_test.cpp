// SPDX-License-Identifier: Apache-2.0
// Our reader against OpenVDB's writer, and against damage.
#include "bake/volume/vdb_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "bake/volume/byte_cursor.h"
#include "tests/volume/vdb_files.h"

namespace photic {
namespace {

constexpr std::uint32_t kNone = openvdb::io::COMPRESS_NONE, kMask = openvdb::io::COMPRESS_ACTIVE_MASK,
                        kBlosc = openvdb::io::COMPRESS_BLOSC, kZip = openvdb::io::COMPRESS_ZIP;
constexpr std::uint32_t kAllCompressions[] = {kNone, kMask, kBlosc, kZip, kBlosc | kMask, kZip | kMask};

/// Every active voxel of `grid`, tiles included, has the value that OpenVDB has; and there are no others.
template <class Grid>
void expectSame(const Grid& truth, const VdbGrid& grid, bool half) {
    ASSERT_EQ(grid.activeVoxels(), static_cast<std::int64_t>(truth.activeVoxelCount()));
    const auto accessor = truth.getConstAccessor();
    const auto rounded = [half](float v) { return half ? float(openvdb::math::half(v)) : v; };
    const auto component = [](const auto& value, int c) {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, float>)
            return c == 0 ? value : 0.0f;
        else
            return value[c];
    };
    std::vector<float> values(512u * static_cast<unsigned>(grid.components));
    for (const VdbLeaf& leaf : grid.leaves) {
        grid.values(leaf, values.data());
        const auto mask = grid.mask(leaf);
        for (int i = 0; i < 512; ++i) {
            const glm::ivec3 v = leaf.origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const openvdb::Coord at(v.x, v.y, v.z);
            const bool active = mask[std::size_t(i >> 6)] >> (i & 63) & 1;
            ASSERT_EQ(accessor.isValueOn(at), active);
            for (int c = 0; c < grid.components && active; ++c)
                ASSERT_EQ(values[std::size_t(i * grid.components + c)], rounded(component(accessor.getValue(at), c)));
        }
    }
}

template <class Grid>
void readsAllKinds(const char* type) {
    for (const bool tiles : {false, true})
        for (const bool half : {true, false})
            for (const std::uint32_t compression : kAllCompressions)
                for (const bool seekable : {true, false}) {
                    auto truth = gridOfLeaves<Grid>(3);
                    using Value = typename Grid::ValueType;
                    if (tiles) {
                        truth->tree().addTile(1, openvdb::Coord(64, 64, 64), Value(0.5f), true);
                        truth->tree().addTile(2, openvdb::Coord(512, 0, 0), Value(0.25f), true);
                        truth->tree().addTile(1, openvdb::Coord(80, 64, 64), Value(7.0f), false);
                    }
                    truth->setGridClass(openvdb::GRID_UNKNOWN);  // OpenVDB zips no fog
                    truth->setSaveFloatAsHalf(half);
                    const std::string bytes = OpenVdbArchive().bytesOf({truth}, compression, seekable);
                    VdbFile file = parseVdb(bytes.data(), bytes.size());
                    ASSERT_EQ(file.grids.size(), 1u);
                    VdbGrid& grid = file.grids.front();
                    EXPECT_EQ(grid.name, "irradiance");
                    EXPECT_EQ(grid.type, type);
                    ASSERT_TRUE(grid.transform);
                    EXPECT_EQ(grid.transform->world_from_index[2], glm::dvec3(0.1, 0, 0.5));
                    EXPECT_EQ(grid.transform->origin_world, glm::dvec3(3, -4, 5));
                    glm::ivec3 min, max;
                    ASSERT_TRUE(grid.activeBox(min, max));
                    const auto box = truth->evalActiveVoxelBoundingBox();
                    EXPECT_EQ(min, glm::ivec3(box.min().x(), box.min().y(), box.min().z()));
                    EXPECT_EQ(max, glm::ivec3(box.max().x(), box.max().y(), box.max().z()));
                    EXPECT_EQ(grid.tileVoxels(), tiles ? 512 + 128 * 128 * 128 : 0);
                    grid.expandTiles();
                    expectSame(*truth, grid, half);
                }
}

TEST(VdbBytes, FloatsAreThoseOfOpenVdb) { readsAllKinds<openvdb::FloatGrid>("float"); }
TEST(VdbBytes, VectorsAreThoseOfOpenVdb) { readsAllKinds<openvdb::Vec3SGrid>("vec3s"); }

TEST(VdbBytes, OtherGridsArePassedOver) {
    for (const bool seekable : {true, false}) {
        openvdb::GridPtrVec grids;
        auto doubles = openvdb::DoubleGrid::create();
        doubles->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(20)), 0.7);
        doubles->setTransform(openvdb::math::Transform::createLinearTransform(0.3));
        auto numbers = openvdb::Int32Grid::create();
        numbers->tree().setValue(openvdb::Coord(3, 4, 5), 6);
        auto shared = gridOfLeaves<openvdb::FloatGrid>(5);
        grids = {doubles, numbers, shared, shared->copyGrid()};
        grids.back()->setName("again");  // shares its tree
        if (seekable) {
            auto points = openvdb::BoolGrid::create();
            points->tree().setValue(openvdb::Coord(3, 4, 5), true);
            grids.insert(grids.begin(), points);
        }
        const std::string bytes = OpenVdbArchive().bytesOf(grids, kBlosc | kMask, seekable);
        const VdbFile file = parseVdb(bytes.data(), bytes.size());
        ASSERT_EQ(file.grids.size(), grids.size());
        const auto& last = file.grids.back();
        EXPECT_EQ(last.name, "again");
        expectSame(*shared, last, false);
        EXPECT_EQ(file.grids[file.grids.size() - 4].type, "double");
        EXPECT_EQ(file.grids[file.grids.size() - 4].components, 0);
    }
    auto points = openvdb::BoolGrid::create();
    const std::string bytes =
        OpenVdbArchive().bytesOf({points, gridOfLeaves<openvdb::FloatGrid>(5)}, kMask, /*seekable=*/false);
    EXPECT_THROW(parseVdb(bytes.data(), bytes.size()), VolumeFault);
}

TEST(VdbBytes, PerspectiveHasNoLinearTransform) {
    auto grid = gridOfLeaves<openvdb::FloatGrid>(1);
    grid->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(99)), 0.5, 10, 0.1));
    const std::string bytes = OpenVdbArchive().bytesOf({grid, gridOfLeaves<openvdb::FloatGrid>(2)}, kMask);
    const VdbFile file = parseVdb(bytes.data(), bytes.size());
    EXPECT_FALSE(file.grids.front().transform);
    EXPECT_TRUE(file.grids.back().transform);
}

/// Reads everything that there is to read of bytes that may be anything. @return whether they were accepted
bool readAll(const std::string& bytes) {
    // In memory of exactly their size, so that a sanitizer sees a byte too many.
    const std::unique_ptr<char[]> exact(new char[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), exact.get());
    try {
        VdbFile file = parseVdb(exact.get(), bytes.size());
        float values[3 * 512];
        for (VdbGrid& grid : file.grids) {
            if (grid.tileVoxels() < 1 << 26) grid.expandTiles();
            for (const VdbLeaf& leaf : grid.leaves) grid.values(leaf, values);
        }
        return true;
    } catch (const VolumeFault& fault) {
        EXPECT_GT(std::string(fault.what()).size(), 10u);
        return false;
    }
}

std::vector<std::string> smallFiles() {
    std::vector<std::string> files;
    for (const std::uint32_t compression : {kMask, kBlosc | kMask, kZip | kMask}) {
        auto white = openvdb::FloatGrid::create();
        auto* leaf = white->tree().touchLeaf(openvdb::Coord(0));
        std::mt19937 random(9);
        for (openvdb::Index i = 0; i < 512; i += 1 + random() % 3) leaf->setValueOn(i, valueOf(random));
        white->setSaveFloatAsHalf(true);
        auto vectors = openvdb::Vec3SGrid::create();
        vectors->tree().touchLeaf(openvdb::Coord(8, 0, 0))->setValueOn(77, openvdb::Vec3f(1, 2, 3));
        vectors->tree().addTile(1, openvdb::Coord(64, 64, 64), openvdb::Vec3f(1), true);
        files.push_back(OpenVdbArchive().bytesOf({white, vectors}, compression));
    }
    return files;
}

TEST(VdbBytes, EveryTruncationIsRefused) {
    for (const std::string& whole : smallFiles()) {
        EXPECT_TRUE(readAll(whole));
        // Nodes are thousands of zeros: of those every 61st, of the rest each.
        for (std::size_t length = 0;
             length<whole.size(); length += length> 4 && whole.substr(length - 4, 8) == std::string(8, 0) ? 61 : 1)
            ASSERT_FALSE(readAll(whole.substr(0, length))) << length;
    }
}

/// PHOTIC_MUTANTS files of each kind, 1000 if it is not set: scripts/test_slow mutants sets it.
int mutants() {
    const char* asked = std::getenv("PHOTIC_MUTANTS");
    return asked == nullptr ? 1000 : std::max(1000, std::atoi(asked));
}

TEST(VdbBytes, DamagedBytesAreRefusedOrRead) {
    std::mt19937 random(1234);
    int refused = 0, read = 0;
    const int count = mutants();
    for (const std::string& whole : smallFiles()) {
        // Half of the changes go to what is not a run of zeros, where the sizes stand.
        std::vector<std::size_t> telling;
        for (std::size_t i = 0; i < whole.size(); ++i)
            if (whole[i] != 0) telling.push_back(i);
        for (int n = 0; n < count; ++n) {
            std::string bytes = whole;
            for (unsigned changes = 1 + random() % 3; changes > 0; --changes) {
                const std::size_t at = random() % 2 ? telling[random() % telling.size()] : random() % bytes.size();
                constexpr unsigned char extreme[] = {0x00, 0x7f, 0x80, 0xff};
                bytes[at] = static_cast<char>(random() % 2 ? extreme[random() % 4] : random() & 255);
            }
            ++(readAll(bytes) ? read : refused);
        }
    }
    EXPECT_GT(refused, 300);
    EXPECT_GT(read, 300);  // a byte of a value is a value
}

TEST(VdbBytes, WhatIsWrongIsSaid) {
    const auto fault = [](const std::string& bytes) -> std::string {
        try {
            parseVdb(bytes.data(), bytes.size());
        } catch (const VolumeFault& f) {
            return f.what();
        }
        return "";
    };
    std::string bytes = smallFiles().front();
    EXPECT_EQ(fault("this is a text and no volume"), "it is no .vdb file");
    EXPECT_NE(fault(bytes.substr(0, 200)).find("ends too soon"), std::string::npos);
    bytes[8] = static_cast<char>(215);
    EXPECT_NE(fault(bytes).find("older than 222"), std::string::npos);
}

}  // namespace
}  // namespace photic

int main(int count, char** arguments) {
    testing::InitGoogleTest(&count, arguments);
    openvdb::initialize();
    return RUN_ALL_TESTS();
}
