// SPDX-License-Identifier: Apache-2.0
// The outer layer of a `.nvdb`: where its grids lie (nanovdb/util/IO.h).
#include <algorithm>
#include <memory>

#include "runtime/src/blosc.h"
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

/// What a segment's list says of a grid.
struct Record {
    std::uint64_t size, file_size;  ///< [bytes], unpacked and in the file
    std::uint16_t codec;
};

Record readRecord(const Bytes& file, std::uint64_t at, std::uint16_t segment_codec) {
    const Record record{file.get<std::uint64_t>(at + kRecordGridSize), file.get<std::uint64_t>(at + kRecordFileSize),
                        file.get<std::uint16_t>(at + kRecordCodec)};
    if (record.codec != segment_codec || (record.codec != kCodecNone && record.codec != kCodecBlosc)) {
        fail(ErrorCode::Format, "the file is compressed by codec " + std::to_string(record.codec) +
                                    "; none (0) and Blosc (2) are read: use photic export, or nanovdb_convert --blosc");
    }
    // LZ4 packs no better than 255 to 1: a small file never asks for much memory.
    constexpr std::uint64_t kMostPacked = 256;
    const bool sensible =
        record.codec == kCodecNone ? record.size == record.file_size : record.size / kMostPacked <= record.file_size;
    if (!sensible) {
        fail(ErrorCode::Format, "a grid has " + std::to_string(record.file_size) +
                                    " bytes in the file, and its size in memory would be " +
                                    std::to_string(record.size) + "; the file is damaged");
    }
    return record;
}

/// A grid that is packed by Blosc: chunks of at most 1 GiB, each behind its packed size.
Bytes unpackGrid(const Bytes& packed, const Record& record) {
    constexpr std::uint64_t kChunk = std::uint64_t{1} << 30;
    const auto size = static_cast<std::size_t>(record.size);
    const std::shared_ptr<unsigned char[]> grid(new unsigned char[size]);
    std::uint64_t at = 0, done = 0;
    while (done < record.size) {
        const auto count = packed.read<std::uint64_t>(at, "the size of a packed chunk");
        packed.require(at + 8, count, 1, "a packed chunk");
        const std::uint64_t unpacked = std::min(record.size - done, kChunk);
        unpackBlosc(packed.view(at + 8, count), {grid.get() + done, static_cast<std::size_t>(unpacked)}, packed.what());
        at += 8 + count, done += unpacked;
    }
    if (at != packed.size()) {
        fail(ErrorCode::Format, packed.what() + " has " + std::to_string(packed.size()) +
                                    " bytes in the file, of which " + std::to_string(at) +
                                    " are its chunks; the file is damaged");
    }
    return {grid, record.size, packed.what()};
}

/// Reads the segment at `offset`, appends its grids.
/// @param left  [bytes] that packed grids may still take; what they take is taken off
/// @return where it ends
std::uint64_t readSegment(const Bytes& file, std::uint64_t offset, std::uint64_t& left, std::vector<NvdbGrid>& grids) {
    file.require(offset, kFileHeaderSize, 1, "a segment's header");
    const auto version = file.get<std::uint32_t>(offset + kFileVersion);
    if (majorOf(version) != kMajorVersion) {
        fail(ErrorCode::Format,
             "the file is of NanoVDB " + std::to_string(majorOf(version)) + ".x; only 32.x is read: export it again");
    }
    const auto count = file.get<std::uint16_t>(offset + kFileGridCount);
    std::vector<Record> records;
    std::uint64_t at = offset + kFileHeaderSize;
    for (int i = 0; i < count; ++i) {
        file.require(at, kRecordSize, 1, "the list of grids");
        records.push_back(readRecord(file, at, file.get<std::uint16_t>(offset + kFileCodec)));
        const auto name_size = file.get<std::uint32_t>(at + kRecordNameSize);
        at += kRecordSize;
        file.require(at, name_size, 1, "a grid's name in the list");
        at += name_size;
    }
    for (const Record& record : records) {
        countGrid(grids.size());
        const std::string what = "grid " + std::to_string(grids.size() + 1);
        const Bytes part = file.part(at, record.file_size, what);
        if (record.codec == kCodecNone) {
            grids.emplace_back(part);
        } else {
            if (record.size > left) {
                fail(ErrorCode::Limit, what + " would be " + std::to_string(record.size) +
                                           " bytes once it is unpacked, and " + std::to_string(left) +
                                           " are left; raise LoadOptions::largest_file");
            }
            left -= record.size;
            grids.emplace_back(unpackGrid(part, record));
        }
        at += record.file_size;
    }
    return at;
}

}  // namespace

std::vector<NvdbGrid> readNvdbGrids(const Bytes& file, std::uint64_t largest_unpacked) {
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
            offset = readSegment(file, offset, largest_unpacked, grids);
        } else {
            fail(ErrorCode::Format,
                 "this is no NanoVDB file; make one of a .vdb with `photic export in.vdb -o out.nvdb`");
        }
    }
    return grids;
}

}  // namespace photic::runtime
