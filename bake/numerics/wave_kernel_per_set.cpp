// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include "bake/numerics/wave_kernel_impl.h"

namespace photic::PHOTIC_ISA {

#define PHOTIC_TEXT_(x) #x
#define PHOTIC_TEXT(x) PHOTIC_TEXT_(x)

extern const WaveKernels kWaveKernels;
const WaveKernels kWaveKernels{
    {{stepRows<WaveSum::Nothing, false>, stepRows<WaveSum::Energy, false>, stepRows<WaveSum::EnergyAndFlux, false>},
     {stepRows<WaveSum::Nothing, true>, stepRows<WaveSum::Energy, true>, stepRows<WaveSum::EnergyAndFlux, true>}},
    {stepPadded<WaveSum::Nothing, true>, stepPadded<WaveSum::Energy, true>, stepPadded<WaveSum::EnergyAndFlux, true>},
    stepMatched,
    stepSponge,
    halves,
    PHOTIC_TEXT(PHOTIC_ISA)};

}  // namespace photic::PHOTIC_ISA
