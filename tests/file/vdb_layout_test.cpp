// SPDX-License-Identifier: Apache-2.0
// The file as others see it: through OpenVDB itself, and files that others wrote.
#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>

#include "bake/file/vdb.h"
#include "bake/libraries/openvdb.h"
#include "bake/report/error.h"
#include "runtime/format/light_volume_format.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

std::map<std::string, openvdb::GridBase::Ptr> openAll(const std::string& path) {
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open();
    std::map<std::string, openvdb::GridBase::Ptr> grids;
    const auto found = file.getGrids();
    for (const auto& grid : *found) grids[grid->getName()] = grid;
    return grids;
}

TEST(VdbLayout, GridsAreWhatTheContractSays) {
    const TemporaryFolder folder;
    for (const bool coloured : {false, true}) {
        const GridFrame frame = leaningFrame({-9, 3, -20}, {14, 17, 3}, 1.0 / 64);
        const LightVolume volume = testVolume(frame, coloured, [](const glm::ivec3& v) { return v.y != 7; });
        const auto active = writeVdb(folder / "a.vdb", volume, {});
        const auto grids = openAll(folder / "a.vdb");
        ASSERT_EQ(grids.size(), 2u);
        const auto direction = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids.at(format::kDirection));
        ASSERT_TRUE(direction);
        EXPECT_EQ(direction->getVectorType(), openvdb::VEC_CONTRAVARIANT_RELATIVE);
        EXPECT_EQ(grids.at(format::kIrradiance)->valueType(), coloured ? "vec3s" : "float");
        for (const auto& [name, grid] : grids) {
            EXPECT_EQ(grid->activeVoxelCount(), static_cast<std::uint64_t>(active));
            EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
            EXPECT_TRUE(grid->saveFloatAsHalf());
            EXPECT_GT(grid->baseTree().leafCount(), 0u);
            EXPECT_EQ(grid->transform(), direction->transform());
            EXPECT_EQ(grid->metaValue<int>(format::kMetaVersion), format::kVersion);
            EXPECT_EQ(grid->metaValue<double>(format::kMetaReferenceIrradiance), 1000);
        }
        if (!coloured) {
            EXPECT_TRUE(openvdb::gridPtrCast<openvdb::FloatGrid>(grids.at(format::kIrradiance))
                            ->constTree()
                            .hasSameTopology(direction->constTree()));
        }

        // Positions: voxel (i,j,k) is centred at transform(i,j,k) and holds the light of that point.
        double largest = 0;
        for (auto it = direction->cbeginValueOn(); it; ++it) {
            const auto ijk = it.getCoord();
            const auto w = direction->transform().indexToWorld(ijk);
            const glm::dvec3 world(w.x(), w.y(), w.z());
            ASSERT_LT(glm::length(world - frame.worldFromIndex({ijk.x(), ijk.y(), ijk.z()})), 1e-12);
            const auto light = testLight(world);
            largest = std::max(largest, glm::length(glm::dvec3((*it)[0], (*it)[1], (*it)[2]) - light.direction));
        }
        EXPECT_LT(largest, 1e-3);
    }
}

TEST(VdbLayout, CubicGridsHaveTheSimplestTransform) {
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", testVolume(straightFrame(glm::ivec3(0), glm::ivec3(7), 0.25), false), {});
    EXPECT_EQ(openAll(folder / "a.vdb").at("irradiance")->transform().mapType(),
              openvdb::math::UniformScaleTranslateMap::mapType());
    GridFrame flat = straightFrame(glm::ivec3(0), glm::ivec3(7), 0.25);
    flat.setWorldFromIndex({0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.5});
    writeVdb(folder / "b.vdb", testVolume(flat, false), {});
    EXPECT_EQ(openAll(folder / "b.vdb").at("irradiance")->transform().mapType(),
              openvdb::math::ScaleTranslateMap::mapType());
}

TEST(VdbLayout, OneGridCanBeOpenedAlone) {
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", testVolume(straightFrame(glm::ivec3(0), glm::ivec3(31), 0.1), false), {});
    openvdb::io::File file(folder / "a.vdb");
    file.open(false);
    EXPECT_TRUE(file.hasGrid("direction"));
    const auto grid = file.readGrid("direction");
    EXPECT_EQ(grid->activeVoxelCount(), 32u * 32 * 32);
    EXPECT_EQ(file.getMetadata()->metaValue<std::string>(format::kMetaUpAxis), "Z");
}

