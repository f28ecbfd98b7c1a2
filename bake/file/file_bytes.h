// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace photic {

/// All bytes of a file, read by several threads: a copy out of the system's cache is what it costs.
class FileBytes {
public:
    /// @throws Error{Input} when it is missing, no regular file, larger than memory, or changes meanwhile
    explicit FileBytes(const std::string& path);
    const char* data() const { return data_.get(); }
    std::size_t size() const { return size_; }

private:
    bool readAll(int descriptor, std::size_t at, std::size_t end);

    std::unique_ptr<char[]> data_;
    std::size_t size_ = 0;
};

}  // namespace photic
