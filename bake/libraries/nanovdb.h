// SPDX-License-Identifier: Apache-2.0
/// NanoVDB 32.4 (OpenVDB 10) and 32.7 to 32.9 (OpenVDB 12 and 13): grids that are made on the CPU, and their files. The
/// later ones have other headers, other names and another builder.
#pragma once

#if __has_include(<nanovdb/tools/GridBuilder.h>)
#define PHOTIC_NANOVDB_TOOLS
#include <nanovdb/io/IO.h>
#include <nanovdb/tools/CreateNanoGrid.h>
#include <nanovdb/tools/GridBuilder.h>
#include <nanovdb/tools/GridChecksum.h>
#else
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#endif

#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

namespace photic::nano {

/// A grid as `build` makes it, but for its voxels.
struct GridPlan {
    std::string name;
    nanovdb::Map map;
    nanovdb::Vec3d voxel_size;  ///< along the axes of the index [m]
    std::string blind;          ///< bytes that go along as blind data `photic` of no type; none when empty
};

/// The grid with the active voxels that `fill(accessor)` sets, by accessor.setValue(Coord, Value); 0 elsewhere, with
/// statistics and a full checksum.
template <class Value, class Build, class Buffer, class Fill>
nanovdb::GridHandle<Buffer> build(const GridPlan& plan, Fill fill) {
    // A whole number of aligned blocks, so that whatever follows the grid is aligned too.
    constexpr std::uint64_t kAlignment = NANOVDB_DATA_ALIGNMENT;
    const std::uint64_t room = (plan.blind.size() + kAlignment - 1) / kAlignment * kAlignment;
#ifdef PHOTIC_NANOVDB_TOOLS
    nanovdb::tools::build::Grid<Value> source(Value(0), plan.name);
    source.mMap = plan.map;
    {
        auto accessor = source.getAccessor();
        fill(accessor);
    }
    nanovdb::tools::CreateNanoGrid<nanovdb::tools::build::Grid<Value>> converter(source);
    converter.setChecksum(nanovdb::CheckMode::Disable);
    if (!plan.blind.empty()) {
        converter.addBlindData("photic", nanovdb::GridBlindDataSemantic::Unknown, nanovdb::GridBlindDataClass::Unknown,
                               nanovdb::GridType::Unknown, room, 1);
    }
    auto handle = converter.template getHandle<Build, Buffer>();
#else
    nanovdb::GridBuilder<Value, Build> builder(Value(0), nanovdb::GridClass::Unknown, room);
    builder.setChecksum(nanovdb::ChecksumMode::Disable);
    {
        auto accessor = builder.getAccessor();
        fill(accessor);
    }
    auto handle = builder.template getHandle<nanovdb::AbsDiff, Buffer>(plan.map, plan.name);
#endif

    // What the builder leaves open: voxel sizes along the axes, and the bytes that it made room for.
    auto* grid = handle.template grid<Build>();
    nanovdb::GridData* data = grid->data();
    data->mVoxelSize = plan.voxel_size;
    if (!plan.blind.empty()) {
        auto* record =
            reinterpret_cast<nanovdb::GridBlindMetaData*>(reinterpret_cast<char*>(data) + data->mBlindMetadataOffset);
        record->mSemantic = nanovdb::GridBlindDataSemantic::Unknown;
        record->mDataClass = nanovdb::GridBlindDataClass::Unknown;
        record->mDataType = nanovdb::GridType::Unknown;  // bytes: there is no type for them
#ifdef PHOTIC_NANOVDB_TOOLS
        record->mValueCount = plan.blind.size();
        char* bytes = reinterpret_cast<char*>(record) + record->mDataOffset;
#else
        record->mElementCount = plan.blind.size();
        record->mFlags = 0;
        std::strncpy(record->mName, "photic", nanovdb::GridBlindMetaData::MaxNameSize - 1);
        char* bytes = reinterpret_cast<char*>(record) + record->mByteOffset;
#endif
        std::memcpy(bytes, plan.blind.data(), plan.blind.size());
    }
#ifdef PHOTIC_NANOVDB_TOOLS
    nanovdb::tools::updateChecksum(data, nanovdb::CheckMode::Full);
#else
    nanovdb::updateChecksum(*grid, nanovdb::ChecksumMode::Full);
#endif
    return handle;
}

/// The bytes of a file of these grids, all in one segment: a file that is cut short anywhere then shows it.
inline std::string fileBytes(const std::vector<nanovdb::GridHandle<>>& handles, nanovdb::io::Codec codec) {
#ifdef PHOTIC_NANOVDB_TOOLS
    // writeGrids of these versions gives each handle a segment of its own.
    std::stringstream out;
    nanovdb::io::writeGrid(out, nanovdb::mergeGrids(handles), codec);
    return out.str();
#else
    // This one skips forward past the end, which only a stream that is long enough allows.
    std::size_t size = 1 << 16;
    for (const auto& handle : handles) size += handle.size();
    std::stringstream out(std::string(size, '\0'));
    nanovdb::io::writeGrids(out, handles, codec);
    return out.str().substr(0, static_cast<std::size_t>(out.tellp()));
#endif
}

}  // namespace photic::nano
