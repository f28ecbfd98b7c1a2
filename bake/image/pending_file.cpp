// SPDX-License-Identifier: Apache-2.0
#include "bake/image/pending_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string_view>

#include "bake/report/error.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;          // as the kernel counts them
constexpr std::time_t kDay = 86400;     // after which a file of another machine is nobody's
constexpr std::time_t kHour = 3600;     // after which a file of the old naming is nobody's
constexpr std::size_t kLongName = 160;  // bytes; names end at 255, and a temporary one is longer

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Failed, "cannot write there: " + why, path);
}

fs::path folderOf(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

/// The end of a chain of symbolic links.
fs::path followed(const std::string& given) {
    fs::path path(given);
    for (int links = 0;; ++links) {
        std::error_code none;
        if (!fs::is_symlink(fs::symlink_status(path, none))) return path;
        if (links == kMostLinks)
            refuse(given, "it is a symbolic link that leads in a circle; remove it or give another name");
        const fs::path next = fs::read_symlink(path, none);
        path = next.is_absolute() ? next : folderOf(path) / next;
    }
}

std::uint64_t randomNumber() {
    std::uint64_t number = 0;
    if (::getrandom(&number, sizeof(number), 0) == static_cast<ssize_t>(sizeof(number))) return number;
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

/// Eight hexadecimal digits that all processes of this machine share until it starts again, containers too.
const std::string& machineMark() {
    static const std::string mark = [] {
        std::string id;
        std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
        if (id.empty()) {
            char host[256] = "";
            ::gethostname(host, sizeof(host) - 1);
            id = host;
        }
        std::uint32_t hash = 2166136261u;
        for (const char c : id) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
        return fmt::format("{:08x}", hash);
    }();
    return mark;
}

/// How the names of temporary files of `name` begin.
std::string temporaryStem(const std::string& name) {
    if (name.size() <= kLongName) return "." + name + ".";
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return fmt::format(".photic-{:016x}.", hash);
}

bool isHex(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return std::isxdigit(static_cast<unsigned char>(c)); });
}
bool isNumber(std::string_view text) {
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](char c) { return std::isdigit(static_cast<unsigned char>(c)); });
}

/// A file of the temporary names, by its name alone.
struct Leftover {
    bool ours = false;         ///< made on this machine since it started
    std::optional<pid_t> pid;  ///< of the old naming, which had no lock
};

/// What `entry` is of the target `name`: ".NAME.MACHINE-RANDOM.tmp", formerly ".NAME.PID-N.tmp" and "NAME.PID.part".
std::optional<Leftover> leftoverNamed(const std::string& entry, const std::string& name) {
    const auto pidOf = [](std::string_view digits) {
        pid_t pid = 0;
        std::from_chars(digits.data(), digits.data() + digits.size(), pid);
        return pid;
    };
    const auto middle = [&entry](const std::string& begin, const std::string& end) -> std::optional<std::string_view> {
        if (entry.size() <= begin.size() + end.size() || entry.compare(0, begin.size(), begin) != 0 ||
            entry.compare(entry.size() - end.size(), end.size(), end) != 0)
            return {};
        return std::string_view(entry).substr(begin.size(), entry.size() - begin.size() - end.size());
    };
    if (const auto text = middle(temporaryStem(name), ".tmp")) {
        const std::size_t dash = text->find('-');
        if (dash == std::string_view::npos) return {};
        const std::string_view before = text->substr(0, dash), after = text->substr(dash + 1);
        if (before.size() == 8 && after.size() == 16 && isHex(before) && isHex(after))
            return Leftover{before == machineMark(), {}};
        if (isNumber(before) && isNumber(after)) return Leftover{true, pidOf(before)};
    }
    if (const auto text = middle(name + ".", ".part"); text && isNumber(*text)) return Leftover{true, pidOf(*text)};
    return {};
}

/// Removes a file that nobody writes any more; one that someone writes is left alone.
bool removeIfDead(const fs::path& path, const Leftover& leftover) {
    // Some network file systems lock only what is open for writing.
    int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0) descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0) return false;
    struct stat status {};
    bool dead = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    const std::time_t age = std::time(nullptr) - status.st_mtime;
    // A file system without locks tells nothing: then age must.
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && (errno == EWOULDBLOCK || age < kDay)) dead = false;
    if (!leftover.ours && age < kDay) dead = false;
    if (leftover.pid && age < kHour && (::kill(*leftover.pid, 0) == 0 || errno == EPERM)) dead = false;
    // Removed while it is locked here, so that whoever has just made it sees that it is gone, and makes another.
    if (dead) dead = ::unlink(path.c_str()) == 0;
    ::close(descriptor);
    return dead;
}

