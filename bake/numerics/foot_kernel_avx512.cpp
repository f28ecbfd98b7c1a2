// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA avx512
#include "bake/numerics/foot_kernel_impl.h"

namespace photic::avx512 {

FootKernels footKernelsHere() { return {guessFootRow, solveFootRow, footRowImprovable}; }

}  // namespace photic::avx512
