// SPDX-License-Identifier: Apache-2.0
#include "bake/file/checked_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "bake/report/error.h"

namespace photic {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 20;

// A quick hash of bytes in order (multiply and fold, eight at a time); tells files apart, proves nothing.
std::uint64_t hashed(std::uint64_t hash, const char* data, std::size_t count) {
    const auto mix = [&hash](std::uint64_t word) {
        hash = (hash ^ word) * 0xff51afd7ed558ccdull;
        hash ^= hash >> 32;
    };
    for (; count >= 8; data += 8, count -= 8) {
        std::uint64_t word;
        std::memcpy(&word, data, 8);
        mix(word);
    }
    std::uint64_t rest = count;
    std::memcpy(&rest, data, count);
    if (count > 0) mix(rest ^ count << 56);
    return hash;
}

}  // namespace

CheckedFileBuffer::CheckedFileBuffer(int descriptor) : descriptor_(descriptor), buffer_(kBuffer) {
    setp(buffer_.data(), buffer_.data() + buffer_.size());
}

std::int64_t CheckedFileBuffer::size() const { return std::max(end_, position_ + (pptr() - pbase())); }

bool CheckedFileBuffer::writeAll(const char* data, std::size_t count) {
    const std::size_t skipped = static_cast<std::size_t>(
        std::clamp<std::int64_t>(kHashedFrom - position_, 0, static_cast<std::int64_t>(count)));
    hash_ = hashed(hash_, data + skipped, count - skipped);
    while (count > 0) {
        const ssize_t n = ::write(descriptor_, data, count);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            if (failure_ == 0) failure_ = n < 0 ? errno : ENOSPC;
            return false;
        }
        data += n, count -= static_cast<std::size_t>(n), position_ += n;
    }
    end_ = std::max(end_, position_);
    return true;
}

bool CheckedFileBuffer::flush() {
    if (failure_ != 0) return false;
    const auto count = static_cast<std::size_t>(pptr() - pbase());
    setp(buffer_.data(), buffer_.data() + buffer_.size());
    return writeAll(buffer_.data(), count);
}

CheckedFileBuffer::int_type CheckedFileBuffer::overflow(int_type c) {
    if (!flush()) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) {
        *pptr() = traits_type::to_char_type(c);
        pbump(1);
    }
    return traits_type::not_eof(c);
}

std::streamsize CheckedFileBuffer::xsputn(const char* data, std::streamsize count) {
    if (count > epptr() - pptr()) {
        if (!flush()) return 0;
        if (static_cast<std::size_t>(count) >= buffer_.size())
            return writeAll(data, static_cast<std::size_t>(count)) ? count : 0;
    }
    std::memcpy(pptr(), data, static_cast<std::size_t>(count));
    pbump(static_cast<int>(count));
    return count;
}

CheckedFileBuffer::pos_type CheckedFileBuffer::seekoff(off_type offset, std::ios_base::seekdir direction,
                                                       std::ios_base::openmode which) {
    const std::int64_t here = position_ + (pptr() - pbase());
    if (direction == std::ios_base::cur && offset == 0) return here;
    const std::int64_t base = direction == std::ios_base::cur ? here : direction == std::ios_base::end ? size() : 0;
    return seekpos(base + offset, which);
}

CheckedFileBuffer::pos_type CheckedFileBuffer::seekpos(pos_type position, std::ios_base::openmode) {
    if (!flush() || ::lseek(descriptor_, position, SEEK_SET) < 0) return pos_type(off_type(-1));
    position_ = position;
    return position;
}

CheckedFile::CheckedFile(const std::string& path) : file_(path), buffer_(file_.descriptor()), stream_(&buffer_) {
    stream_.exceptions(std::ios::badbit | std::ios::failbit);
}

void CheckedFile::fail(int error_number) const {
    const char* remedy = error_number == ENOSPC || error_number == EDQUOT ? "; free some space or write elsewhere"
                         : error_number == EFBIG ? "; raise the limit on file sizes or write elsewhere"
                                                 : "";
    throw Error(ErrorCode::Failed,
                fmt::format("cannot write {}: {} after {} MiB{}; an existing file was left as it was", path(),
                            error_number != 0 ? std::strerror(error_number) : "the file is not what was written",
                            size() >> 20, remedy),
                path());
}

void CheckedFile::writeAt(std::int64_t position, const char* data, std::size_t count) {
    const std::int64_t end = position + static_cast<std::int64_t>(count);
    while (count > 0) {
        const ssize_t n = ::pwrite(file_.descriptor(), data, count, position);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail(n < 0 ? errno : ENOSPC);
        data += n, count -= static_cast<std::size_t>(n), position += n;
    }
    for (std::int64_t seen = end_; seen < end && !end_.compare_exchange_weak(seen, end);) {
    }
}

void CheckedFile::finish() {
    if (finished_) return;
    if (!buffer_.flush()) fail(buffer_.failure());
    if (const int reason = file_.flush()) fail(reason);
    struct stat status {};
    if (::fstat(file_.descriptor(), &status) != 0) fail(errno);
    if (status.st_size != size()) fail(0);
    finished_ = true;
}

void CheckedFile::patch(std::int64_t position, const std::string& bytes) {
    if (::pwrite(file_.descriptor(), bytes.data(), bytes.size(), position) != static_cast<ssize_t>(bytes.size()))
        fail(errno);
    if (const int reason = file_.flush()) fail(reason);
}

void CheckedFile::commit() {
    if (const int reason = file_.commit()) fail(reason);
    flushFolderOf(file_.target().path);
}

}  // namespace photic
