// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/file_bytes.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

void grow(FileBytes& bytes, std::size_t capacity) {
    auto larger = std::make_unique_for_overwrite<unsigned char[]>(capacity);
    std::copy_n(bytes.data.get(), bytes.size, larger.get());
    bytes.data = std::move(larger);
}

}  // namespace

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

}  // namespace photic::runtime
