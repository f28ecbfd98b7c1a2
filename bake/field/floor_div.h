// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

/// a / b rounded down, also where a < 0; b > 0.
constexpr int floorDiv(int a, int b) { return a / b - (a % b < 0); }

}  // namespace photic
