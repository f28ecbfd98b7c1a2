// SPDX-License-Identifier: Apache-2.0
// The .nvdb as others see it: NanoVDB's own reader, checks and way back to OpenVDB.
#include "bake/file/nvdb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "bake/libraries/nanovdb.h"
#include "bake/libraries/nanovdb_checks.h"
#include "bake/libraries/openvdb.h"
#include "bake/report/error.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

using Grids = std::map<std::string, openvdb::GridBase::Ptr>;

// A grid of one type, checked by NanoVDB and brought back to OpenVDB. Typed, since for all of NanoVDB's types at once
// the compiler takes minutes and gigabytes.
template <class Build>
void openAs(const nanovdb::GridHandle<>& handle, Grids& grids) {
    const auto* grid = handle.grid<Build>();
    if (grid == nullptr) return;
    EXPECT_TRUE(nano::isValid(*grid));
    const openvdb::GridBase::Ptr back = nano::toOpenVdb(*grid);
    grids[back->getName()] = back;
}

// Every grid of a file; a type that we do not write fails.
Grids openAll(const std::string& path) {
    openvdb::initialize();
    Grids grids;
    const auto handles = nanovdb::io::readGrids(path);
    for (const auto& handle : handles) {
        openAs<nanovdb::Fp16>(handle, grids);
        openAs<nanovdb::Vec4f>(handle, grids);
        openAs<nanovdb::Vec3f>(handle, grids);
    }
    EXPECT_EQ(grids.size(), handles.size());
    return grids;
}

std::vector<std::string> namesOf(const Grids& grids) {
    std::vector<std::string> names;
    for (const auto& [name, grid] : grids) names.push_back(name);
    return names;
}

LightVolume sourceVolume(bool coloured, bool sheared = false) {
    const auto box = [&](const glm::ivec3& v) { return v.x >= -5 && v.x <= 9 && v.y != 7; };
    const glm::ivec3 min(-9, 3, -20), max(14, 17, 3);
    LightVolume volume =
        testVolume(sheared ? leaningFrame(min, max, 1.0 / 64) : straightFrame(min, max, 1.0 / 64), coloured, box);
    volume.metadata = {{"method", "beams"},
                       {"ior", "1.333"},
                       {"frame", "7"},
                       {"paths", "caustic"},
                       {"scattering", "[0.1,0.2,0.3]"},
                       {"anisotropy", "0.8"},
                       {"absorption", "nonsense"}};
    return volume;
}

// Visits the voxels with light: body(voxel, light at its centre in units of the reference).
template <class Body>
void forEachLit(const LightVolume& volume, Body body) {
    const GridFrame& f = volume.field.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z)
                if (volume.field.irradiance({x, y, z}) > 0) body(openvdb::Coord(x, y, z), glm::ivec3(x, y, z));
}

TEST(Nvdb, FullPrecisionReturnsEveryFloat) {
    for (const bool coloured : {false, true}) {
        const TemporaryFolder folder;
        const LightVolume volume = sourceVolume(coloured);
        const NvdbWritten written = writeNvdb(folder / "a.nvdb", volume, {NvdbPrecision::Float, NvdbCodec::None});
        EXPECT_EQ(written.clamped, 0);
        const Grids grids = openAll(folder / "a.nvdb");
        EXPECT_EQ(namesOf(grids),
                  coloured ? (std::vector<std::string>{"flux", "irradiance_rgb"}) : std::vector<std::string>{"flux"});
        using Vec4Grid = openvdb::Grid<openvdb::tree::Tree4<openvdb::Vec4s, 5, 4, 3>::Type>;
        const auto flux = openvdb::gridPtrCast<Vec4Grid>(grids.at("flux"));
        ASSERT_TRUE(flux);
        EXPECT_EQ(flux->activeVoxelCount(), static_cast<openvdb::Index64>(written.active_voxels));
        const float scale = 1.0f / 1000;
        std::int64_t lit = 0;
        forEachLit(volume, [&](const openvdb::Coord& c, const glm::ivec3& v) {
            ++lit;
            const auto found = flux->tree().getValue(c);
            ASSERT_TRUE(flux->tree().isValueOn(c));
            for (int a = 0; a < 3; ++a)
                ASSERT_FLOAT_EQ(found[a], volume.field.value(v, (coloured ? 3 : 1) + a) * scale);
            ASSERT_NEAR(found[3], volume.field.irradiance(v) / 1000, 1e-6);
            if (!coloured) return;
            const auto rgb = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids.at("irradiance_rgb"))->tree().getValue(c);
            for (int i = 0; i < 3; ++i) ASSERT_FLOAT_EQ(rgb[i], volume.field.value(v, i) * scale);
        });
        EXPECT_EQ(lit, written.active_voxels);
    }
}

