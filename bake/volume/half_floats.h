// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace photic {

/// Half floats of a row of floats, rounded to nearest even, and back, as
/// OpenVDB does it.
struct HalfConversion {
    void (*toHalf)(const float* from, std::size_t count, std::uint16_t* to);
    /// `from` need not be aligned: it may lie anywhere in a file.
    void (*toFloat)(const char* from, std::size_t count, float* to);
};

/// For the best instruction set of this processor.
HalfConversion halfConversion();

}  // namespace photic
