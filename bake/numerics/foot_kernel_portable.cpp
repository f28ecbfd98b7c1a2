// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA portable
#include "bake/numerics/foot_kernel_impl.h"

namespace photic::portable {

FootKernels footKernelsHere() { return {guessFootRow, solveFootRow, footRowImprovable}; }

}  // namespace photic::portable
