// SPDX-License-Identifier: Apache-2.0
#include "bake/image/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "bake/report/error.h"

namespace photic {
namespace {

/// An open file descriptor, closed on the way out.
class Descriptor {
public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }
    /// Closes now and tells whether the system took the data.
    bool close() {
        const int fd = fd_;
        fd_ = -1;
        return ::close(fd) == 0;
    }

private:
    int fd_;
};

}  // namespace

void writeFileAtomically(const std::string& path, std::string_view bytes) {
    // Renaming onto a device or a directory would replace it.
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw Error(ErrorCode::Failed, fmt::format("cannot write '{}': it is no regular file", path));
    const std::string temporary = fmt::format("{}.{}.part", path, ::getpid());
    const auto fail = [&](const char* verb) {
        const int reason = errno;
        ::unlink(temporary.c_str());
        throw Error(ErrorCode::Failed, fmt::format("cannot {} '{}': {}", verb, path, std::strerror(reason)));
    };

    Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (file.get() < 0) fail("create");
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t count = ::write(file.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) fail("write");
        done += static_cast<std::size_t>(count);
    }
    if (::fsync(file.get()) != 0 && errno != EINVAL) fail("flush");  // EINVAL: a file system without fsync
    if (!file.close()) fail("close");
    if (std::rename(temporary.c_str(), path.c_str()) != 0) fail("rename into");
}

std::string readFileBytes(const std::string& path) {
    const auto fail = [&] {
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
    };
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) fail();
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) fail();
    std::string bytes;
    if (status.st_size > 0) bytes.reserve(static_cast<std::size_t>(status.st_size));
    std::string buffer(1 << 16, '\0');
    for (;;) {
        const ssize_t count = ::read(file.get(), buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail();
        if (count == 0) return bytes;
        bytes.append(buffer.data(), static_cast<std::size_t>(count));
    }
}

}  // namespace photic
