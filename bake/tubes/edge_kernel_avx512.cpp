// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA avx512
#include "bake/tubes/edge_kernel_impl.h"
#include "bake/tubes/row_trace_impl.h"
#include "bake/tubes/tile_sums_impl.h"

namespace photic::avx512 {

TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux, TubeDensity density) {
    return {selectKernel(lanes, irradiance_channels, flux, density), runningSums, copyLeaf};
}

RowTracer rowTracerHere() { return traceRow; }

}  // namespace photic::avx512
