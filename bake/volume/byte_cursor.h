// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace photic {

/// What is wrong with a file, in words that follow "cannot read a.vdb: ".
class VolumeFault : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Goes through bytes from the front and never past their end.
class ByteCursor {
public:
    ByteCursor(const char* data, std::size_t size) : data_(data), size_(size) {}

    std::size_t position() const { return position_; }
    std::size_t left() const { return size_ - position_; }

    /// The place of the next `count` bytes, which are passed over. @throws
    /// VolumeFault where there are fewer
    std::size_t pass(std::size_t count) {
        if (count > left()) throw VolumeFault("it ends too soon; write or copy it again");
        const std::size_t at = position_;
        position_ += count;
        return at;
    }
    const char* take(std::size_t count) { return data_ + pass(count); }
    template <class Number>
    Number number() {
        Number value;
        std::memcpy(&value, take(sizeof(value)), sizeof(value));
        return value;
    }
    /// Characters behind their count.
    std::string text() {
        const auto length = number<std::uint32_t>();
        return std::string(take(length), length);
    }
    void seek(std::size_t position) {
        if (position > size_) throw VolumeFault("it ends too soon; write or copy it again");
        position_ = position;
    }

private:
    const char* data_;
    std::size_t size_, position_ = 0;
};

}  // namespace photic
