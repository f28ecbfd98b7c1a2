// SPDX-License-Identifier: Apache-2.0
// From a path or from bytes in memory to a Volume.
#include "runtime/src/file_bytes.h"
#include "runtime/src/nvdb_volume.h"

namespace photic::runtime {

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