TEST(Nvdb, HalfPrecisionErrsByAHalfStepOfItsLeaf) {
    for (const bool coloured : {false, true}) {
        const TemporaryFolder folder;
        const LightVolume volume = sourceVolume(coloured);
        const NvdbWritten written = writeNvdb(folder / "a.nvdb", volume, {});
        const Grids grids = openAll(folder / "a.nvdb");
        EXPECT_EQ(grids.size(), coloured ? 7u : 4u);
        std::map<std::string, openvdb::FloatGrid::Ptr> scalars;
        for (const auto& [name, grid] : grids) {
            scalars[name] = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
            ASSERT_TRUE(scalars[name]) << name;
            EXPECT_EQ(grid->activeVoxelCount(), static_cast<openvdb::Index64>(written.active_voxels)) << name;
            EXPECT_TRUE(scalars[name]->tree().hasSameTopology(
                openvdb::gridPtrCast<openvdb::FloatGrid>(grids.at("irradiance"))->tree()));
        }
        // Values of a leaf span less than 3 here: half of 1/65535 of that, and rounding.
        constexpr double kHalfStep = 0.5 * 3 / 65535 + 1e-6;
        double worst = 0;
        forEachLit(volume, [&](const openvdb::Coord& c, const glm::ivec3& v) {
            const auto at = [&](const char* name) { return double(scalars[name]->tree().getValue(c)); };
            const glm::dvec3 flux = volume.field.flux(v) / 1000.0;
            worst = std::max({worst, std::fabs(at("flux_x") - flux.x), std::fabs(at("flux_y") - flux.y),
                              std::fabs(at("flux_z") - flux.z),
                              std::fabs(at("irradiance") - volume.field.irradiance(v) / 1000)});
            if (coloured)
                worst = std::max(worst, std::fabs(at("irradiance_g") - double(volume.field.value(v, 1)) / 1000));
        });
        EXPECT_LT(worst, kHalfStep);
        EXPECT_GT(worst, 1e-7);  // it is 16 bits, not floats
    }
}

TEST(Nvdb, ShearedGridsKeepTheirMap) {
    const TemporaryFolder folder;
    const LightVolume volume = sourceVolume(false, true);
    writeNvdb(folder / "a.nvdb", volume, {NvdbPrecision::Float, NvdbCodec::None});
    const auto handles = nanovdb::io::readGrids(folder / "a.nvdb");
    const auto* grid = handles[0].grid<nanovdb::Vec4f>();
    ASSERT_NE(grid, nullptr);
    for (const glm::dvec3 index : {glm::dvec3(0), glm::dvec3(3, -7, 11), glm::dvec3(0.5, 2.25, -8)}) {
        const auto world = grid->indexToWorld(nanovdb::Vec3d(index.x, index.y, index.z));
        const auto again = grid->worldToIndex(world);
        const glm::dvec3 expected = volume.field.frame().worldFromIndex(index);
        for (int a = 0; a < 3; ++a) {
            EXPECT_NEAR(world[a], expected[a], 1e-12);
            EXPECT_NEAR(again[a], index[a], 1e-9);
        }
    }
    // Not through OpenVDB: nanoToOpenVDB of 10.0.1 drops the result of its transpose(), so sheared maps come back
    // transposed.
}