TEST(VdbLayout, InterpolatedFluxIsNotTheProductOfInterpolations) {
    // The contract's form is flux = irradiance * direction, interpolated; readers that interpolate the grids apart
    // differ.
    GridFrame frame = straightFrame(glm::ivec3(0), glm::ivec3(7), 1);
    LightVolume volume = testVolume(frame, false);
    for (int i = 0; i < 512; ++i) {
        float* leaf = volume.field.dense(0);
        const bool even = (i >> 6) % 2 == 0;
        leaf[i] = even ? 1000.0f : 200.0f;
        leaf[512 + i] = even ? 0 : 200, leaf[1024 + i] = 0, leaf[1536 + i] = even ? -1000.0f : 0;
    }
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", volume, {});
    const auto grids = openAll(folder / "a.vdb");
    const openvdb::Vec3d point(2.5, 3, 3);
    const auto e = openvdb::tools::BoxSampler::sample(
        openvdb::gridPtrCast<openvdb::FloatGrid>(grids.at("irradiance"))->constTree(), point);
    const auto d = openvdb::tools::BoxSampler::sample(
        openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids.at("direction"))->constTree(), point);
    EXPECT_NEAR(e * -d[2], 0.3, 1e-3);  // apart: 0.6 * 0.5
    const LightVolume back = readVdb(folder / "a.vdb");
    EXPECT_NEAR(0.5 * (-back.field.flux({2, 3, 3}).z - back.field.flux({3, 3, 3}).z) / 1000, 0.5,
                1e-3);  // the flux itself
}

// Files that others wrote.

void writeForeign(const std::string& path, const openvdb::GridPtrVec& grids) {
    openvdb::io::File file(path);
    file.write(grids);
}

std::string refusal(const std::string& path) {
    try {
        readVdb(path);
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::Input);
        return e.what();
    }
    return "";
}

TEST(ForeignVdb, IrradianceAloneIsEnoughAndTilesAreExpanded) {
    openvdb::initialize();
    const TemporaryFolder folder;
    auto grid = openvdb::FloatGrid::create(0);
    grid->setName("irradiance");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->fill(openvdb::CoordBBox(openvdb::Coord(-20), openvdb::Coord(30)), 2.5f, true);
    ASSERT_GT(grid->tree().activeTileCount(), 0u);
    writeForeign(folder / "a.vdb", {grid});
    const LightVolume volume = readVdb(folder / "a.vdb");
    EXPECT_EQ(volume.field.needed().count(), 51 * 51 * 51);
    EXPECT_EQ(volume.reference_irradiance, 1);
    EXPECT_FALSE(volume.has_direction);
    EXPECT_FALSE(volume.field.channels().flux);
    EXPECT_NEAR(volume.field.sum(0), 2.5 * 51 * 51 * 51, 1e-3);
    EXPECT_EQ(volume.field.frame().worldFromIndex({2, 4, -6}), glm::dvec3(1, 2, -3));
    // It can be written again, without a direction.
    writeVdb(folder / "b.vdb", volume, {});
    EXPECT_EQ(openAll(folder / "b.vdb").size(), 1u);
}

TEST(ForeignVdb, WhatIsNoLightVolumeIsRefusedByName) {
    openvdb::initialize();
    const TemporaryFolder folder;
    const auto named = [](openvdb::GridBase::Ptr grid, const char* name) {
        grid->setName(name);
        return grid;
    };
    writeForeign(folder / "a.vdb", {named(openvdb::FloatGrid::create(0), "temperature")});
    EXPECT_NE(refusal(folder / "a.vdb").find("temperature (float)"), std::string::npos);
    writeForeign(folder / "a.vdb", {named(openvdb::Int32Grid::create(0), "irradiance")});
    EXPECT_NE(refusal(folder / "a.vdb").find("int32"), std::string::npos);
    writeForeign(folder / "a.vdb", {});
    EXPECT_NE(refusal(folder / "a.vdb").find("none"), std::string::npos);

    auto huge = openvdb::FloatGrid::create(0);
    huge->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(4095)), 1, true);
    writeForeign(folder / "a.vdb", {named(huge, "irradiance")});
    EXPECT_NE(refusal(folder / "a.vdb").find("tiles"), std::string::npos);

    for (const int far : {500000000, 1000000000}) {
        auto far_apart = openvdb::FloatGrid::create(0);
        far_apart->tree().setValue(openvdb::Coord(-far), 1);
        far_apart->tree().setValue(openvdb::Coord(far), 1);
        writeForeign(folder / "a.vdb", {named(far_apart, "irradiance")});
        EXPECT_NE(refusal(folder / "a.vdb").find("blocks"), std::string::npos) << refusal(folder / "a.vdb");
    }

    auto one = openvdb::FloatGrid::create(0), other = openvdb::FloatGrid::create(0);
    one->tree().setValue(openvdb::Coord(0), 1);
    other->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    writeForeign(folder / "a.vdb", {named(one, "irradiance"), named(other, "density")});
    EXPECT_NE(refusal(folder / "a.vdb").find("transforms"), std::string::npos);

    one->insertMeta(format::kMetaVersion, openvdb::Int32Metadata(2));
    writeForeign(folder / "a.vdb", {named(one, "irradiance")});
    EXPECT_NE(refusal(folder / "a.vdb").find("version 2"), std::string::npos);
}

}  // namespace
}  // namespace photic
