// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace photic {

/// Tells bytes apart that a disk or a wire may have changed; proves nothing against somebody who means to deceive.
/// Four chains of multiply and fold, eight bytes each at a time, at the speed of memory.
std::uint64_t checksum(const char* data, std::size_t size, std::uint64_t seed = 0);

}  // namespace photic
