// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/image/image.h"

namespace photic {

/// Says in `map.flaws` when its heights are those of an 8-bit picture in a larger type: every value is a whole number
/// of 1/255, or of 1/256 as a shift by eight bits makes them, and they are not all the same.
void noteEightBits(HeightMap& map);

}  // namespace photic
