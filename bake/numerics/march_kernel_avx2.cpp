// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA avx2
#include "bake/numerics/march_kernel_impl.h"

namespace photic::avx2 {

void solveBlockHere(LocalBlock& block) { solveBlock(block); }

}  // namespace photic::avx2
