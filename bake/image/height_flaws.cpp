// SPDX-License-Identifier: Apache-2.0
#include "bake/image/height_flaws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace photic {
namespace {

/// All values lie in 0 to 1 and are whole numbers of 1 / steps.
bool inSteps(const std::vector<float>& values, double steps) {
    constexpr double kRounding = 1e-3;  // of a step, more than floats between 0 and 1 leave of it
    return std::all_of(values.begin(), values.end(), [&](float value) {
        const double place = static_cast<double>(value) * steps;
        return place >= 0 && place <= steps && std::fabs(place - std::round(place)) < kRounding;
    });
}

}  // namespace

void noteEightBits(HeightMap& map) {
    if (map.values.empty()) return;
    const auto [low, high] = std::minmax_element(map.values.begin(), map.values.end());
    // 0 and 1 alone are heights that somebody drew.
    const bool varied =
        *low < *high && std::any_of(map.values.begin(), map.values.end(), [](float v) { return v != 0 && v != 1; });
    if (!varied) return;
    // Stretched so that the last step is 1, or moved up by whole bits.
    for (const int bits : {8, 10, 12}) {
        const int steps = 1 << bits;
        if (!inSteps(map.values, steps - 1) && !inSteps(map.values, 65535.0 / (65536 >> bits))) continue;
        constexpr double kOfEightBits = 11;  // [%]
        const double off = kOfEightBits * 256 / steps;
        map.flaws.push_back(fmt::format(
            "has the {} heights of a picture of {} bits, stored in a larger type: its steps will be seen as "
            "caustics (slopes are off by about {} %); make it anew with 16 bits or floats",
            steps, bits, off < 1 ? fmt::format("{:.1f}", off) : fmt::format("{:.0f}", off)));
        return;
    }
}

}  // namespace photic
