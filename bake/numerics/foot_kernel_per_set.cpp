// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include "bake/numerics/foot_kernel_impl.h"

namespace photic::PHOTIC_ISA {

FootKernels footKernelsHere() { return {guessFootRow, solveFootRow, footRowImprovable}; }

}  // namespace photic::PHOTIC_ISA
