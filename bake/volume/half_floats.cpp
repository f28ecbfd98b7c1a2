// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/half_floats.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(HalfConversion halfConversionHere())

HalfConversion halfConversion() { return PHOTIC_CHOOSE(bestInstructionSet(), halfConversionHere)(); }

}  // namespace photic
