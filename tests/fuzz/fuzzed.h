// SPDX-License-Identifier: Apache-2.0
// What the targets share: each hands the bytes to a reader, which may refuse them with an Error that says something,
// and do nothing else.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "bake/report/error.h"

namespace photic::fuzz {

inline void demand(bool holds) {
    if (!holds) std::abort();
}

/// Runs `read`; an Error must have words, and no other exception may come out.
template <typename Read>
void refusedOrRead(const Read& read) {
    try {
        read();
    } catch (const Error& error) {
        demand(std::string(error.what()).size() > 3);
    }
}

/// A file in memory, for readers that take a path.
class MemoryFile {
public:
    MemoryFile() : descriptor_(memfd_create("fuzzed", 0)) { demand(descriptor_ >= 0); }
    ~MemoryFile() { close(descriptor_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
    void hold(const std::uint8_t* data, std::size_t size) {
        demand(ftruncate(descriptor_, 0) == 0);
        demand(pwrite(descriptor_, data, size, 0) == static_cast<ssize_t>(size));
    }

private:
    int descriptor_;
};

}  // namespace photic::fuzz
