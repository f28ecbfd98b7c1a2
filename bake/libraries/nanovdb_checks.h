// SPDX-License-Identifier: Apache-2.0
/// NanoVDB 32.4 to 32.9: its own checks of a grid, and its way back to OpenVDB.
#pragma once

#if __has_include(<nanovdb/tools/GridValidator.h>)
#define PHOTIC_NANOVDB_TOOLS
#include <nanovdb/tools/GridValidator.h>
#include <nanovdb/tools/NanoToOpenVDB.h>
#else
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/NanoToOpenVDB.h>
#endif

#include <cstdint>

namespace photic::nano {

/// What NanoVDB says of a grid, checksum and all; it prints what is wrong.
template <class Build>
bool isValid(const nanovdb::NanoGrid<Build>& grid) {
#ifdef PHOTIC_NANOVDB_TOOLS
    return nanovdb::tools::isValid(&grid, nanovdb::CheckMode::Full, true);
#else
    return nanovdb::isValid(grid, true, true);
#endif
}

/// The same grid, as OpenVDB has it.
template <class Build>
openvdb::GridBase::Ptr toOpenVdb(const nanovdb::NanoGrid<Build>& grid) {
#ifdef PHOTIC_NANOVDB_TOOLS
    return nanovdb::tools::nanoToOpenVDB(grid);
#else
    return nanovdb::nanoToOpenVDB(grid);
#endif
}

/// How many bytes of blind data a record of a grid is about.
inline std::uint64_t blindSize(const nanovdb::GridBlindMetaData& record) {
#ifdef PHOTIC_NANOVDB_TOOLS
    return record.mValueCount * record.mValueSize;
#else
    return record.mElementCount;
#endif
}

/// Where they are, counted from the grid's first byte.
inline std::int64_t blindOffset(const nanovdb::GridData& grid, const nanovdb::GridBlindMetaData& record) {
#ifdef PHOTIC_NANOVDB_TOOLS
    const std::int64_t from_record = record.mDataOffset;
#else
    const std::int64_t from_record = record.mByteOffset;
#endif
    return from_record + (reinterpret_cast<const char*>(&record) - reinterpret_cast<const char*>(&grid));
}

}  // namespace photic::nano