TEST(Nvdb, MetadataIsBlindDataOfTheFirstGrid) {
    for (const auto precision : {NvdbPrecision::Half, NvdbPrecision::Float}) {
        const TemporaryFolder folder;
        writeNvdb(folder / "a.nvdb", sourceVolume(true), {precision, NvdbCodec::None});
        const auto handles = nanovdb::io::readGrids(folder / "a.nvdb");
        const auto* first = reinterpret_cast<const nanovdb::GridData*>(handles[0].data());
        ASSERT_EQ(first->mBlindMetadataCount, 1u);
        const auto& meta = *first->blindMetaData(0);
        EXPECT_STREQ(meta.mName, "photic");
        // Where it says that it is, and inside the grid.
        const auto offset = nano::blindOffset(*first, meta);
        ASSERT_GT(offset, 0);
        ASSERT_LE(static_cast<std::uint64_t>(offset) + nano::blindSize(meta), handles[0].buffer().size());
        EXPECT_EQ(handles[0].buffer().size() % 32, 0u);
        const auto json =
            nlohmann::json::parse(std::string(reinterpret_cast<const char*>(first) + offset, nano::blindSize(meta)));
        EXPECT_EQ(json["version"], 1);
        EXPECT_EQ(json["reference_irradiance"], 1000.0);
        EXPECT_EQ(json["ior"], 1.333);
        EXPECT_EQ(json["frame"], 7);
        EXPECT_EQ(json["method"], "beams");
        EXPECT_EQ(json["up_axis"], "Z");
        EXPECT_EQ(json["scattering"], nlohmann::json({0.1, 0.2, 0.3}));
        EXPECT_FALSE(json.contains("absorption"));  // no numbers
        for (std::size_t i = 1; i < handles.size(); ++i) {
            const auto* other = reinterpret_cast<const nanovdb::GridData*>(handles[i].data());
            EXPECT_EQ(other->mBlindMetadataCount, 0u);
        }
    }
}

TEST(Nvdb, EqualVolumesGiveEqualBytesAndCodecsReadBack) {
    const TemporaryFolder folder;
    writeNvdb(folder / "a.nvdb", sourceVolume(true), {});
    // Memory that is not fresh, so that gaps would show.
    { std::vector<std::vector<char>> dirt(64, std::vector<char>(100000, 'x')); }
    writeNvdb(folder / "b.nvdb", sourceVolume(true), {});
    EXPECT_EQ(bytesOf(folder / "a.nvdb"), bytesOf(folder / "b.nvdb"));
    const auto plain = nanovdb::io::readGrids(folder / "a.nvdb");
    for (const auto codec : {NvdbCodec::Zip, NvdbCodec::Blosc}) {
        writeNvdb(folder / "c.nvdb", sourceVolume(true), {NvdbPrecision::Half, codec});
        EXPECT_LT(bytesOf(folder / "c.nvdb").size(), bytesOf(folder / "a.nvdb").size());
        const auto packed = nanovdb::io::readGrids(folder / "c.nvdb");
        ASSERT_EQ(packed.size(), plain.size());
        for (std::size_t i = 0; i < plain.size(); ++i) {
            const auto size = plain[i].buffer().size();
            ASSERT_EQ(packed[i].buffer().size(), size);
            EXPECT_EQ(std::memcmp(packed[i].data(), plain[i].data(), size), 0);
        }
    }
}

TEST(Nvdb, DarkOddAndUnwritable) {
    const TemporaryFolder folder;
    const auto frame = straightFrame({3, 4, 5}, {9, 9, 9}, 0.1);
    LightVolume volume = testVolume(frame, false, [](const glm::ivec3&) { return false; });
    EXPECT_EQ(writeNvdb(folder / "dark.nvdb", volume, {}).active_voxels, 1);
    EXPECT_EQ(openAll(folder / "dark.nvdb").at("irradiance")->activeVoxelCount(), 1u);

    // Not a number in a lit voxel, and a value that no half holds.
    volume = testVolume(frame, false);
    float* leaf = volume.field.makeDense(volume.field.needed().slotOf({4, 5, 6}));
    leaf[NeededVoxels::offsetInLeaf({4, 5, 6})] = 1e9f;
    leaf[512 + NeededVoxels::offsetInLeaf({4, 5, 6})] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(writeNvdb(folder / "odd.nvdb", volume, {NvdbPrecision::Float, NvdbCodec::None}).clamped, 2);
    EXPECT_THROW(writeNvdb(folder / "no/a.nvdb", volume, {}), Error);
    EXPECT_EQ(folder.fileCount(), 2u);
}

}  // namespace
}  // namespace photic
