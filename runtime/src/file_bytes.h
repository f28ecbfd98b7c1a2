// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace photic::runtime {

/// A file's bytes. Not a vector, which would clear them before they are read.
struct FileBytes {
    std::unique_ptr<unsigned char[]> data;
    std::size_t size = 0;
};

/// A whole file. @throws Failure{File} when it cannot be read, Failure{Limit} when it has more than `largest` bytes
FileBytes readFile(const std::string& path, std::uint64_t largest);

}  // namespace photic::runtime
