// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace photic {

/// Writes `bytes` beside `path` under a temporary name, flushes them to the disk, and renames (pending_file.h). On
/// failure the old file is intact and the temporary one is gone.
/// @throws Error{Failed} with the path and the system's reason
void writeFileAtomically(const std::string& path, std::string_view bytes);

/// Writes all bytes to an open file. @return 0, or the system's reason
int writeBytes(int descriptor, std::string_view bytes);

/// All bytes of a file.
/// @throws Error{Input} where checkReadable() does, and when reading fails
std::string readFileBytes(const std::string& path);

/// Refuses what is no file: a pipe would wait for its writer, and a device may never end.
/// @throws Error{Input} with the path and the system's reason
void checkReadable(const std::string& path);

/// While it lives, remembers the files that this thread reads through readFileBytes() or asks checkReadable() about. A
/// run can then refuse to write onto any of them.
class FilesRead {
public:
    FilesRead();
    ~FilesRead();
    FilesRead(const FilesRead&) = delete;
    FilesRead& operator=(const FilesRead&) = delete;
    /// In the order of their first reading, each once, as they were named.
    const std::vector<std::string>& paths() const { return paths_; }
    void add(const std::string& path);

private:
    FilesRead* outer_;
    std::vector<std::string> paths_;
};

}  // namespace photic
