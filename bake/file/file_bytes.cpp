// SPDX-License-Identifier: Apache-2.0
#include "bake/file/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>

#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read {}: {}", path, why), path);
}

}  // namespace

FileBytes::FileBytes(const std::string& path) {
    checkReadable(path);
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) refuse(path, fmt::format("{}; give the path of a .vdb file", std::strerror(errno)));
    struct stat status {};
    const bool known = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    size_ = known ? static_cast<std::size_t>(status.st_size) : 0;
    try {
        data_ = std::make_unique_for_overwrite<char[]>(size_);
    } catch (const std::bad_alloc&) {
        ::close(descriptor);
        refuse(path, "it is larger than memory");
    }
    constexpr std::size_t kChunk = std::size_t{4} << 20;
    std::atomic<bool> whole{known};
    parallelFor(static_cast<std::int64_t>((size_ + kChunk - 1) / kChunk), [&](std::int64_t i) {
        const std::size_t first = static_cast<std::size_t>(i) * kChunk;
        if (!readAll(descriptor, first, std::min(size_, first + kChunk))) whole = false;
    });
    ::close(descriptor);
    if (!whole) refuse(path, known ? "it cannot be read, or changes meanwhile" : "it is no regular file");
}

bool FileBytes::readAll(int descriptor, std::size_t at, std::size_t end) {
    while (at < end) {
        const ssize_t n = ::pread(descriptor, data_.get() + at, end - at, static_cast<off_t>(at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
    }
    return true;
}

}  // namespace photic
