// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>

#include "runtime/src/guarded.h"

namespace photic::runtime {

static_assert(std::endian::native == std::endian::little, "NanoVDB files are little-endian");

/// Bytes of a file, read by offset. `what` names them in errors. No read goes past the end, and none needs alignment.
class Bytes {
public:
    /// Of memory that lives longer.
    Bytes(const unsigned char* data, std::uint64_t size, std::string what)
        : data_(data), size_(size), what_(std::move(what)) {}
    /// Of memory that is kept as long as it or any part of it is there.
    Bytes(std::shared_ptr<const unsigned char[]> data, std::uint64_t size, std::string what)
        : kept_(std::move(data)), data_(kept_.get()), size_(size), what_(std::move(what)) {}

    std::uint64_t size() const { return size_; }

    /// @throws Failure{Format} unless `count` elements of `stride` bytes at `offset` are there
    void require(std::uint64_t offset, std::uint64_t count, std::uint64_t stride, const char* of) const {
        if (offset > size_ || (stride != 0 && count > (size_ - offset) / stride)) {
            fail(ErrorCode::Format, what_ + ": " + of + " lies at byte " + std::to_string(offset) + " of " +
                                        std::to_string(size_) + " and does not fit; the file is cut short or damaged");
        }
    }

    template <class T>
    T read(std::uint64_t offset, const char* of) const {
        require(offset, 1, sizeof(T), of);
        return get<T>(offset);
    }

    /// Of what require() has been asked about before.
    template <class T>
    T get(std::uint64_t offset) const {
        T value;
        std::memcpy(&value, data_ + offset, sizeof(T));
        return value;
    }

    Bytes part(std::uint64_t offset, std::uint64_t size, std::string what) const {
        require(offset, size, 1, what.c_str());
        Bytes out(data_ + offset, size, std::move(what));
        out.kept_ = kept_;
        return out;
    }

    /// Text up to its terminating zero.
    /// @throws Failure{Format} when there is none within `size` bytes
    std::string text(std::uint64_t offset, std::uint64_t size, const char* of) const {
        require(offset, size, 1, of);
        const void* end = std::memchr(data_ + offset, 0, static_cast<std::size_t>(size));
        if (!end) fail(ErrorCode::Format, what_ + ": " + of + " has no end; the file is damaged");
        return {reinterpret_cast<const char*>(data_ + offset), static_cast<const char*>(end)};
    }

    const char* characters(std::uint64_t offset) const { return reinterpret_cast<const char*>(data_ + offset); }
    const std::string& what() const { return what_; }

    std::span<const unsigned char> view(std::uint64_t offset, std::uint64_t size) const {
        return {data_ + offset, static_cast<std::size_t>(size)};
    }

private:
    std::shared_ptr<const unsigned char[]> kept_;
    const unsigned char* data_;
    std::uint64_t size_;
    std::string what_;
};

}  // namespace photic::runtime