/// A new file beside `target`, locked. @return its descriptor, or -1 with errno
int createTemporary(const fs::path& target, unsigned mode, std::string& name) {
    for (int attempt = 0; attempt < 100; ++attempt) {
        const std::string file =
            fmt::format("{}{}-{:016x}.tmp", temporaryStem(target.filename().string()), machineMark(), randomNumber());
        name = (target.parent_path() / file).string();
        const int descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (descriptor < 0 && errno == EEXIST) continue;
        if (descriptor < 0) return -1;
        // Between the two calls another process may have taken it for a dead one's and removed it: then once more.
        struct stat status {};
        ::flock(descriptor, LOCK_EX);
        if (::fstat(descriptor, &status) != 0 || status.st_nlink > 0) return descriptor;
        ::close(descriptor);
    }
    errno = EEXIST;
    return -1;
}

}  // namespace

WriteTarget writeTarget(const std::string& given) {
    if (given.empty()) refuse(given, "the name is empty; give a file name");
    const fs::path path = followed(given);
    const std::string folder = folderOf(path).string();
    struct stat status {};
    if (path.filename().empty() || (::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)))
        refuse(given, "it is a directory; give a file name");
    if (status.st_mode != 0 && !S_ISREG(status.st_mode))
        refuse(given, "it is a device or a pipe, and no regular file; give a file name");
    struct stat parent {};
    if (::stat(folder.c_str(), &parent) != 0 && errno == ENOENT)
        refuse(given,
               fmt::format("the directory '{}' does not exist ({}); create it first", folder, std::strerror(ENOENT)));
    if (parent.st_mode != 0 && !S_ISDIR(parent.st_mode)) refuse(given, fmt::format("'{}' is not a directory", folder));
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        refuse(given, fmt::format("the directory '{}' cannot be written to ({}); choose another", folder,
                                  std::strerror(errno)));
    if (path.filename().string().size() > 255)
        refuse(given, fmt::format("the name has {} bytes, and 255 is the limit", path.filename().string().size()));
    if (status.st_mode == 0) return {path.string(), false, 0666};
    if (::access(path.c_str(), W_OK) != 0)
        refuse(given,
               fmt::format("the file is write-protected ({}); remove it or choose another name", std::strerror(errno)));
    return {path.string(), true, static_cast<unsigned>(status.st_mode & 0777)};
}

std::vector<std::string> removeLeftovers(const std::string& target) {
    const fs::path path(target);
    const std::string name = path.filename().string();
    std::vector<std::string> removed;
    std::error_code failure;
    for (fs::directory_iterator entry(folderOf(path), failure), end; !failure && entry != end;
         entry.increment(failure)) {
        const auto leftover = leftoverNamed(entry->path().filename().string(), name);
        if (leftover && removeIfDead(entry->path(), *leftover)) removed.push_back(entry->path().string());
    }
    return removed;
}

PendingFile::PendingFile(const std::string& path) : path_(path), target_(writeTarget(path)) {
    removeLeftovers(target_.path);
    // What replaces a private file is private from its first byte on.
    descriptor_ = createTemporary(target_.path, target_.exists ? 0600 : 0666, temporary_);
    if (descriptor_ < 0) refuse(path_, fmt::format("{}; choose another place", std::strerror(errno)));
    if (!target_.exists) return;
    struct stat old {};
    // Another owner's file keeps its owner where that is allowed; permissions come last, for a new owner clears some.
    if (::stat(target_.path.c_str(), &old) == 0 && ::fchown(descriptor_, old.st_uid, old.st_gid) != 0)
        static_cast<void>(::fchown(descriptor_, static_cast<uid_t>(-1), old.st_gid) == 0);
    static_cast<void>(::fchmod(descriptor_, target_.mode));  // a file system without permissions
}

PendingFile::~PendingFile() {
    // Removed while it is still locked: nobody else looks after it meanwhile.
    if (!committed_ && !temporary_.empty()) ::unlink(temporary_.c_str());
    if (!kept_.empty()) ::unlink(kept_.c_str());
    if (descriptor_ >= 0) ::close(descriptor_);
    if (kept_descriptor_ >= 0) ::close(kept_descriptor_);
}

int PendingFile::flush() {
    // A file system without fsync says EINVAL.
    return ::fsync(descriptor_) != 0 && errno != EINVAL ? errno : 0;
}

void PendingFile::keepOld() {
    if (!target_.exists || !kept_.empty()) return;
    kept_descriptor_ = ::open(target_.path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (kept_descriptor_ >= 0) ::flock(kept_descriptor_, LOCK_EX | LOCK_NB);
    const fs::path target(target_.path);
    const std::string name =
        (target.parent_path() /
         fmt::format("{}{}-{:016x}.tmp", temporaryStem(target.filename().string()), machineMark(), randomNumber()))
            .string();
    if (::link(target_.path.c_str(), name.c_str()) == 0) kept_ = name;
}

int PendingFile::commit() {
    if (::rename(temporary_.c_str(), target_.path.c_str()) != 0) return errno;
    committed_ = true;
    return 0;
}

void PendingFile::undo() {
    if (!committed_) return;
    if (!kept_.empty() && ::rename(kept_.c_str(), target_.path.c_str()) == 0) {
        kept_.clear();
    } else if (!target_.exists) {
        ::unlink(target_.path.c_str());
    }
}

void flushFolderOf(const std::string& path) {
    const int folder = ::open(folderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;
    ::fsync(folder);
    ::close(folder);
}

}  // namespace photic
