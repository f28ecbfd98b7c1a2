// SPDX-License-Identifier: Apache-2.0
// From a path or from bytes in memory to a Volume.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "runtime/src/nvdb_volume.h"

namespace photic::runtime {
namespace {

/// A file's bytes. Not a vector, which would clear them before they are read.
struct FileBytes {
    std::unique_ptr<unsigned char[]> data;
    std::size_t size = 0;
};

void grow(FileBytes& bytes, std::size_t capacity) {
    auto larger = std::make_unique_for_overwrite<unsigned char[]>(capacity);
    std::copy_n(bytes.data.get(), bytes.size, larger.get());
    bytes.data = std::move(larger);
}

FileBytes readFile(const std::string& path, std::uint64_t largest) {
    const auto close = [](std::FILE* f) { std::fclose(f); };
    const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
    if (!file) fail(ErrorCode::File, "'" + path + "' cannot be opened; is the path right?");
    // What the system says of the size only saves copies: a pipe has none, and a file may grow meanwhile.
    std::error_code unknown;
    const std::uintmax_t told = std::filesystem::file_size(path, unknown);
    constexpr std::size_t kStep = std::size_t{1} << 24;
    std::size_t capacity = kStep;
    if (!unknown && told < largest) capacity = static_cast<std::size_t>(told) + 1;  // one more: the end is seen at once
    FileBytes bytes;
    grow(bytes, capacity);
    while (true) {
        const std::size_t wanted = capacity - bytes.size;
        const std::size_t got = std::fread(bytes.data.get() + bytes.size, 1, wanted, file.get());
        bytes.size += got;
        if (bytes.size > largest) {
            fail(ErrorCode::Limit,
                 "'" + path + "' has more bytes than LoadOptions::largest_file, " + std::to_string(largest));
        }
        if (got < wanted) break;
        grow(bytes, capacity += kStep);
    }
    if (std::ferror(file.get())) fail(ErrorCode::File, "'" + path + "' cannot be read; is it a file?");
    return bytes;
}

}  // namespace

Result<Volume> readVolume(const void* bytes, std::size_t size, const LoadOptions& options) {
    return guarded([&]() -> Result<Volume> {
        if (!bytes || size == 0) fail(ErrorCode::Format, "there are no bytes to read");
        if (size > options.largest_file) {
            fail(ErrorCode::Limit, "the file has " + std::to_string(size) +
                                       " bytes, more than LoadOptions::largest_file, " +
                                       std::to_string(options.largest_file));
        }
        const Bytes file(static_cast<const unsigned char*>(bytes), size, "the file");
        return readNvdbFile(file, options);
    });
}

Result<Volume> loadVolume(const std::string& path, const LoadOptions& options) {
    return guarded([&]() -> Result<Volume> {
        const FileBytes bytes = readFile(path, options.largest_file);
        Result<Volume> volume = readVolume(bytes.data.get(), bytes.size, options);
        if (!volume) return Error{volume.error().code, "'" + path + "': " + volume.error().message};
        return volume;
    });
}

}  // namespace photic::runtime
