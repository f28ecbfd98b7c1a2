// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "runtime/src/nvdb_grid.h"

// Where NanoVDB 32.x puts what is read here [bytes]; the same numbers as in PNanoVDB.h's tables.

namespace photic::runtime::nvdb {

inline constexpr std::uint64_t kMagicOld = 0x304244566f6e614eULL;   // "NanoVDB0": files and grids up to 32.5
inline constexpr std::uint64_t kMagicGrid = 0x314244566f6e614eULL;  // "NanoVDB1": grids
inline constexpr std::uint64_t kMagicFile = 0x324244566f6e614eULL;  // "NanoVDB2": files
inline constexpr std::uint32_t kMajorVersion = 32;
inline std::uint32_t majorOf(std::uint32_t version) { return version >> 21; }

// A file's segment: header, then per grid a record and a name, then the grids.
inline constexpr std::uint64_t kFileHeaderSize = 16, kFileVersion = 8, kFileGridCount = 12, kFileCodec = 14;
inline constexpr std::uint64_t kRecordSize = 176, kRecordGridSize = 0, kRecordFileSize = 8, kRecordNameSize = 136,
                               kRecordCodec = 168;

inline constexpr std::uint16_t kCodecNone = 0, kCodecBlosc = 2;

inline constexpr std::uint64_t kGridVersion = 16, kGridSize = 32, kGridName = 40, kGridNameSize = 256, kGridMap = 296,
                               kGridType = 636, kGridBlindOffset = 640, kGridBlindCount = 648, kGridHeaderSize = 672;
inline constexpr std::uint64_t kMapMatrix = 88, kMapVector = 88 + 2 * 72;  // of the map: doubles, after the floats
inline constexpr std::uint64_t kBlindSize = 288, kBlindCount = 8, kBlindName = 32;

// The tree lies behind the grid's header; its offsets count from its own start, those of children from their parent.
inline constexpr std::uint64_t kTree = kGridHeaderSize, kTreeSize = 64, kTreeNodeOffset = 0, kTreeNodeCount = 32;
inline constexpr std::uint64_t kRootTileCount = 24, kRootTileKey = 0, kRootTileChild = 8, kRootTileState = 16;
inline constexpr std::uint64_t kNodeValueMask = 32;  // of upper and lower nodes; the child mask follows
inline constexpr std::uint64_t kLeafValueMask = 16;
inline constexpr std::uint64_t kLeafMinimum = 80, kLeafQuantum = 84;  // of quantised leaves: floats

/// What depends on the type of value.
struct TypeLayout {
    std::uint64_t root_size, root_tile_value, root_tile_size, table_stride, upper_table, upper_size, lower_table,
        lower_size, leaf_table, leaf_size;
};
inline TypeLayout layoutOf(NvdbType type) {
    switch (type) {
        case NvdbType::Vec3f:
            return {96, 20, 32, 16, 8256, 532544, 1088, 66624, 128, 6272};
        case NvdbType::Vec4f:
            return {96, 20, 64, 16, 8288, 532576, 1120, 66656, 128, 8320};
        case NvdbType::Fp4:
            return {64, 20, 32, 8, 8256, 270400, 1088, 33856, 96, 352};
        case NvdbType::Fp8:
            return {64, 20, 32, 8, 8256, 270400, 1088, 33856, 96, 608};
        case NvdbType::Fp16:
            return {64, 20, 32, 8, 8256, 270400, 1088, 33856, 96, 1120};
        case NvdbType::Float:
            break;
    }
    return {64, 20, 32, 8, 8256, 270400, 1088, 33856, 96, 2144};
}

}  // namespace photic::runtime::nvdb
