// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/edge_kernel.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux))

TileKernels tileKernels(InstructionSet set, int lanes, int irradiance_channels, bool flux) {
    return PHOTIC_CHOOSE(set, kernelsFor)(lanes, irradiance_channels, flux);
}

}  // namespace photic
