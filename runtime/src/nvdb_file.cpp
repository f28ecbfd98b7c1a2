// SPDX-License-Identifier: Apache-2.0
// The outer layer of a `.nvdb`: where its grids lie (nanovdb/util/IO.h).
#include "runtime/src/nvdb_grid.h"
#include "runtime/src/nvdb_layout.h"

namespace photic::runtime {

using namespace nvdb;

namespace {

constexpr std::size_t kMostGrids = 256;  // of a file; a light volume has at most seven

NvdbGrid gridAt(const Bytes& file, std::uint64_t offset, std::uint64_t size, std::size_t number) {
    return NvdbGrid(file.part(offset, size, "grid " + std::to_string(number + 1)));
}

void countGrid(std::size_t count) {
    if (count >= kMostGrids) fail(ErrorCode::Format, "the file has more than " + std::to_string(kMostGrids) + " grids");
}

/// Reads the segment at `offset`, appends its grids. @return where it ends
std::uint64_t readSegment(const Bytes& file, std::uint64_t offset, std::vector<NvdbGrid>& grids) {
    file.require(offset, kFileHeaderSize, 1, "a segment's header");
    const auto version = file.get<std::uint32_t>(offset + kFileVersion);
    if (majorOf(version) != kMajorVersion) {
        fail(ErrorCode::Format,
             "the file is of NanoVDB " + std::to_string(majorOf(version)) + ".x; only 32.x is read: export it again");
    }
    const auto count = file.get<std::uint16_t>(offset + kFileGridCount);
    struct Record {
        std::uint64_t size;
    };
    std::vector<Record> records;
    std::uint64_t at = offset + kFileHeaderSize;
    for (int i = 0; i < count; ++i) {
        file.require(at, kRecordSize, 1, "the list of grids");
        const auto codec = file.get<std::uint16_t>(at + kRecordCodec);
        if (codec != 0 || file.get<std::uint16_t>(offset + kFileCodec) != 0) {
            fail(ErrorCode::Format,
                 "the file is compressed (codec " + std::to_string(codec) +
                     "); write it without: photic export, or nanovdb_convert without --zip and --blosc");
        }
        const auto size = file.get<std::uint64_t>(at + kRecordGridSize);
        if (size != file.get<std::uint64_t>(at + kRecordFileSize)) {
            fail(ErrorCode::Format, "a grid's size in the file is not its size in memory; the file is damaged");
        }
        records.push_back({size});
        at += kRecordSize;
        const auto name_size = file.get<std::uint32_t>(at - kRecordSize + kRecordNameSize);
        file.require(at, name_size, 1, "a grid's name in the list");
        at += name_size;
    }
    for (const Record& record : records) {
        countGrid(grids.size());
        grids.push_back(gridAt(file, at, record.size, grids.size()));
        at += record.size;
    }
    return at;
}

}  // namespace

std::vector<NvdbGrid> readNvdbGrids(const Bytes& file) {
    std::vector<NvdbGrid> grids;
    std::uint64_t offset = 0;
    while (offset < file.size() || offset == 0) {
        const auto magic = file.read<std::uint64_t>(offset, "the magic number");
        if (magic == kMagicGrid) {
            // Grids alone, one behind the other, as newer writers store a buffer.
            countGrid(grids.size());
            const auto size = file.read<std::uint64_t>(offset + kGridSize, "a grid's size");
            grids.push_back(gridAt(file, offset, size, grids.size()));
            offset += size;
        } else if (magic == kMagicOld || magic == kMagicFile) {
            offset = readSegment(file, offset, grids);
        } else {
            fail(ErrorCode::Format,
                 "this is no NanoVDB file; make one of a .vdb with `photic export in.vdb -o out.nvdb`");
        }
    }
    return grids;
}

}  // namespace photic::runtime
