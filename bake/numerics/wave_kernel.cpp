// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_kernel.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(extern const WaveKernels kWaveKernels)

const WaveKernels& waveKernels(InstructionSet set) { return PHOTIC_CHOOSE(set, kWaveKernels); }

const WaveKernels& waveKernels() { return waveKernels(bestInstructionSet()); }

}  // namespace photic
