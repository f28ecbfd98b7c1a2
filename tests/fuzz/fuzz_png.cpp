// SPDX-License-Identifier: Apache-2.0
// 16-bit PNGs. Their chunks end in checksums, which no blind change would meet: the mutator below mends them.
#include <zlib.h>
#include <cstring>
#include <vector>

#include "bake/image/image.h"
#include "tests/fuzz/fuzzed.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

std::uint32_t number(const std::uint8_t* at) {
    return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 | at[3];
}

void mendChecksums(std::uint8_t* data, std::size_t size) {
    for (std::size_t at = 8; at + 12 <= size;) {
        const std::size_t length = number(data + at);
        if (length > size - at - 12) return;
        const auto sum = static_cast<std::uint32_t>(crc32(0, data + at + 4, static_cast<uInt>(length + 4)));
        for (int i = 0; i < 4; ++i)
            data[at + 8 + length + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
        at += length + 12;
    }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    size = LLVMFuzzerMutate(data, size, most);
    if (seed % 8 != 0) mendChecksums(data, size);
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static photic::fuzz::MemoryFile file;
    file.hold(data, size);
    photic::fuzz::refusedOrRead([&] {
        const photic::HeightMap map = photic::readPng16(file.path());
        photic::fuzz::demand(map.values.size() ==
                             static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
    });
    return 0;
}
