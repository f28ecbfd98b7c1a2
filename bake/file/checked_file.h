// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <ostream>
#include <streambuf>
#include <string>
#include <vector>

#include "bake/image/pending_file.h"

namespace photic {

/// A stream buffer over a file descriptor that remembers why a write failed, counts bytes, and hashes them.
/// Seekable: OpenVDB goes back to fill in the offsets of its grids.
class CheckedFileBuffer : public std::streambuf {
public:
    explicit CheckedFileBuffer(int descriptor);

    /// errno of the first write that failed; 0: none.
    int failure() const { return failure_; }
    /// Bytes of the file so far, buffered ones included.
    std::int64_t size() const;
    /// Of everything written at `kHashedFrom` or later, in the order of writing.
    std::uint64_t hash() const { return hash_; }
    /// Writes what is buffered. False on failure.
    bool flush();

    static constexpr std::int64_t kHashedFrom = 64;  ///< beyond OpenVDB's header, which holds a random number

protected:
    int_type overflow(int_type c) override;
    std::streamsize xsputn(const char* data, std::streamsize count) override;
    int sync() override { return flush() ? 0 : -1; }
    pos_type seekoff(off_type offset, std::ios_base::seekdir direction, std::ios_base::openmode which) override;
    pos_type seekpos(pos_type position, std::ios_base::openmode which) override;

private:
    bool writeAll(const char* data, std::size_t count);

    int descriptor_, failure_ = 0;
    std::int64_t position_ = 0, end_ = 0;  // where the buffer's first byte goes; largest position written
    std::uint64_t hash_ = 0x9e3779b97f4a7c15ull;
    std::vector<char> buffer_;
};

/// A file under a temporary name beside its target. Unless commit() succeeds, the target is untouched and the
/// temporary file goes with this object.
class CheckedFile {
public:
    /// @throws Error{Failed} when it cannot be created
    explicit CheckedFile(const std::string& path);

    /// Throws std::ios_base::failure when a write fails.
    std::ostream& stream() { return stream_; }
    CheckedFileBuffer& buffer() { return buffer_; }
    const std::string& path() const { return file_.path(); }
    const std::string& temporaryPath() const { return file_.temporaryPath(); }
    PendingFile& pending() { return file_; }
    bool finished() const { return finished_; }
    /// Bytes of the file so far, those that are buffered included.
    std::int64_t size() const { return std::max(buffer_.size(), end_.load()); }

    /// Writes bytes at a place of their own, which the stream leaves alone. Thread-safe. @throws Error{Failed}
    void writeAt(std::int64_t position, const char* data, std::size_t count);
    /// Flushes to the disk and checks that every byte has arrived; nothing is written after that. @throws Error{Failed}
    void finish();
    /// Overwrites bytes near the file's beginning, after finish(). @throws Error{Failed}
    void patch(std::int64_t position, const std::string& bytes);
    /// Renames to the target. @throws Error{Failed}
    void commit();
    /// The error for a failed write: the system's reason, with a remedy.
    [[noreturn]] void fail(int error_number) const;

private:
    PendingFile file_;
    bool finished_ = false;
    std::atomic<std::int64_t> end_{0};  // of what writeAt() wrote
    CheckedFileBuffer buffer_;
    std::ostream stream_;
};

}  // namespace photic
