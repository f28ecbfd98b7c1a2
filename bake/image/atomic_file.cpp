// SPDX-License-Identifier: Apache-2.0
#include "bake/image/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <utility>

#include "bake/image/pending_file.h"
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

private:
    int fd_;
};

thread_local FilesRead* t_files_read = nullptr;

[[noreturn]] void failToRead(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read '{}': {}", path, why));
}

/// What often lies where a file should, told by its first bytes: nullptr for anything else.
const char* standsInFor(std::string_view head) {
    if (head.starts_with("version https://git-lfs.github.com/spec/"))
        return "it is a pointer of Git LFS and not the file itself; fetch that with 'git lfs pull'";
    if (head.starts_with("/annex/objects/"))
        return "it is a pointer of git-annex and not the file itself; fetch that with 'git annex get'";
    if (head.starts_with("\x1f\x8b")) return "it is packed with gzip; unpack it first";
    if (head.starts_with("\x28\xb5\x2f\xfd")) return "it is packed with Zstandard; unpack it first";
    if (head.starts_with("PK\x03\x04")) return "it is a ZIP archive; unpack it, and give the file that is in it";
    std::string word(head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size())).substr(0, 14));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (word == "<!doctype html" || word.starts_with("<html"))
        return "it is a web page (HTML), as downloads leave that failed; download the file itself";
    return nullptr;
}

}  // namespace

FilesRead::FilesRead() : outer_(std::exchange(t_files_read, this)) {}

FilesRead::~FilesRead() {
    t_files_read = outer_;
    for (const std::string& path : paths_)
        if (outer_) outer_->add(path);
}

void FilesRead::add(const std::string& path) {
    if (std::find(paths_.begin(), paths_.end(), path) == paths_.end()) paths_.push_back(path);
}

void checkReadable(const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) failToRead(path, std::strerror(errno));
    if (S_ISDIR(status.st_mode)) failToRead(path, "it is a folder (a directory); give a file");
    if (!S_ISREG(status.st_mode)) failToRead(path, "it is a device or a pipe; save what it gives to a file first");
    // A pipe that took the file's place meanwhile would wait for its writer, deaf to signals.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    if (file.get() < 0) failToRead(path, std::strerror(errno));
    char head[64];
    const ssize_t count = ::read(file.get(), head, sizeof head);
    if (count > 0)
        if (const char* what = standsInFor({head, static_cast<std::size_t>(count)})) failToRead(path, what);
    if (t_files_read) t_files_read->add(path);
}

void writeFileAtomically(const std::string& path, std::string_view bytes) {
    PendingFile file(path);
    const auto fail = [&](int reason) {
        throw Error(ErrorCode::Failed, fmt::format("cannot write '{}': {}", path, std::strerror(reason)));
    };
    if (const int reason = writeBytes(file.descriptor(), bytes)) fail(reason);
    if (const int reason = file.flush()) fail(reason);
    if (const int reason = file.commit()) fail(reason);
    flushFolderOf(file.target().path);
}

int writeBytes(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count < 0 ? errno : ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return 0;
}

std::string readFileBytes(const std::string& path) {
    const auto fail = [&] { failToRead(path, std::strerror(errno)); };
    checkReadable(path);
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
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
