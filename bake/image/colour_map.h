// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

namespace photic {

/// Colour maps for scalar pictures. Magma and Viridis are perceptually uniform (lightness grows evenly with the value);
/// BlueRed diverges from a light grey at 1/2, for signed differences.
enum class ColourMap { Magma, Viridis, BlueRed };

/// Display-referred sRGB, 0..1, of a value 0..1 (clamped; NaN gives pure green, which no map contains).
std::array<float, 3> colourOf(ColourMap map, double value);

/// "magma", "viridis", "blue_red", in the order of the enum.
const std::vector<std::string>& colourMapNames();

}  // namespace photic
