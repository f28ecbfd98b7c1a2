// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/edge_kernel_impl.h"
#include "bake/deposit/tile_sums_impl.h"

namespace photic::PHOTIC_ISA {

TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux) {
    return {selectKernel(lanes, irradiance_channels, flux), runningSums, copyLeaf};
}

}  // namespace photic::PHOTIC_ISA
