// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set (cmake/photic_kernels.cmake).
#include "bake/numerics/march_kernel_impl.h"

namespace photic::PHOTIC_ISA {

void solveBlockHere(LocalBlock& block) { solveBlock(block); }

}  // namespace photic::PHOTIC_ISA
