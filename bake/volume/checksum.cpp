// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/checksum.h"

#include <cstring>

namespace photic {
namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t word) {
    hash = (hash ^ word) * 0xff51afd7ed558ccdull;
    return hash ^ hash >> 32;
}
std::uint64_t wordAt(const char* data, std::size_t bytes = 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, data, bytes);
    return word;
}

}  // namespace

std::uint64_t checksum(const char* data, std::size_t size, std::uint64_t seed) {
    std::uint64_t chains[4] = {seed ^ 0x9e3779b97f4a7c15ull, seed + 1, seed + 2, seed + 3};
    std::size_t at = 0;
    for (; at + 32 <= size; at += 32)
        for (std::size_t c = 0; c < 4; ++c) chains[c] = mixed(chains[c], wordAt(data + at + 8 * c));
    std::uint64_t hash = mixed(chains[0], size);
    for (std::size_t c = 1; c < 4; ++c) hash = mixed(hash, chains[c]);
    for (; at + 8 <= size; at += 8) hash = mixed(hash, wordAt(data + at));
    return at < size ? mixed(hash, wordAt(data + at, size - at)) : hash;
}

}  // namespace photic
